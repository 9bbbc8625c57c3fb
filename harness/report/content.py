"""What a report says, as plain tables: the same for HTML and LaTeX."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field

import pandas as pd

from esfem.common.provenance import command, dependencies, machine, numerics_digest, version
from esfem.judging.outcome import SEVERITY, Outcome
from esfem.report.results_folder import ResultsFolder, Sentence
from esfem.results.study_result import StudyResult
from esfem.results.verdicts import Verdict

MISSING = ("", "-")
SHORT = 32  # letters of an entry that is kept on one line
HOLDS: tuple[Outcome, ...] = ("pass", "super")


@dataclass(frozen=True)
class Table:
    """A table of strings with its title; ``tells`` explains it in a sentence, ``name`` is part of
    its anchor; what is not ``leading`` may be folded away."""

    name: str
    title: str
    frame: pd.DataFrame
    _: KW_ONLY
    tells: str = ""
    leading: bool = True

    @property
    def classes(self) -> list[str]:
        """Of each column: "n" for numbers, "t" for short texts, that are not broken, "" else."""
        return [_class([str(entry) for entry in self.frame[name]]) for name in self.frame]


def _class(entries: Sequence[str]) -> str:
    filled = [entry for entry in entries if entry not in MISSING]
    if filled and all(is_number(entry) for entry in filled):
        return "n"
    return "t" if max(map(len, entries), default=0) <= SHORT else ""


def is_number(text: str) -> bool:
    """Whether an entry of a table is a number, or a share in per cent."""
    try:
        float(text.removesuffix(" %"))
    except ValueError:
        return False
    return True


@dataclass(frozen=True)
class Summary:
    """``headline`` is the answer in one line; ``counts`` are of studies by their verdict, ``of``
    those of variables, ``flows`` and ``sentences`` likewise."""

    headline: str
    counts: dict[Outcome, int]
    of_variables: dict[Outcome, int]
    flows: dict[Outcome, int] = field(default_factory=dict)
    sentences: dict[Outcome, int] = field(default_factory=dict)


def counted(outcomes: Sequence[Outcome]) -> dict[Outcome, int]:
    """How many there are of each outcome, worst first."""
    found = Counter(outcomes)
    return {name: found[name] for name in reversed(SEVERITY) if found[name]}


def summary(results: ResultsFolder) -> Summary:
    """The verdicts on everything, counted."""
    studies = counted([result.outcome for result in results.studies])
    flows = counted([flow.outcome for flow in results.flows])
    sentences = counted([sentence.verdict for sentence in results.sentences])
    variables = counted([v.verdict for result in results.studies for v in result.verdicts])
    parts = {"studies": studies, "flows": flows, "sentences": sentences}
    said = [_said(name, counts) for name, counts in parts.items() if counts]
    headline = "; ".join(said) or "nothing was judged"
    return Summary(headline[0].upper() + headline[1:], studies, variables, flows, sentences)


def _said(name: str, counts: dict[Outcome, int]) -> str:
    """For example "14 of 16 studies hold, 1 FAIL, 1 INCONCLUSIVE"."""
    total, holds = sum(counts.values()), sum(counts.get(outcome, 0) for outcome in HOLDS)
    rest = [f"{n} {outcome.upper()}" for outcome, n in counts.items() if outcome not in HOLDS]
    verb = "hold" if holds != 1 else "holds"
    first = (
        f"all {total} {name} hold" if holds == total > 1 else f"{holds} of {total} {name} {verb}"
    )
    return ", ".join([first, *rest])


def chip(verdict: Verdict) -> dict[str, str]:
    """A verdict in a few characters: variable, order and interval, the error and its limit; no
    order where a limit alone is claimed."""
    bounded, value = verdict.limit == verdict.limit, []
    ordered = not bounded or verdict.expected == verdict.expected
    if ordered and verdict.observed == verdict.observed:
        value.append(f"{verdict.observed:.2f} [{verdict.lower:.2f}, {verdict.upper:.2f}]")
    if bounded:
        sign = "≤" if verdict.error <= verdict.limit else ">"
        value.append(f"{verdict.error:.1e} {sign} {verdict.limit:g}")
    if verdict.deciding.name == "interpolation":
        value.append("against the interpolation")
    outcome = verdict.verdict.upper()
    return {"variable": verdict.variable, "outcome": outcome, "value": ", ".join(value)}


def overview_table(results: ResultsFolder) -> Table:
    """The verdict on each study and flow, a row each."""
    rows = [
        {
            "verdict": result.outcome.upper(),
            "study": f"{result.study.title} ({result.study.name})",
            "claim": result.study.study.claim or "none",
            "by variable": "; ".join(" ".join(chip(v).values()) for v in result.verdicts),
        }
        for result in results.studies
    ]
    rows += [
        {
            "verdict": result.outcome.upper(),
            "study": f"{result.flow.flow.title} (flow {result.flow.name})",
            "claim": "checks",
            "by variable": "; ".join(f"{c.name} {c.verdict.upper()}" for c in result.checks),
        }
        for result in results.flows
    ]
    columns = ["verdict", "study", "claim", "by variable"]
    return Table("overview", "Verdicts by study", pd.DataFrame(rows, columns=columns))


def found(sentence: Sentence) -> str:
    """In which error, what was measured, what was expected, and the note, in one cell."""
    parts = [f"{sentence.error}:"] if sentence.error else []
    parts.append(shown(sentence.measured))
    if expected := shown(sentence.expected):
        parts.append(f"(expected: {expected})")
    if sentence.note:
        parts.append(f"({sentence.note})")
    return " ".join(part for part in parts if part)


def sentences_table(sentences: Sequence[Sentence]) -> Table:
    """The sentences of the paper and what was measured, a row each."""
    rows = [
        {
            "verdict": s.verdict.upper(),
            "section": s.section,
            "sentence": s.quote,
            "measured (expected)": found(s),
            "study": s.study,
            "label": s.label,
        }
        for s in sentences
    ]
    return Table("sentences", "Each sentence with what was measured", pd.DataFrame(rows))


def shown(value: object) -> str:
    """A number with six digits at most, "-" for nothing, a text as it is."""
    if value is None or value != value:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def plain_table(name: str, title: str, rows: Sequence[Mapping[str, object]]) -> Table:
    """A table of given rows, every entry as `shown`; columns in the order they occur."""
    columns = list(dict.fromkeys(column for row in rows for column in row))
    cells = [{column: shown(row.get(column)) for column in columns} for row in rows]
    return Table(name, title, pd.DataFrame(cells, columns=columns))


def own_provenance(results: ResultsFolder) -> dict[str, str]:
    """Which program wrote the report, where, and with which packages."""
    packages = ", ".join(f"{name} {number}" for name, number in dependencies().items())
    return {
        "program": f"esfem-willmore {version()} (numerics {numerics_digest()})",
        "command": command(),
        "machine": machine(),
        "packages": packages,
        "results": _origins(results.studies),
    }


def _origins(studies: Sequence[StudyResult]) -> str:
    """By which programs the shown runs were computed."""
    runs = [result.records[["version", "numerics"]] for result in studies]
    if not runs:
        return "no study"
    origins = pd.concat(runs).value_counts().to_dict()
    return "; ".join(f"{n} runs by {v} (numerics {d})" for (v, d), n in origins.items())
