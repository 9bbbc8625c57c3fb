"""The slice that is judged: one line of runs, freed of what the other parameter adds."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from esfem.judging.fits import Array
from esfem.judging.floors import Masked
from esfem.judging.joint import JointFit, joint_fit
from esfem.judging.validate import Direction
from esfem.judging.window import fewest_levels

SHARE = 1 / 3  # of the error, up to which the other term is subtracted, above which it masks
RULED = "the term in "


@dataclass(frozen=True)
class Slice:
    """Levels ``s`` of the judged parameter, coarse to fine, with their errors.

    ``other`` is the value of the other parameter, NaN without one; ``masked`` lists every run of
    the table that is not among the levels for a reason other than lying on another line;
    ``obstacle`` is the cause named if too few are left; ``grid`` has the rows s, o, e of all runs
    of the joint fit, for which ``other_order`` was given.
    """

    s: Array
    e: Array
    masked: tuple[Masked, ...]
    obstacle: str
    joint: JointFit | None
    grid: Array | None
    other_order: float | None

    def joint_over(self, levels: int) -> JointFit | None:
        """The joint fit over the finest levels of s alone."""
        if self.grid is None or levels == len(self.s):
            return self.joint
        s, o, e = self.grid[:, self.grid[0] <= self.s[-levels]]
        return joint_fit(s, o, e, self.other_order)


def judged_slice(
    runs: pd.DataFrame, direction: Direction, other_order: float | None, separate: bool
) -> Slice:
    """The slice to judge in validated runs with the columns of `near_floors`.

    With several values of the other parameter and unless ``separate`` says that it adds nothing,
    its term is fitted over the whole grid and subtracted.
    """
    other = "tau" if direction == "h" else "h"
    failed = runs["error"].isna()
    why = runs["status"].where(runs["status"] != "ok", "no error")
    runs = runs.assign(reason=runs["reason"].mask(failed, why))
    clear = runs[runs["reason"] == ""]
    joint = grid = None
    if not separate and clear[other].nunique() > 1:
        grid = clear[[direction, other, "error"]].to_numpy().T
        s, o, e = grid
        joint = joint_fit(s, o, e, other_order)
    line = _line(runs, direction, other)
    line = _without_other(_without_holes(line), joint, other)
    runs = runs.assign(reason=line["reason"].reindex(runs.index).fillna(runs["reason"]))
    kept = line[line["reason"] == ""]
    return Slice(
        s=kept[direction].to_numpy(),
        e=kept["error"].to_numpy(),
        masked=tuple(
            Masked(float(run.h), float(run.tau), run.reason, run.floor)
            for run in runs[runs["reason"] != ""].itertuples()
        ),
        obstacle=_obstacle(line, other),
        joint=joint,
        grid=grid,
        other_order=other_order,
    )


def _line(runs: pd.DataFrame, direction: Direction, other: str) -> pd.DataFrame:
    """The runs, coarse to fine, at the finest value of the other parameter with enough of them.

    At the finest value there is, if there are enough at none.
    """
    runs = runs.sort_values(direction, ascending=False)
    lines = [line for _, line in runs.groupby(other, dropna=False)]
    for line in lines:
        kept = _without_holes(line)
        kept = kept[kept["reason"] == ""]
        if len(kept) >= fewest_levels(kept[direction].to_numpy()):
            return line
    return lines[0]


def _without_holes(line: pd.DataFrame) -> pd.DataFrame:
    """Masks what is coarser than a run that failed: a hole in the ladder is not bridged."""
    holes = np.flatnonzero(line["error"].isna())
    coarser = np.arange(len(line)) < (holes[-1] if len(holes) else 0)
    beyond = coarser & (line["reason"] == "")
    return line.assign(reason=line["reason"].mask(beyond, "coarser than a run that failed"))


def _without_other(line: pd.DataFrame, joint: JointFit | None, other: str) -> pd.DataFrame:
    """Subtracts the term in the other parameter, and masks where it is too large for that."""
    if joint is None:
        return line
    term = joint.other_term(float(line[other].iloc[0]))
    share = term / line["error"]
    rules = (line["reason"] == "") & (share > SHARE)
    notes = [f"{100 * min(part, 1.0):.0f} % of the error is {RULED}{other}" for part in share]
    return line.assign(error=line["error"] - term, reason=line["reason"].mask(rules, notes))


def _obstacle(line: pd.DataFrame, other: str) -> str:
    """What left too few levels on the line, if too few are left."""
    if line["reason"].str.contains(RULED).any():
        return f"{other} plateau"
    if (line["floor"] != "").any():
        return str(line["floor"][line["floor"] != ""].iloc[0])
    return "diverged cells" if line["error"].isna().any() else "too few levels"
