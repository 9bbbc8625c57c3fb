"""Model choice on one slice: models with free exponents, compared by AICc."""

from dataclasses import dataclass

import numpy as np
from scipy.special import fdtri

from esfem.judging.fits import RESOLUTION, Array, PowerFit, aicc

CLOSE = 2.0  # of AICc: models this close to the best are as good
ODDS = np.exp(np.linspace(-12.0, 6.0, 73))  # of the second term, where it is least
PARTS = np.linspace(0.01, 0.97, 49)  # share that a difference takes away, where it is largest
GAPS = np.linspace(0.5, 4.0, 15)  # between two free exponents
FALLING = np.linspace(0.3, 7.0, 68)  # exponents above a plateau


@dataclass(frozen=True)
class Model:
    """One model fitted to a slice: its leading order with a 95 % interval, NaN if it has none."""

    name: str
    order: float
    lower: float
    upper: float
    rss: float
    aicc: float


def models(x: Array, y: Array, power: PowerFit) -> tuple[Model, ...]:
    """Pure power, power and plateau, power and next order, two powers; the best first."""
    n = len(x)
    found = [
        Model("power", power.order, power.lower, power.upper, power.rss, aicc(power.rss, n, 2))
    ]
    if n >= 4:
        found += [_plateau(x, y), _next_order(x, y)]
    if n >= 5:
        found.append(_two_powers(x, y))
    return tuple(sorted(found, key=lambda model: model.aicc))


def _plateau(x: Array, y: Array) -> Model:
    """A h^p + C: a scan over p and the odds of h^p on the finest level."""
    p, r = (a.ravel() for a in np.meshgrid(FALLING, ODDS))
    sums = len(x) * np.var(y - np.log1p(r[:, None] * np.exp(p[:, None] * x)), axis=1)
    best = int(np.argmin(sums))
    nan = float("nan")
    return Model("power + plateau", p[best], nan, nan, sums[best], aicc(sums[best], len(x), 3))


def _next_order(x: Array, y: Array) -> Model:
    """A h^p (1 + c h), c of either sign, with the profile interval of p."""
    n = len(x)
    r = np.concatenate([ODDS, -PARTS * np.exp(-x.max())])
    p, sums, variance = _project(x, y - np.log1p(r[:, None] * np.exp(x)))
    best = int(np.argmin(sums))
    width = sums[best] / (n - 3) * float(fdtri(1, n - 3, 0.95)) + n * RESOLUTION**2
    room = sums[best] + width - sums
    half = np.sqrt(np.maximum(room, 0.0) * variance)
    lower, upper = (p - half)[room >= 0].min(), (p + half)[room >= 0].max()
    return Model("power + next order", p[best], lower, upper, sums[best], aicc(sums[best], n, 3))


def _two_powers(x: Array, y: Array) -> Model:
    """A h^p + B h^q, q - p in `GAPS`."""
    m, r = (a.ravel() for a in np.meshgrid(GAPS, ODDS))
    p, sums, _ = _project(x, y - np.log1p(r[:, None] * np.exp(m[:, None] * x)))
    best = int(np.argmin(sums))
    nan = float("nan")
    return Model("two powers", p[best], nan, nan, sums[best], aicc(sums[best], len(x), 4))


def _project(x: Array, rows: Array) -> tuple[Array, Array, float]:
    """Slope and sum of squares of a straight line through each row; 1 / sum of (x - mean)^2."""
    centred = x - x.mean()
    sxx = float(centred @ centred)
    slopes = rows @ centred / sxx
    left = rows - rows.mean(axis=1, keepdims=True) - slopes[:, None] * centred
    return slopes, (left**2).sum(axis=1), 1.0 / sxx
