"""The next run that would settle an inconclusive table, and what it would cost."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from esfem.judging.validate import Direction

Cost = Callable[[float, float], float]  # seconds of a run (h, tau)
MOST_LEVELS = 12


def next_run(
    table: pd.DataFrame, direction: Direction, cause: str, levels: int, scatter: float, room: float
) -> tuple[float, float, str]:
    """The run (h, tau) to add and a word on it; tau is NaN in a table without tau.

    ``room`` is the half-width that the interval of the order may have.
    """
    h, tau = float(table["h"].min()), float(table["tau"].min())
    finer = {"h": h * _ratio(table, "h"), "tau": tau * _ratio(table, "tau")}
    if cause == "diverged cells":
        failed = table[table["error"].isna()].iloc[-1]
        return float(failed["h"]), float(failed["tau"]) / 2, "again, with half the time step"
    if cause in ("tau plateau", "tau"):
        return h, tau / 4, "on the same meshes: less of the error in time"
    if cause in ("h plateau", "h"):
        second = table["h"].nunique() < 2 and "a second mesh shows whether the error is in space"
        told = second or "less of the error in space"
        return finer["h"], tau, f"and the same time steps on that mesh: {told}"
    if cause in ("rounding", "solver", "quadrature"):
        coarser = {name: float(table[name].max()) / _ratio(table, name) for name in ("h", "tau")}
        at = (coarser["h"], tau) if direction == "h" else (h, coarser["tau"])
        return *at, "coarser levels, above the floor"
    at = (finer["h"], tau) if direction == "h" else (h, finer["tau"])
    if cause == "noise":
        needed = levels_needed(_ratio(table, direction), scatter, room)
        more = max(needed - levels, 1)
        least = "at least " if needed == MOST_LEVELS else ""
        return *at, f"and finer: {least}{more} more level{'s' if more > 1 else ''} in all"
    return *at, "the next finer level"


def levels_needed(ratio: float, scatter: float, room: float) -> int:
    """The levels at this ratio whose 95 % interval is no wider than +- ``room``."""
    for n in range(4, MOST_LEVELS):
        spread = np.sqrt(n * (n * n - 1) / 12.0) * abs(np.log(ratio))
        if stdtrit(n - 2, 0.975) * scatter / spread <= room:
            return n
    return MOST_LEVELS


def described(run: tuple[float, float, str], table: pd.DataFrame, cost: Cost | None) -> str:
    """The run as text, with its estimated cost.

    Without ``cost`` that is the time of the finest run there is, or 1, times the growth of steps
    and unknowns, h^-2 / tau.
    """
    h, tau, remark = run
    where = f"h = {h:.3g}" + ("" if np.isnan(tau) else f", tau = {tau:.3g}")
    if cost is not None:
        return f"{where} ({remark}), about {cost(h, tau):.3g} s"
    finest = table.sort_values(["h", "tau"]).iloc[0]
    growth = (finest["h"] / h) ** 2 * (1.0 if np.isnan(tau) else finest["tau"] / tau)
    if np.isfinite(finest["seconds"]):
        return f"{where} ({remark}), about {growth * finest['seconds']:.3g} s"
    return f"{where} ({remark}), about {growth:.2g} times the finest run"


def _ratio(table: pd.DataFrame, name: str) -> float:
    """The mean ratio of consecutive levels; 1/2 if there is one level."""
    values = np.sort(table[name].unique())[::-1]
    if len(values) < 2:
        return 0.5
    return float((values[-1] / values[0]) ** (1.0 / (len(values) - 1)))
