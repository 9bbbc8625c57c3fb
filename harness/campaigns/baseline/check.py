"""Runs or reads studies, compares them with their baselines, tells what moved: to a person, and as
JUnit XML, which every CI shows."""

from pathlib import Path

import numpy as np
from junitparser import Error, Failure, JUnitXml, TestCase, TestSuite
from rich.console import Console
from rich.text import Text

from esfem.campaigns.baseline.baseline import names_below, read_stored
from esfem.campaigns.baseline.change import Change, Stored, exit_status
from esfem.campaigns.baseline.compare import compare, marked
from esfem.common.bad_input import BadInput
from esfem.common.console import print_table
from esfem.common.files import whole, writing
from esfem.common.provenance import command, numerics_digest, version
from esfem.results.result_files import VERDICTS, not_a_baseline, read_verdicts
from esfem.results.run_studies import run_studies
from esfem.studies.catalogue import default_studies, full_studies, study_path
from esfem.studies.study import Study, load_study

EFFECTS = ("worse", "better", "unknown")


def run_check(
    names: list[str],
    console: Console,
    *,
    baseline: Path,
    out: Path,
    junit: Path | None = None,
    read: bool = False,
    jobs: int | None = None,
    strict: bool = False,
) -> int:
    """Compare studies with their baseline, all that have one if no names: the exit status.

    What moved is printed, by how much and since when, and a line a study.

    Raises
    ------
    BadInput
        If a study has no baseline, or a baseline is damaged.
    """
    studies = chosen(names, baseline)
    before = {study.name: read_stored(baseline / study.name) for study in studies}
    if not read:
        not_a_baseline(out)
        run_studies(studies, out, console, jobs=jobs)
    changes, lines = {}, []
    for name, stored in before.items():
        lacking = read and not (out / name / VERDICTS).exists()
        current = None if lacking else read_stored(out / name)
        changes[name] = _compared(stored, current, out)
        same = current is not None and unchanged(stored, current)
        line = f"{_line(changes[name], same)}; since {stored.since}"
        lines.append(Text.assemble((f"{name}: ", "bold"), line))
    moved = [change for found in changes.values() for change in found if change.moved]
    rows = [(c.effect, c.study, c.variable, c.what, c.amount, c.said) for c in moved]
    print_table(rows, console)
    console.rule(Text("against the baseline", style="bold"), align="left")
    for told in lines:
        console.print(told, soft_wrap=True)
    if junit is not None:
        write_junit(junit, changes, strict)
        console.print(f"JUnit: {junit}", soft_wrap=True)
    return exit_status([change for found in changes.values() for change in found], strict)


def chosen(names: list[str], baseline: Path) -> list[Study]:
    """The studies of these names or files, or all that have a baseline.

    A baseline without a committed study of its name stands for itself.
    """
    having = names_below(baseline)
    if not having:
        raise BadInput(f"--baseline {baseline}: holds no baseline (no STUDY/verdicts.json there)")
    committed = {path.stem: path for path in default_studies() + full_studies()}
    studies = []
    for name in dict.fromkeys(names or having):
        if name in having and name not in committed:
            studies.append(read_verdicts(baseline / name).parameters)
            continue
        studies.append(load_study(study_path(name)))
        if studies[-1].name not in having:
            raise BadInput(f"{name}: has no baseline below {baseline}; there are {having}")
    return studies


def unchanged(baseline: Stored, current: Stored) -> bool:
    """Whether statuses and errors of all runs are bit for bit those of the baseline."""
    columns = [c for c in baseline.records if c.startswith(("err_", "nodal_"))]
    if not set(columns) <= set(current.records) or len(baseline.records) != len(current.records):
        return False
    tables = [
        stored.records.set_index(["vertices", "tau"]).sort_index()[["status", *columns]]
        for stored in (baseline, current)
    ]
    return tables[0].equals(tables[1])


def _line(found: list[Change], same: bool) -> str:
    """What is said of one study."""
    moved = [change for change in found if change.moved]
    counts = {effect: sum(c.effect == effect for c in moved) for effect in EFFECTS}
    if moved:
        said = ", ".join(f"{count} {effect}" for effect, count in counts.items() if count)
        return f"{said}, of {len(found)} comparisons"
    if same:
        return "unchanged"
    return f"within the tolerances, {_largest(found)}"


def _largest(found: list[Change]) -> str:
    """The comparison that used most of its tolerance."""

    def used(change: Change) -> float:
        if change.what == "order":
            return abs(change.by) / change.tolerance
        return float(abs(np.log(change.by)) / np.log(change.tolerance))

    sized = [change for change in found if change.amount]
    if not sized:
        return "which are on verdicts alone"
    change = max(sized, key=used)
    return f"most of all {change.what} of {change.variable}: {change.amount}"


def _compared(baseline: Stored, current: Stored | None, out: Path) -> list[Change]:
    """The comparisons, and what speaks against them."""
    if current is None:
        lacking = Change("results", "stored", f"none below {out}; run without --read")
        return marked([lacking], baseline)
    changes = compare(baseline, current)
    numerics = current.content.numerics
    if numerics == numerics_digest():
        return changes
    stale = f"computed by numerics {numerics}; run without --read"
    return [*marked([Change("code", f"numerics {numerics_digest()}", stale)], baseline), *changes]


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
    text = f"{change.said} {change.amount}; since {change.since}"
    if change.effect == "worse" or (strict and change.effect == "better"):
        case.result = [Failure(text, change.what)]
    elif change.effect == "unknown":
        case.result = [Error(text, change.what)]
    elif change.moved:
        case.system_out = f"{change.effect}: {text}"
    return case
