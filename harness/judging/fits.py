r"""Models of one slice, log E = a + p x + s log(1 + r exp(m x)) with x = log(h / h_finest) >= 0.

The pure power has r = 0.  A *sum* (s = 1, r > 0) is A h^p + B h^(p+m), a *difference* (s = 1,
r < 0) A h^p - B h^(p+m), a *saturation* (s = -1 or -1/2, r > 0) A h^p / (1 + c h^m)^|s|.  Given r
and m the others are linear, so that every fit is a scan over one shape parameter; residuals are
those of log E.

A *hypothesis* is such a model with both exponents fixed, so it has the two parameters a and r, as
many as the pure power has, and may be compared with it by the sum of squares alone.  It says of the
order as h -> 0 what a pure power cannot say: 10 h^3 + 0.03 h is of order 1.  The leading term must
hold at least `VISIBLE` of the error on the finest level, else nothing in the table tells of it.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr, stdtrit

VISIBLE = 0.4
RESOLUTION = 1e-5  # relative: no table is trusted beyond it, so that an exact fit is not infinite
GRID = np.linspace(0.0, 1.0, 49)
ZOOMS = 3

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PowerFit:
    """log E = a + order x by least squares: 95 % t-interval of the order, residuals, scatter.

    ``curvature`` and ``bend`` are the change of slope over the levels in a parabola, coarse minus
    fine, and its p-value (NaN below four levels).
    """

    order: float
    lower: float
    upper: float
    intercept: float
    residuals: Array
    rss: float
    curvature: float
    bend: float

    @property
    def scatter(self) -> float:
        """Standard deviation of the residuals of log E: 0.05 is 5 %."""
        return float(np.sqrt(self.rss / max(len(self.residuals) - 2, 1)))


@dataclass(frozen=True)
class Hypothesis:
    """Fixed ``p``, ``m`` and ``s``; ``order`` is what it says of h -> 0."""

    name: str
    p: float
    m: float
    kind: Literal["sum", "difference", "saturation", "plateau"]
    s: float = 1.0

    @property
    def order(self) -> float:
        """The order; of a plateau (p = 0) that of the part which still falls."""
        return self.m if self.kind == "plateau" else self.p


def power_fit(x: Array, y: Array) -> PowerFit:
    """The pure power through at least three points."""
    centred, n = x - x.mean(), len(x)
    sxx = float(centred @ centred)
    order = float(centred @ y) / sxx
    intercept = float(y.mean() - order * x.mean())
    residuals = y - intercept - order * x
    rss = float(residuals @ residuals)
    half = float(stdtrit(n - 2, 0.975)) * np.sqrt(rss / (n - 2) / sxx)
    square = centred**2 - (centred**3).sum() / sxx * centred
    square -= square.mean()
    weight = float(square @ square)
    bend = float(square @ y) / weight
    left, p_value = rss - bend**2 * weight, float("nan")
    if n >= 4:
        error = np.sqrt(max(left, n * RESOLUTION**2) / (n - 3) / weight)
        p_value = 2.0 * float(stdtr(n - 3, -abs(bend) / error))
    change = 2.0 * bend * float(np.ptp(x))
    return PowerFit(order, order - half, order + half, intercept, residuals, rss, change, p_value)


def hypotheses(k: float, plateaus: bool) -> tuple[Hypothesis, ...]:
    """What a slope about k, or below it, may also be; plateaus unless a floor rules them out."""
    found = [
        *(Hypothesis(f"h^{k - 1:g} + h^{k - 1 + m:g}", k - 1, m, "sum") for m in (1.0, 2.0, 3.0)),
        *(Hypothesis(f"h^{k:g} + h^{k + m:g}", k, m, "sum") for m in (1.0, 2.0)),
        *(Hypothesis(f"h^{k:g} - h^{k + m:g}", k, m, "difference") for m in (1.0, 2.0)),
        *(Hypothesis(f"h^{k:g} / (1 + c h^{m:g})", k, m, "saturation", -1.0) for m in (1.0, 2.0)),
        *(
            Hypothesis(f"h^{k:g} / (1 + c h^{m:g})^1/2", k, m, "saturation", -0.5)
            for m in (1.0, 2.0)
        ),
        Hypothesis(f"h^{k:g} - C", k, -k, "difference"),
    ]
    if k > 1:
        found.append(Hypothesis(f"h^{k - 1:g} - C", k - 1, 1 - k, "difference"))
    if plateaus:
        found += [Hypothesis(f"h^{m:g} + C", 0.0, m, "plateau") for m in (k, k + 1)]
    return tuple(found)


def residual_sums(x: Array, y: Array, which: tuple[Hypothesis, ...]) -> Array:
    """The least sum of squares under each hypothesis, (hypotheses,)."""
    p, m, signs = (np.array([getattr(h, name) for h in which]) for name in ("p", "m", "s"))
    low, high = np.transpose([_range(h, x) for h in which])
    scale = np.where(
        [h.kind == "difference" for h in which], -np.exp(-np.maximum(m, 0) * x.max()), 1.0
    )
    straight = y - p[:, None] * x
    for _ in range(ZOOMS):
        v = low[:, None] + (high - low)[:, None] * GRID
        r = scale[:, None] * np.where(scale[:, None] < 0, 1.0 / (1.0 + np.exp(-v)), np.exp(v))
        shape = np.log1p(r[:, :, None] * np.exp(m[:, None, None] * x))
        sums = len(x) * np.var(straight[:, None, :] - signs[:, None, None] * shape, axis=2)
        best = np.argmin(sums, axis=1)
        step = (high - low) * GRID[1]
        middle = v[np.arange(len(which)), best]
        low, high = np.maximum(low, middle - step), np.minimum(high, middle + step)
    return sums.min(axis=1)


def _range(hypothesis: Hypothesis, x: Array) -> tuple[float, float]:
    """Where its shape parameter is sought: log r, or the logit of the share that is taken away."""
    span = hypothesis.m * float(x.max())
    if hypothesis.kind == "difference":
        return -4.0, 4.0
    if hypothesis.kind == "plateau":  # what falls must be the larger part on the coarsest level
        return -span, 6.0
    return -span - 5.0, float(np.log((1.0 - VISIBLE) / VISIBLE))


def aicc(rss: float, n: int, parameters: int) -> float:
    """Akaike's criterion for n log errors and their unknown variance; inf if n is too small."""
    K = parameters + 1
    if n - K - 1 <= 0:
        return float("inf")
    return n * float(np.log(rss / n + RESOLUTION**2)) + 2 * K + 2 * K * (K + 1) / (n - K - 1)
