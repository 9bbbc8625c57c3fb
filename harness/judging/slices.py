"""The slice that is judged: one line of runs, freed of what the other parameter adds."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from harness.judging.fits import Array
from harness.judging.floors import Floor, Masked, at_floor
from harness.judging.joint import JointFit, joint_fit
from harness.judging.validate import Direction
from harness.judging.window import fewest_levels

SHARE = 1 / 3  # of the error, up to which the other term is subtracted, above which it masks


@dataclass(frozen=True)
class Slice:
    """Levels ``s`` of the judged parameter, coarse to fine, with their errors.

    ``other`` is the value of the other parameter, NaN without one; ``masked`` lists every run of
    the table that is not among the levels for a reason other than lying on another line;
    ``obstacle`` is the cause named if too few are left.
    """

    s: Array
    e: Array
    other: float
    masked: tuple[Masked, ...]
    obstacle: str
    joint: JointFit | None


def judged_slice(
    table: pd.DataFrame,
    original: pd.DataFrame,
    direction: Direction,
    floors: Sequence[Floor],
    other_order: float | None,
    separate: bool,
) -> Slice:
    """The slice to judge in a validated table; ``original`` is the table the floors refer to.

    With several values of the other parameter and unless ``separate`` says that it adds nothing,
    its term is fitted over the whole grid and subtracted.
    """
    reasons = at_floor(original, table["error"], floors)
    reasons[table["error"].isna()] = table["status"].where(table["status"] != "ok", "no error")
    other = "tau" if direction == "h" else "h"
    value = _line(table, reasons, direction, other)
    clear = table[reasons == ""]
    joint = None
    if not separate and clear[other].nunique() > 1:
        joint = _joint(clear, direction, other_order)
    line = table if np.isnan(value) else table[table[other] == value]
    line = line.sort_values(direction, ascending=False)
    return _freed(table, line, reasons, direction, value, joint)


def _line(table: pd.DataFrame, reasons: pd.Series, direction: Direction, other: str) -> float:
    """The finest value of the other parameter on which enough runs are whole at the fine end."""
    values = sorted(table[other].dropna().unique())
    for value in values:
        runs = table[table[other] == value].sort_values(direction, ascending=False)
        whole = _block(reasons[runs.index].to_numpy(), runs["error"].to_numpy())
        if whole.sum() >= max(4, fewest_levels(runs[direction].to_numpy()[whole])):
            return value
    return values[0] if values else float("nan")


def _block(reasons: np.ndarray, errors: Array) -> np.ndarray:
    """The usable levels finer than any that failed: a hole in the ladder is not bridged."""
    holes = np.flatnonzero(np.isnan(errors))
    usable = reasons == ""
    if len(holes):
        usable[: holes[-1] + 1] = False
    return usable


def _joint(runs: pd.DataFrame, direction: Direction, order: float | None) -> JointFit | None:
    other = "tau" if direction == "h" else "h"
    s, o, e = (runs[name].to_numpy() for name in (direction, other, "error"))
    return joint_fit(s, o, e, order)


def _freed(table, line, reasons, direction, value, joint) -> Slice:
    """The line without masked runs and without the other term."""
    e, why = line["error"].to_numpy(), reasons[line.index].to_numpy(dtype=object)
    block = _block(why, e)
    obstacle = "diverged cells" if np.isnan(e).any() and not block.all() else "too few levels"
    if any("floor" in reason for reason in why):
        obstacle = "rounding" if any("rounding" in reason for reason in why) else "floor"
    why[(why == "") & ~block] = "coarser than a run without error"
    if joint is not None:
        part = joint.B * value**joint.q
        share = part / np.where(np.isnan(e), np.inf, e)
        other = "tau" if direction == "h" else "h"
        for i in np.flatnonzero((why == "") & (share > SHARE)):
            why[i] = f"{100 * min(share[i], 1.0):.0f} % of the error is the term in {other}"
            obstacle = f"{other} plateau"
        e = e - part
    kept = why == ""
    reasons = reasons.copy()
    reasons[line.index] = why
    masked = tuple(
        Masked(float(run.h), float(run.tau), str(reasons[run.Index]))
        for run in table[reasons != ""].itertuples()
    )
    return Slice(line[direction].to_numpy()[kept], e[kept], value, masked, obstacle, joint)
