"""The next run that would settle an inconclusive table, and what it would cost."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from esfem.judging.slices import LEAST_RANGE
from esfem.judging.table_columns import Array
from esfem.judging.validate import Direction, Runs

Cost = Callable[[float, float], float]  # seconds of a run (h, tau)
MOST_LEVELS = 12


@dataclass(frozen=True)
class Found:
    """What the advice goes by: the judged levels, their scatter, how far the order may be off, and
    how many levels are wanted at least."""

    levels: int
    scatter: float
    room: float
    fewest: int
    path: bool = False


def next_run(runs: Runs, direction: Direction, code: str, found: Found) -> tuple[float, float, str]:
    """The run (h, tau) to add and a word on it; tau is NaN in a table without tau."""
    h, tau = float(runs.h.min()), float(runs.tau.min())
    finer = {"h": h * _ratio(runs.h), "tau": tau * _ratio(runs.tau)}
    if found.path:
        return finer["h"], finer["tau"], "the next finer level of both"
    if code == "failed":
        broken = runs.at(np.isnan(runs.error))
        again = "again" if np.isnan(tau) else "again, with half the time step"
        return float(broken.h[-1]), float(broken.tau[-1]) / 2, again
    if code in ("plateau", "tau", "h"):
        return _other_part(runs, direction, finer, h, tau)
    if code in ("rounding", "solver", "quadrature", "cancellation"):
        coarser = {"h": float(runs.h.max()), "tau": float(runs.tau.max())}
        coarser = {name: v / _ratio(runs.parameter(_name(name))) for name, v in coarser.items()}
        at = (coarser["h"], tau) if direction == "h" else (h, coarser["tau"])
        return *at, "a coarser level, above the floor"
    at = (finer["h"], tau) if direction == "h" else (h, finer["tau"])
    if code == "close":
        reach = _ratio(runs.parameter(direction))
        levels = runs.parameter(direction)
        least = float(levels.max()) / LEAST_RANGE
        at = (min(h * reach, least), tau) if direction == "h" else (h, min(tau * reach, least))
        return *at, "further from the coarsest level"
    if code == "few":
        missing = max(found.fewest - found.levels, 1)
        return *at, f"{missing} more level{'s' if missing > 1 else ''} in all"
    if code == "noise":
        needed = levels_needed(_ratio(runs.parameter(direction)), found.scatter, found.room)
        more = max(needed - found.levels, 1)
        least_of = "at least " if needed == MOST_LEVELS else ""
        return *at, f"and finer: {least_of}{more} more level{'s' if more > 1 else ''} in all"
    return *at, "the next finer level"


def _name(name: str) -> Direction:
    return "h" if name == "h" else "tau"


def _other_part(
    runs: Runs, direction: Direction, finer: dict[str, float], h: float, tau: float
) -> tuple[float, float, str]:
    """Where errors stop falling: less of what the other parameter adds, if there is one."""
    if direction == "h" and np.isfinite(tau):
        return h, tau / 4, "on the same meshes: less of the error in time"
    if direction == "h":
        return finer["h"], tau, "with more exact quadrature, solver and reference"
    if len(np.unique(runs.h)) < 2:
        told = "a second mesh shows whether the error is in space"
    else:
        told = "less of the error in space"
    return finer["h"], tau, f"and the same time steps on that mesh: {told}"


def levels_needed(ratio: float, scatter: float, room: float) -> int:
    """The levels at this ratio whose 95 % interval is no wider than +- ``room``."""
    for n in range(4, MOST_LEVELS):
        spread = np.sqrt(n * (n * n - 1) / 12.0) * abs(np.log(ratio))
        if stdtrit(n - 2, 0.975) * scatter / spread <= room:
            return n
    return MOST_LEVELS


def described(run: tuple[float, float, str], runs: Runs, cost: Cost | None) -> str:
    """The run as text, with its estimated cost.

    Without ``cost`` that is the time of the finest run there is, or 1, times the growth of steps
    and unknowns, h^-2 / tau.
    """
    h, tau, remark = run
    where = f"h = {h:.3g}" + ("" if np.isnan(tau) else f", tau = {tau:.3g}")
    if cost is not None:
        return f"{where} ({remark}), about {cost(h, tau):.3g} s"
    finest = runs.at(np.lexsort((runs.tau, runs.h))[:1])
    growth = float(finest.h[0] / h) ** 2 * (1.0 if np.isnan(tau) else float(finest.tau[0]) / tau)
    if np.isfinite(finest.seconds[0]):
        return f"{where} ({remark}), about {growth * float(finest.seconds[0]):.3g} s"
    return f"{where} ({remark}), about {growth:.2g} times the finest run"


def _ratio(values: Array) -> float:
    """The mean ratio of consecutive levels; 1/2 if there is one level."""
    levels = np.unique(values)[::-1]
    if len(levels) < 2 or not np.isfinite(levels).all():
        return 0.5
    return float((levels[-1] / levels[0]) ** (1.0 / (len(levels) - 1)))
