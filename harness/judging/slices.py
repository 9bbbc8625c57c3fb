"""What is judged of a table: one line of levels, a path through both parameters, or a grid."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from esfem.judging.plane import Grid
from esfem.judging.table_columns import Array
from esfem.judging.validate import Direction, Runs

LEAST_RANGE = 2.5  # of the judged parameter, from the coarsest to the finest level
STRAIGHT = 0.15  # by which local exponents of tau ~ h^gamma may differ from gamma, relative
CLOSE = 0.04  # a gamma this close to a quarter is one
TURNED = "coarser than a level where the error met a floor: it may have changed its sign there"
GROWN = "not smaller than on a coarser level that was at rounding"
FAILED = "coarser than a run that failed"


@dataclass(frozen=True)
class Slice:
    """The line that is judged: levels ``s`` of the judged parameter, coarse to fine, errors ``e``.

    ``runs`` are all of the table with what speaks against them, ``line`` those on the line;
    ``grid`` holds all clear runs if the other parameter takes several values, and ``gamma`` is that
    of a path tau ~ h^gamma, NaN without one.
    """

    runs: Runs
    line: Runs
    s: Array
    e: Array
    grid: Grid | None
    gamma: float


def judged_slice(runs: Runs, direction: Direction, separate: bool, fewest: int) -> Slice:
    """The slice to judge in runs with what speaks against each of them.

    The line lies at the finest value of the other parameter with enough levels, at the finest if
    there is none; on a path all runs are on it.  ``separate``: the other parameter adds nothing.
    """
    other: Direction = "tau" if direction == "h" else "h"
    gamma = path(runs)
    every = np.arange(len(runs))
    chosen = every if np.isfinite(gamma) else _line(runs, direction, other, fewest)
    line = _without_holes(_coarse_to_fine(runs.at(chosen), direction))
    where = {row: place for place, row in enumerate(line.row)}
    reasons, floors = runs.reason.copy(), runs.floor.copy()
    for place, row in enumerate(runs.row):
        if row in where:
            reasons[place], floors[place] = line.reason[where[row]], line.floor[where[row]]
    whole = Runs(**{**vars(runs), "reason": reasons, "floor": floors})
    clear = runs.at(runs.clear)
    several = np.isnan(gamma) and not separate and len(np.unique(clear.parameter(other))) > 1
    grid = None
    if several and np.isfinite(clear.parameter(other)).all():
        grid = Grid(clear.parameter(direction), clear.parameter(other), clear.error)
    kept = line.at(line.clear)
    return Slice(whole, line, kept.parameter(direction), kept.error, grid, gamma)


def path(runs: Runs) -> float:
    """gamma if h and tau are refined together, tau ~ h^gamma; NaN if they are not."""
    if len(runs) < 3 or not np.isfinite(runs.tau).all():
        return float("nan")
    x, t = np.log(runs.h), np.log(runs.tau)  # coarse before fine
    if (np.diff(x) >= 0).any() or (np.diff(t) >= 0).any():
        return float("nan")
    gamma = float((t[0] - t[-1]) / (x[0] - x[-1]))
    local = np.diff(t) / np.diff(x)
    if (np.abs(local - gamma) > STRAIGHT * gamma).any():
        return float("nan")
    near = round(4.0 * gamma) / 4.0
    return near if near > 0 and abs(gamma - near) < CLOSE else gamma


def obstacle(part: Slice) -> str:
    """What left too few levels on the line."""
    line = part.line
    if (line.reason == TURNED).any():
        return "cancellation"
    named = line.floor[line.floor != ""]
    if len(named):
        return str(named[0])
    return "failed" if np.isnan(line.error).any() else "few"


def spread_enough(s: Array, fewest: int) -> bool:
    """Whether there are enough levels, far enough from each other."""
    return len(s) >= fewest and bool(s[0] >= LEAST_RANGE * s[-1] * (1.0 - 1e-9))


def _coarse_to_fine(runs: Runs, direction: Direction) -> Runs:
    return runs.at(np.argsort(-runs.parameter(direction), kind="stable"))


def _line(runs: Runs, direction: Direction, other: Direction, fewest: int) -> NDArray[np.int_]:
    """The places of the runs on the line."""
    values = runs.parameter(other)
    if not np.isfinite(values).all():
        return np.arange(len(runs))
    lines = [np.flatnonzero(values == value) for value in np.unique(values)]
    for places in lines:
        line = _without_holes(_coarse_to_fine(runs.at(places), direction))
        if spread_enough(line.parameter(direction)[line.clear], fewest):
            return places
    return lines[0]


def _without_holes(line: Runs) -> Runs:
    """Masks what is coarser than a run that failed, or met a floor before one that did not: a hole
    in the ladder is not bridged."""
    n = len(line)
    line = _grown_from_rounding(line)
    failed = np.flatnonzero(np.isnan(line.error))
    if len(failed):
        line = line.masking(np.arange(n) < failed[-1], FAILED)
    at_floor, clear = np.flatnonzero(line.floor != ""), np.flatnonzero(line.clear)
    inner = at_floor[at_floor < (clear[-1] if len(clear) else 0)]
    if len(inner):
        line = line.masking(np.arange(n) < inner[-1], TURNED)
    return line


def _grown_from_rounding(line: Runs) -> Runs:
    """Masks what is finer than a level at rounding, if nothing there falls any more: the solution
    is in the space of the method, and what grows is the rounding of larger systems."""
    at_rounding = np.flatnonzero(line.floor == "rounding")
    if not len(at_rounding):
        return line
    finer = np.arange(len(line)) > at_rounding[0]
    e = line.error[finer & line.clear]
    if len(e) < 2 or (np.diff(e) < 0).any():
        return line
    return line.masking(finer, GROWN, "rounding")
