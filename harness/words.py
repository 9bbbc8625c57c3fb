"""A study and its verdicts in words: what was run, what errors are, why a verdict is as it is."""

from typing import Any

import pandas as pd

from harness.case import SchemeOptions
from harness.floors import floor_lines
from harness.quantities import norm
from harness.schemes import named_scheme
from harness.selection import exclusions
from harness.study import Study
from harness.verdict import Verdict

ALWAYS_TOLD = ("name", "degree", "bdf", "project", "theta")  # of a scheme; the rest if unusual
PROJECTIONS = {True: "on", False: "off", "nu": "of nu alone"}


def remarks(
    study: Study, records: pd.DataFrame, floors: pd.DataFrame, verdicts: list[Verdict]
) -> list[str]:
    """What explains the verdicts: reasons, next runs, masked runs, floors, what was not judged."""
    return [
        *reasons(verdicts),
        *(f"{v.variable}, next run: {v.next_run}" for v in verdicts if v.next_run),
        *masked_lines(verdicts),
        *floor_lines(floors, study.variables),
        *exclusions(study, records),
    ]


def reasons(verdicts: list[Verdict]) -> list[str]:
    """Why: a line a reason, with the variables that it holds for."""
    shown: dict[str, list[str]] = {}
    for verdict in verdicts:
        shown.setdefault(verdict.reason, []).append(verdict.variable)
    return [f"{', '.join(names)}: {reason}" for reason, names in shown.items()]


def masked_lines(verdicts: list[Verdict]) -> list[str]:
    """The runs that were masked for a floor or for the other parameter, a line a variable; those
    that stopped early are told by `harness.selection.exclusions`."""
    lines = []
    for verdict in verdicts:
        masked = [m for m in verdict.masked if m.floor or "of the error" in m.reason]
        if masked:
            runs = "; ".join(f"h = {m.h:.3g}, tau = {m.tau:g}: {m.reason}" for m in masked)
            lines.append(f"{verdict.variable} masked: {runs}")
    return lines


def norms(study: Study) -> str:
    """What the errors in the tables are, in words."""
    solution = study.solution.initial()
    shown: dict[str, list[str]] = {}
    for name in study.variables:
        shown.setdefault(norm(name, solution), []).append(name)
    return "; ".join(f"{', '.join(names)}: {words}" for words, names in shown.items())


def describe(study: Study) -> str:
    """The case in one line: solution, law, scheme, final time."""

    def named(name: str, parameters: dict[str, Any]) -> str:
        values = ", ".join(
            f"{key} = {value}" if isinstance(value, str) else f"{key} = {value:g}"
            for key, value in parameters.items()
        )
        return f"{name} ({values})" if values else name

    return (
        f"solution {named(study.solution.name, study.solution.parameters)}, "
        f"law {named(study.law.name, study.law.parameters)}, "
        f"scheme {', '.join(options(study.scheme))}"
        f"{study.sweep.said_of_first_steps(study.scheme.order)}, T = {study.sweep.final_time:g}"
    )


def options(scheme: SchemeOptions) -> list[str]:
    """The name and the options of a scheme, as far as it has them."""
    found = [f"{scheme.name}: P{scheme.degree}"]
    if hasattr(scheme, "bdf"):
        found.append(f"BDF{scheme.bdf}")
    if hasattr(scheme, "project"):
        found.append(f"projection {PROJECTIONS[scheme.project]}")
    if hasattr(scheme, "theta"):
        found.append(f"theta {'on' if scheme.theta else 'off'}")
    for name, field in type(scheme).model_fields.items():
        value = getattr(scheme, name)
        if name not in ALWAYS_TOLD and value != field.default:
            found.append(f"{name} {value}")
    return found


def headings(study: Study) -> dict[str, str]:
    """What stands above the errors of each variable: it says what was recovered, not solved for."""
    recovered = named_scheme(study.scheme.name).recovered
    found = {}
    for name in study.variables:
        marked = name in recovered or (name == "W" and "H" in recovered)
        found[name] = f"{name} (recovered)" if marked else name
    return found


def one_line(text: str) -> str:
    """The text with every run of blanks and line ends as one blank: no line escapes a comment."""
    return " ".join(text.split())
