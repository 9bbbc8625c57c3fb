"""The asymptotic window: the longest fine end over which the order is stable."""

from dataclasses import dataclass
from itertools import pairwise
from math import comb

import numpy as np

from harness.judging.fits import Array, PowerFit, power_fit

FEWEST = 4
FEWEST_CLOSE = 5  # where h falls by less than COARSE_RATIO a level
COARSE_RATIO = 0.62
SIGNIFICANT = 0.05


@dataclass(frozen=True)
class Window:
    """The finest ``levels`` of a slice; ``stable`` or the shortest there is."""

    levels: int
    fit: PowerFit
    stable: bool


def fewest_levels(s: Array) -> int:
    """How many levels an order needs: 4, or 5 where they lie closer than a ratio of 0.62."""
    if len(s) < 2:
        return FEWEST
    ratio = (s[-1] / s[0]) ** (1.0 / (len(s) - 1))
    return FEWEST if ratio <= COARSE_RATIO else FEWEST_CLOSE


def asymptotic_window(s: Array, y: Array, tolerance: float) -> Window | None:
    """The longest stable fine end of levels s, coarse to fine, with log errors y.

    None if there are too few levels.  The shortest one, not stable, if none is stable.
    """
    fewest = fewest_levels(s)
    x = np.log(s / s[-1]) if len(s) else s
    window = None
    for levels in range(len(s), fewest - 1, -1):
        fit = power_fit(x[-levels:], y[-levels:])
        window = Window(levels, fit, is_stable(fit, tolerance))
        if window.stable:
            break
    return window


def is_stable(fit: PowerFit, tolerance: float) -> bool:
    """No trend in the slope that is both significant and larger than the tolerance.

    E / h^order settles: a significant parabola, or too few runs of residual signs, is a trend.
    """
    trend = fit.bend < SIGNIFICANT or runs_probability(fit.residuals) < SIGNIFICANT
    return not (trend and abs(fit.curvature) > tolerance)


def runs_probability(residuals: Array) -> float:
    """The probability of so few runs of signs, or fewer, if the signs are in random order."""
    signs = residuals > 0
    runs = 1 + sum(a != b for a, b in pairwise(signs))
    plus, minus = int(signs.sum()), int((~signs).sum())
    if min(plus, minus) == 0:
        return 1.0
    ways = sum(_arrangements(plus, minus, count) for count in range(2, runs + 1))
    return ways / comb(plus + minus, plus)


def _arrangements(plus: int, minus: int, runs: int) -> int:
    """Sequences of so many signs with exactly so many runs."""
    half, odd = divmod(runs, 2)
    if odd:
        return comb(plus - 1, half) * comb(minus - 1, half - 1) + comb(plus - 1, half - 1) * comb(
            minus - 1, half
        )
    return 2 * comb(plus - 1, half - 1) * comb(minus - 1, half - 1)
