"""The probability of orders: models and patterns of scatter, averaged.

For each shape (`families`) and each pattern of scatter (`scatter`) the constant is integrated out
under a flat prior, and the slope under a prior with three parts: single orders, which are the
claimed one and its half and whole neighbours, a normal part about the claim, and an even one.  What
is left are weights of normal distributions and of single orders.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from esfem.judging.families import NAMES, NEVER, Orders, Shapes
from esfem.judging.scatter import Patterns
from esfem.judging.table_columns import Array

LOWEST, HIGHEST = -3.0, 5.0  # orders thought of: from the first up to the claim + the second
# Single orders, from the claim: half and whole steps are the rule.
STEPS = {
    **{0.0: 0.20, -1.0: 0.11, 1.0: 0.07, -0.5: 0.09, 0.5: 0.04, -2.0: 0.025, 2.0: 0.025},
    **{-1.5: 0.015, 1.5: 0.01, -3.0: 0.0075, 3.0: 0.0075},
}
NEAR, REACH = 0.28, 0.8  # the prior of others near the claim, normal, and their reach
EVEN = 0.12  # the prior of all others
TINY = 1e-7  # an order is not told better
LEFT_OUT = 6.0  # minus log of the share of all that may be left out, part by part
NEGLIGIBLE = 13.0  # in log weight below the best: left out
UNSPLIT = 60.0  # in log likelihood, that finer shapes may add
CONSIDERED = 8.0  # in log weight below the best: split, the likeliest up to a number
MOST_SPLIT = 120

Index = NDArray[np.int_]


@dataclass(frozen=True)
class Posterior:
    """Weights that sum to one, of normal distributions of the order or of single orders (sd 0).

    ``shape`` and ``pattern`` are the indices of the shape and the pattern of scatter of each part,
    ``floor`` the share of a floor in the finest error, ``family`` an index of `families.NAMES`;
    all (parts,).
    """

    weight: Array
    mean: Array
    sd: Array
    shape: Index
    pattern: Index
    floor: Array
    family: Index

    def cumulative(self, order: float) -> Array:
        """The probability of an order below this one, for each part."""
        point = self.sd == 0
        z = (order - self.mean) / np.where(point, 1.0, self.sd)
        return np.where(point, (self.mean < order).astype(float), ndtr(z))

    def below(self, order: float) -> float:
        """The probability of an order below this one."""
        return min(float(self.weight @ self.cumulative(order)), 1.0)

    def share(self, where: NDArray[np.bool_]) -> float:
        """The probability of what is true ``where``."""
        return min(float(self.weight @ where), 1.0)

    def quantile(self, *shares: float) -> list[float]:
        """The orders below which the probabilities are these."""
        weight, mean, sd = self._gathered()
        low = np.full(len(shares), NEVER - 1.0)
        high = np.full(len(shares), float((mean + 8.0 * sd).max()) + 1.0)
        safe = np.where(sd > 0, sd, TINY)
        while (high - low).max() > TINY:
            middle = 0.5 * (low + high)
            less = ndtr((middle[:, None] - mean) / safe) @ weight < shares
            low, high = np.where(less, middle, low), np.where(less, high, middle)
        return [float(order) for order in high]

    def _gathered(self) -> tuple[Array, Array, Array]:
        """Weights, means and standard deviations, those that are alike taken together."""
        scale = np.where(self.sd > 0, np.rint(4.0 * np.log(np.maximum(self.sd, TINY))), -1e4)
        place = np.rint(self.mean / np.maximum(0.25 * self.sd, 1e-4))
        key = (scale * 1e7 + place).astype(np.int64)
        cell = np.unique(key, return_inverse=True)[1]
        weight: Array = np.bincount(cell, self.weight).astype(float)
        mean: Array = np.bincount(cell, self.weight * self.mean) / weight
        sd: Array = np.bincount(cell, self.weight * self.sd) / weight
        return weight, mean, sd

    def mean_in(self, family: str) -> float:
        """The mean order if errors are of this family."""
        own = self.weight * (self.family == NAMES.index(family))
        return float(own @ self.mean / own.sum())

    def families(self) -> dict[str, float]:
        """The probability of each family, the likeliest first."""
        found = np.bincount(self.family, self.weight, len(NAMES))
        return {NAMES[i]: float(found[i]) for i in np.argsort(-found) if found[i] > 0}


def line_posterior(
    y: Array, x: Array, k: float, models: Shapes, noise: Patterns
) -> tuple[Posterior, Array]:
    """The posterior of log errors y on levels x about a claimed order k, for one line of levels,
    and its mean rates from level to level, (n - 1,), where no floor or turn is.

    Shapes that bend are split where the data are fine enough to tell their parts apart.
    """
    level, slope, sd = _likelihood(y, x, models, noise)
    whole = _whole(level, slope, sd, k, models)
    # A finer shape may make the small sizes of scatter likelier, never the large ones.
    likely = whole.max(axis=0)
    small = noise.size <= noise.size[int(np.argmax(likely))]
    kept = (likely > likely.max() - NEGLIGIBLE) | (small & (likely > likely.max() - UNSPLIT))
    noise, level, slope, sd = noise.at(kept), level[:, kept], slope[:, kept], sd[kept]
    whole = whole[:, kept].max(axis=1)
    bent = np.isfinite(models.v) & (whole > whole.max() - CONSIDERED)
    chosen = np.flatnonzero(bent)
    chosen = chosen[np.argsort(-whole[chosen])[:MOST_SPLIT]]
    finer = models.at(chosen).split(x)
    others = np.setdiff1d(np.flatnonzero(whole > whole.max() - NEGLIGIBLE), chosen)
    finer_level, finer_slope, _ = _likelihood(y, x, finer, noise)
    joined = models.at(others)
    joined = Shapes(
        **{n: np.concatenate([values, getattr(finer, n)]) for n, values in vars(joined).items()}
    )
    level = np.concatenate([level[others], finer_level])
    slope = np.concatenate([slope[others], finer_slope])
    found = mixture(level, slope, sd, k, joined)
    found = replace(found, pattern=np.flatnonzero(kept)[found.pattern])
    return found, _mean_rates(found, joined, x)


def _mean_rates(found: Posterior, models: Shapes, x: Array) -> Array:
    """The rates of consecutive levels, averaged over the shapes whose slope is free; NaN where
    those are the less likely."""
    free = np.where(np.isnan(models.slope), 1.0, 0.0)
    slope = (found.mean - models.shift[found.shape]) * free[found.shape]
    weight = np.bincount(found.shape, found.weight, len(models)) * free
    bend = np.diff(models.g, axis=1) / np.diff(x)
    whole = float(weight.sum())
    rates: Array = (found.weight @ slope + weight @ bend) / max(whole, TINY)
    return rates if whole > 0.5 else np.nan * rates


def _likelihood(y: Array, x: Array, models: Shapes, noise: Patterns) -> tuple[Array, Array, Array]:
    """log of likelihood times prior at the best slope, that slope, (shapes, patterns), and its
    standard deviation, (patterns,).

    Where an order has to be more than some least one, the part of the slopes above it counts.
    """
    precise = noise.precise
    one = precise.sum(axis=2)
    total = one.sum(axis=1)
    across = precise @ x - one * (one @ x / total)[:, None]
    spread = across @ x
    residual = y - models.g
    residual = residual - residual.mean(axis=1, keepdims=True)
    i, j = np.triu_indices(len(x))
    twice = np.where(i == j, 1.0, 2.0)
    slope = residual @ (across / spread[:, None]).T
    rss = (residual[:, i] * residual[:, j]) @ (precise[:, i, j] * twice).T
    rss -= (residual @ (one / np.sqrt(total)[:, None]).T) ** 2
    rss -= slope**2 * spread
    np.maximum(rss, 0.0, out=rss)
    rss *= -0.5
    rss += noise.prior + noise.log_det - 0.5 * np.log(total)
    rss += models.prior[:, None]
    sd = 1.0 / np.sqrt(spread)
    bound = np.flatnonzero(np.isfinite(models.least))
    above = ndtr((slope[bound] - models.least[bound, None]) / sd)
    rss[bound] += np.log(np.maximum(above, 1e-30))
    return rss, slope, sd


def _whole(level: Array, slope: Array, sd: Array, k: float, models: Orders) -> Array:
    """The log weights, with the slope integrated over its even prior, or fixed."""
    fixed = np.isfinite(models.slope)
    width = k + HIGHEST - LOWEST
    result = level + np.log(EVEN * np.sqrt(2 * np.pi) / width * sd)
    off = (slope[fixed] - models.slope[fixed, None]) / np.broadcast_to(sd, slope.shape)[fixed]
    result[fixed] = level[fixed] - 0.5 * off**2
    return result


def mixture(level: Array, slope: Array, sd: Array, k: float, models: Orders) -> Posterior:
    """The normal distributions and the single orders of shapes and patterns, (shapes, patterns).

    ``level`` is the log of the likelihood at the best ``slope``, whose standard deviation is
    ``sd``, times the prior.
    """
    whole, fixed = _whole(level, slope, sd, k, models), np.isfinite(models.slope)
    sd = np.broadcast_to(sd, slope.shape)
    best = whole.max()
    # What is left out, part by part, is together less than exp(-LEFT_OUT) of all.
    least = max(best - NEGLIGIBLE, _log_sum(whole) - np.log(whole.size) - LEFT_OUT)
    parts = []
    at = np.nonzero(fixed[:, None] & (whole > least))
    parts.append((whole[at], models.order[at[0]], np.zeros(len(at[0])), *at))
    at = np.nonzero(~fixed[:, None] & (level > least))
    mean, own_sd, lowest = slope[at] + models.shift[at[0]], sd[at], models.least[at[0]]
    parts.append((whole[at], mean, own_sd, *at))
    wide = own_sd**2 + REACH**2
    level_near = np.log(NEAR) + level[at] + np.log(own_sd) - 0.5 * np.log(wide)
    level_near -= 0.5 * (mean - k) ** 2 / wide
    mean_near = (mean * REACH**2 + k * own_sd**2) / wide
    parts.append((level_near, mean_near, own_sd * REACH / np.sqrt(wide), *at))
    for step, share in STEPS.items():
        log_weight = np.log(share) + level[at] - 0.5 * ((k + step - mean) / own_sd) ** 2
        kept = (log_weight > least) & (k + step > lowest)
        single = np.full(int(kept.sum()), k + step)
        parts.append((log_weight[kept], single, 0.0 * single, at[0][kept], at[1][kept]))
    joined = [np.concatenate(values) for values in zip(*parts, strict=True)]
    kept = joined[0] > least
    log_weight, mean, own_sd, shape, pattern = (values[kept] for values in joined)
    weight = np.exp(log_weight - log_weight.max())
    return Posterior(
        weight / weight.sum(),
        mean,
        own_sd,
        shape,
        pattern,
        models.floor[shape],
        models.family[shape],
    )


def _log_sum(levels: Array) -> float:
    """log of the sum of exponentials."""
    top = float(levels.max())
    return top + float(np.log(np.exp(levels - top).sum()))
