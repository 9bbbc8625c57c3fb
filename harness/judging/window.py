"""The asymptotic window: the longest fine end over which the order is stable."""

from dataclasses import dataclass
from itertools import pairwise
from math import comb

import numpy as np

from esfem.judging.fits import RESOLUTION, Array, Hypothesis, PowerFit, power_fit, residual_sums

FEWEST = 4
FEWEST_CLOSE = 5  # where h falls by less than COARSE_RATIO a level
COARSE_RATIO = 0.62
SIGNIFICANT = 0.05
BETTER = 5.0  # of n log RSS, by which a curved model must beat the pure power
FAR = 12.0  # of n log RSS: a hypothesis so much worse than the best fit is ruled out for good


@dataclass(frozen=True)
class Window:
    """The finest ``levels`` of a slice; ``stable`` or the shortest there is.

    ``excess`` tells how much worse than the best fit each hypothesis is, and ``power_excess`` how
    much the pure power: n log of the ratio of the sums of squares, which compares like AICc since
    all have two parameters.  ``closest`` is the standard deviation of log E about the best fit.
    """

    levels: int
    fit: PowerFit
    excess: Array
    power_excess: float
    closest: float
    stable: bool


def fewest_levels(s: Array) -> int:
    """How many levels an order needs: 4, or 5 where they lie closer than a ratio of 0.62."""
    if len(s) < 2:
        return FEWEST
    ratio = (s[-1] / s[0]) ** (1.0 / (len(s) - 1))
    return FEWEST if ratio <= COARSE_RATIO else FEWEST_CLOSE


def asymptotic_window(
    s: Array, y: Array, which: tuple[Hypothesis, ...], tolerance: float
) -> Window | None:
    """The longest stable fine end of levels s, coarse to fine, with log errors y.

    None if there are too few levels.  The shortest one, not stable, if none is stable.
    """
    window = None
    for levels in range(len(s), fewest_levels(s) - 1, -1):
        x = np.log(s[-levels:] / s[-1])
        window = _window(x, y[-levels:], which, tolerance)
        if window.stable:
            break
    return window


def _window(x: Array, y: Array, which: tuple[Hypothesis, ...], tolerance: float) -> Window:
    """No trend in the slope that is larger than the tolerance and significant.

    E / h^order settles: a significant parabola, too few runs of residual signs, or a curved model
    that fits better by far is a trend.
    """
    n, fit = len(x), power_fit(x, y)
    level = _levels(x, y, which, fit)
    excess = level - level.min()
    trend = (
        fit.bend < SIGNIFICANT
        or runs_probability(fit.residuals) < SIGNIFICANT
        or excess[-1] > BETTER
    )
    stable = not (trend and abs(fit.curvature) > tolerance)
    closest = float(np.exp(level.min() / (2 * n)))
    return Window(n, fit, excess[:-1], float(excess[-1]), closest, stable)


def _levels(x: Array, y: Array, which: tuple[Hypothesis, ...], fit: PowerFit) -> Array:
    """n log of the mean square residual of each hypothesis, and of the pure power at the end."""
    sums = np.append(residual_sums(x, y, which), fit.rss)
    return len(x) * np.log(sums / len(x) + RESOLUTION**2)


def ruled_out_below(s: Array, y: Array, which: tuple[Hypothesis, ...], k: float) -> bool:
    """Whether all hypotheses of an order below k are far from the best fit of a fine end of s.

    To accept an order above k is to say that no lower power hides behind scatter, on the fine
    levels where it would rule.
    """
    low = np.array([h.order < k for h in which] + [False])
    for levels in range(len(s), fewest_levels(s) - 1, -1):
        x, e = np.log(s[-levels:] / s[-1]), y[-levels:]
        level = _levels(x, e, which, power_fit(x, e))
        if level[low].min(initial=np.inf) - level.min() > FAR:
            return True
    return False


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
