"""How far results may move before they have moved: from the fit of the baseline.

A run of the same code on the same machine repeats bit for bit, so the floors allow for other
machines alone.  What a harmless change of the numbers may do (another mesh of the same size) is as
large as the scatter of the errors about their line: that is what is left of the one mesh, not of h.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from esfem.results.error_verdicts import ErrorVerdict

ORDER_FLOOR = 0.02
LEVEL_FLOOR = 0.02  # relative
EXCUSE = 0.2  # half-width up to which an uncertain fit of today excuses its own order
LEVEL = 0.95


@dataclass(frozen=True)
class Most:
    """What a tolerance is at most, however large the scatter: of the mean of log E, and of one."""

    level: float
    one: float


# A constant that is 5 times worse is found in every table; on the very same meshes, where there is
# no scatter between the runs but for rounding, a tenth is.
OTHER_MESHES = Most(np.log(2.0), np.log(4.0))
SAME_MESHES = Most(np.log(1.1), np.log(1.2))


def order_tolerance(baseline: ErrorVerdict, current: ErrorVerdict) -> float:
    """How far the order may move: both half-widths, on the sides that face each other, as a root
    of squares; at least `ORDER_FLOOR`.

    The uncertainty of today counts up to that of the baseline, or `EXCUSE`: a fit that has become
    bad is not excused by being bad.
    """
    if current.observed < baseline.observed:
        then, now = baseline.observed - baseline.lower, current.upper - current.observed
    else:
        then, now = baseline.upper - baseline.observed, current.observed - current.lower
    now = np.nan_to_num(now, nan=0.0)
    return float(max(ORDER_FLOOR, np.hypot(then, min(now, max(then, EXCUSE)))))


def level_tolerance(scatter: float, n: int, most: Most = OTHER_MESHES) -> float:
    """How far the mean of log E over n levels may move: t_{n-2} scatter sqrt(1 + 1/n), that is how
    far the next value may lie from the line; the most where nothing was fitted."""
    if n < 3 or not np.isfinite(scatter):
        return float(OTHER_MESHES.level)
    quantile = stdtrit(n - 2, (1.0 + LEVEL) / 2.0)
    return float(np.clip(quantile * scatter * np.sqrt(1.0 + 1.0 / n), LEVEL_FLOOR, most.level))


def one_tolerance(scatter: float, n: int, most: Most = OTHER_MESHES) -> float:
    """How far any one of n values of log E may move: two draws of the scatter, and the quantile
    is that of the largest of n."""
    if n < 3 or not np.isfinite(scatter):
        return float(OTHER_MESHES.one)
    quantile = stdtrit(n - 2, 1.0 - (1.0 - LEVEL) / (2.0 * n))
    return float(np.clip(quantile * scatter * np.sqrt(2.0), 2.0 * LEVEL_FLOOR, most.one))
