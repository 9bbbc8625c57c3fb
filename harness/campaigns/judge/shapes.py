"""Errors over the levels of one line, before scatter: the shapes of the synthetic tables.

Each is a function of a generator, the levels h from coarse to fine and an order k.
"""

from collections.abc import Callable

import numpy as np

from esfem.judging.fits import Array

Rng = np.random.Generator
Shape = Callable[[Rng, Array, float], Array]


def log_uniform(rng: Rng, low: float, high: float) -> float:
    """A number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def pure(shift: float) -> Shape:
    """h^(k + shift)."""
    return lambda rng, h, k: h ** (k + shift)


def plateau(shift: float) -> Shape:
    """h^(k + shift) + C, where C is a fifth of the error at most on the coarsest level."""
    return lambda rng, h, k: (h / h[0]) ** (k + shift) + 1.0 / log_uniform(rng, 4.0, 1000.0)


def early(rng: Rng, h: Array) -> Array:
    """c h^r, r = 1 or 2: 5 to 100 % on the finest level."""
    return log_uniform(rng, 0.05, 1.0) * (h / h[-1]) ** rng.integers(1, 3)


def from_above(rng: Rng, h: Array, k: float) -> Array:
    """h^k (1 + c h^r)."""
    return h**k * (1.0 + early(rng, h))


def from_below(rng: Rng, h: Array, k: float) -> Array:
    """h^k / (1 + c h^r)."""
    return h**k / (1.0 + early(rng, h))


def from_below_slowly(rng: Rng, h: Array, k: float) -> Array:
    """h^k / (1 + c h^r)^s with s = 0.2 to 0.9, which none of the judge's models is."""
    return h**k / (1.0 + early(rng, h)) ** rng.uniform(0.2, 0.9)


def from_below_difference(rng: Rng, h: Array, k: float) -> Array:
    """h^k (1 - c h^r)."""
    return h**k * (1.0 - rng.uniform(0.1, 0.9) * (h / h[0]) ** rng.integers(1, 3))


def two_powers(low: float, high: float, share: tuple[float, float]) -> Shape:
    """h^(k + high) + c h^(k + low), whose share on the finest level is drawn."""

    def shape(rng: Rng, h: Array, k: float) -> Array:
        part, s = rng.uniform(*share), h / h[-1]
        return (1.0 - part) * s ** (k + high) + part * s ** (k + low)

    return shape


def odd_powers(rng: Rng, h: Array, k: float) -> Array:
    """Two powers 0.75 to 1.5 above and below k: gaps that none of the judge's hypotheses has."""
    low, high = -rng.uniform(0.75, 1.5), rng.uniform(0.75, 1.5)
    return two_powers(low, high, (0.5, 0.95))(rng, h, k)


def grows_late(rng: Rng, h: Array, k: float) -> Array:
    """h^k, and from one of the last three levels on growth by 2 to 5 a level."""
    late = int(rng.integers(1, 4))
    e = h**k
    e[-late:] = e[-late - 1] * np.cumprod(rng.uniform(2.0, 5.0, late))
    return e


def zigzag(shift: float) -> Shape:
    """h^(k + shift), every other level 10 to 30 % up."""
    return lambda rng, h, k: h ** (k + shift) * rng.uniform(1.1, 1.3) ** (np.arange(len(h)) % 2)


def outlier(shift: float) -> Shape:
    """h^(k + shift), one level 1.5 to 3 times up or down."""

    def shape(rng: Rng, h: Array, k: float) -> Array:
        e = h ** (k + shift)
        e[rng.integers(len(h))] *= rng.uniform(1.5, 3.0) ** rng.choice([-1, 1])
        return e

    return shape


def noisy(shift: float) -> Shape:
    """h^(k + shift) with scatter of 30 to 60 % more."""
    return lambda rng, h, k: (
        h ** (k + shift) * np.exp(rng.uniform(0.3, 0.6) * rng.normal(size=len(h)))
    )


def flat(rng: Rng, h: Array, k: float) -> Array:
    """The same error on all levels."""
    return np.ones_like(h)


def wild(rng: Rng, h: Array, k: float) -> Array:
    """No order at all: log-normal, a factor e either way."""
    return np.exp(rng.normal(size=len(h)))
