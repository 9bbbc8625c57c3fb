"""What explains the verdicts of a study, in words."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from esfem.measuring.energies import ROUNDING
from esfem.results.study_result import StudyResult
from esfem.results.verdicts import Verdict


def remarks(result: StudyResult) -> list[str]:
    """What explains the verdicts: reasons, next runs, masked runs, floors, what was not judged."""
    return [
        *reasons(result.verdicts),
        *(f"{v.variable}, next run: {v.next_run}" for v in result.verdicts if v.next_run),
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
    """Why: a line a reason, with the variables that it holds for."""
    shown: dict[str, list[str]] = {}
    for verdict in verdicts:
        shown.setdefault(verdict.reason, []).append(verdict.variable)
    return [f"{', '.join(names)}: {reason}" for reason, names in shown.items()]


def masked_lines(verdicts: list[Verdict]) -> list[str]:
    """The runs that were masked for a floor or for the other parameter, a line a variable; those
    that stopped early are told by `esfem.results.selection.exclusions`."""
    lines = []
    for verdict in verdicts:
        masked = [m for m in verdict.masked if m.floor or "of the error" in m.reason]
        if masked:
            runs = "; ".join(f"h = {m.h:.3g}, tau = {m.tau:g}: {m.reason}" for m in masked)
            lines.append(f"{verdict.variable} masked: {runs}")
    return lines


def floor_lines(floors: pd.DataFrame, variables: Sequence[str]) -> list[str]:
    """The floors for eyes: a line a floor, with the share in the error of each variable."""
    lines = []
    for name, own in floors.groupby("floor", sort=False):
        share = own.set_index("variable")["value"] / own.set_index("variable")["error"]
        shares = [f"{v} {_short(share[v])}" for v in variables if v in share.index]
        at = f"V = {own['vertices'].iloc[0]}, tau = {own['tau'].iloc[0]:g}"
        lines.append(f"{name} floor, as a share of the error at {at}: {', '.join(shares)}")
    return lines


def _short(share: float) -> str:
    return f"{share:.1e}" if np.isfinite(share) else "-"
