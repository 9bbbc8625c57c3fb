"""The comparison as JUnit XML, which every CI shows."""

from pathlib import Path

from junitparser import Error, Failure, JUnitXml, TestCase, TestSuite

from esfem.campaigns.baseline.change import Change
from esfem.common.files import whole, writing
from esfem.common.provenance import command, numerics_digest, version


def write_junit(path: Path, changes: dict[str, list[Change]], strict: bool = False) -> None:
    """One suite a study, one case a comparison: worse is a failure, not comparable an error.

    With ``strict`` what is better is a failure too.

    Raises
    ------
    BadInput
        If the file cannot be written.
    """
    xml = JUnitXml("esfem check")
    for study, of_study in changes.items():
        suite = TestSuite(study)
        facts = {"version": version(), "numerics": numerics_digest(), "command": command()}
        for name, value in facts.items():
            suite.add_property(name, value)
        suite.add_testcases([_case(change, strict) for change in of_study])
        xml.add_testsuite(suite)
    with writing(f"--junit {path}"), whole(path) as unfinished:
        xml.write(str(unfinished), pretty=True)


def _case(change: Change, strict: bool) -> TestCase:
    name = f"{change.variable}: {change.what}" if change.variable else f"{change.what} of the study"
    case = TestCase(name, classname=f"esfem.{change.study}", time=0.0)
    text = f"{change.baseline} -> {change.current} {change.amount}; since {change.since}"
    if change.effect == "worse" or (strict and change.effect == "better"):
        case.result = [Failure(text, change.what)]
    elif change.effect == "unknown":
        case.result = [Error(text, change.what)]
    elif change.moved:
        case.system_out = f"{change.effect}: {text}"
    return case
