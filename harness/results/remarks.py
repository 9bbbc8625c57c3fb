"""What explains the verdicts of a study, in words."""

from collections.abc import Sequence
from typing import get_args

import numpy as np
import pandas as pd

from esfem.judging.validate import NO_ERROR
from esfem.measuring.energies import ROUNDING
from esfem.results.error_verdicts import WORDS, ErrorName
from esfem.results.study_result import StudyResult
from esfem.results.verdicts import Verdict
from esfem.runs.loop import Status


def remarks(result: StudyResult) -> list[str]:
    """What explains the verdicts: reasons, next runs, masked runs, floors, what was not judged."""
    return [
        *reasons(result.verdicts),
        *next_runs(result.verdicts),
        *masked_lines(result.verdicts),
        *floor_lines(result.floors, result.study.variables),
        *result.excluded,
        *energy_lines(result),
    ]


def energy_lines(result: StudyResult) -> list[str]:
    """Whether the energy of the law falls in the runs that ended; nothing of a table that does not
    know it. An observation: what is claimed of an energy is its balance, to order k."""
    study, records = result.study, result.records
    energy = f"energy: {study.law.energy}"
    if study.forced:
        return [f"{energy}; the flow is forced, so that none need decrease, and none is checked"]
    ended = records[records["energy_rise"].notna()] if "energy_rise" in records else records[:0]
    if ended.empty:
        return []
    worst = ended.loc[ended["energy_rise"].idxmax()]
    if worst["energy_rise"] <= ROUNDING:
        return [f"{energy}; it falls in every step of the runs that ended"]
    at = f"V = {worst['vertices']}, tau = {worst['tau']:g}"
    rises = f"in a step it rises by up to {worst['energy_rise']:.1e} of its start ({at})"
    return [f"{energy}; {rises}: no theorem excludes rises of order h^k + tau^q"]


def reasons(verdicts: list[Verdict]) -> list[str]:
    """Why: a line a reason, with the variables and the error that it holds for."""
    shown: dict[tuple[ErrorName, str], list[str]] = {}
    for name in WORDS:
        for verdict in verdicts:
            for part in verdict.parts:
                if part.name == name:
                    shown.setdefault((name, part.reason), []).append(verdict.variable)
    return [f"{', '.join(names)}{_of(e)}: {reason}" for (e, reason), names in shown.items()]


def next_runs(verdicts: list[Verdict]) -> list[str]:
    """What would settle the inconclusive errors, a line each."""
    parts = [(v.variable, part) for v in verdicts for part in v.parts if part.next_run]
    return [f"{name}{_of(part.name)}, next run: {part.next_run}" for name, part in parts]


def _of(error: ErrorName) -> str:
    """What follows the name of a variable, if it is not the plain error that is meant."""
    return "" if error == "error" else " against the interpolation"


def masked_lines(verdicts: list[Verdict]) -> list[str]:
    """The runs that were masked for their errors, a line an error; those that stopped early are
    told by `esfem.results.selection.exclusions`."""
    lines = []
    for variable, part in ((v.variable, part) for v in verdicts for part in v.parts):
        masked = [m for m in part.masked if m.reason not in (*get_args(Status), NO_ERROR)]
        if masked:
            runs = "; ".join(f"h = {m.h:.3g}, tau = {m.tau:g}: {m.reason}" for m in masked)
            lines.append(f"{variable}{_of(part.name)} masked: {runs}")
    return lines


def floor_lines(floors: pd.DataFrame, variables: Sequence[str]) -> list[str]:
    """The floors for eyes: a line a floor, with its share in the error of each variable, and after
    a stroke that in the error against the interpolation, where it was measured."""
    lines = []
    for name, own in floors.groupby("floor", sort=False):
        both = "nodal" in own and own["nodal"].notna().any()  # older tables lack it
        shares = [
            f"{line.variable} {_short(line.value / line.error)}"
            + (f"/{_short(line.value / line.nodal)}" if both else "")
            for line in own.set_index("variable", drop=False).reindex(variables).itertuples()
            if line.variable in variables
        ]
        at = f"V = {own['vertices'].iloc[0]}, tau = {own['tau'].iloc[0]:g}"
        of = "the error / of that against the interpolation," if both else "the error"
        lines.append(f"{name} floor, as a share of {of} at {at}: {', '.join(shares)}")
    return lines


def _short(share: float) -> str:
    return f"{share:.1e}" if np.isfinite(share) else "-"
