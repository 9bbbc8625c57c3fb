"""Errors over the levels of one line, before scatter: the shapes of the synthetic tables.

Each is a function of a generator, the levels h from coarse to fine and an order k.
"""

from collections.abc import Callable

import numpy as np

from esfem.judging.table_columns import Array

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


GAPS = 0.25 * np.arange(1, 13)  # between two powers


def fractional_sum(rng: Rng, h: Array, p: float) -> Array:
    """h^p + c h^(p+m), m in steps of 1/4, the first 50 to 95 % on the finest level."""
    return two_powers(0.0, float(rng.choice(GAPS)), (0.5, 0.95))(rng, h, p)


def fractional_saturation(rng: Rng, h: Array, p: float) -> Array:
    """h^p / (1 + c h^m)^s, m in steps of 1/4, s = 0.3 to 1, c h^m 5 to 50 % on the finest level."""
    c, m = log_uniform(rng, 0.05, 0.5), rng.choice(GAPS)
    return h**p / (1.0 + c * (h / h[-1]) ** m) ** rng.uniform(0.3, 1.0)


def fractional_difference(rng: Rng, h: Array, p: float) -> Array:
    """h^p (1 - c h^m), m in steps of 1/4, c h^m 10 to 70 % on the coarsest level."""
    return h**p * (1.0 - rng.uniform(0.1, 0.7) * (h / h[0]) ** rng.choice(GAPS))


def log_periodic(rng: Rng, h: Array, p: float) -> Array:
    """h^p exp(a sin(w log h + phase)), a = 2 to 15 %, a period of 2 to 16 in h."""
    a, w = log_uniform(rng, 0.02, 0.15), 2.0 * np.pi / np.log(log_uniform(rng, 2.0, 16.0))
    return h**p * np.exp(a * np.sin(w * np.log(h) + rng.uniform(0.0, 2.0 * np.pi)))


def log_factor(rng: Rng, h: Array, p: float) -> Array:
    """h^p log(H / h), H 1.5 to 5 times the coarsest level: of order p."""
    return h**p * np.log(log_uniform(rng, 1.5, 5.0) * h[0] / h)


def root_of_squares(a: Array, b: Array, rho: float) -> Array:
    """sqrt(a^2 + 2 rho a b + b^2): errors add as vectors."""
    return np.sqrt(np.maximum(a**2 + 2.0 * rho * a * b + b**2, 1e-24 * (a**2 + b**2)))


def squares(rng: Rng, h: Array, p: float) -> Array:
    """Powers p and p + m, m = 1/2 .. 2, added in squares; the second 2 to 50 % on the finest."""
    s, m = h / h[-1], rng.choice([0.5, 1.0, 1.5, 2.0])
    second = log_uniform(rng, 0.02, 0.5) * s ** (p + m)
    return root_of_squares(s**p, second, rng.uniform(-1.0, 1.0))


def wild_coarse(rng: Rng, h: Array, p: float) -> Array:
    """h^p, the coarsest levels, 1 to 3 of them but not the last four, off by 1.5 to 10 times."""
    e, n = h**p, int(rng.integers(1, min(3, len(h) - 4) + 1))
    e[:n] *= np.exp(rng.choice([-1.0, 1.0], n) * rng.uniform(np.log(1.5), np.log(10.0), n))
    return e


def singular(rng: Rng, h: Array, p: float) -> Array:
    """h^p + c h^(p+1/3), as on L-shaped domains: the first is 50 to 90 % on the finest level."""
    return two_powers(0.0, 1.0 / 3.0, (0.5, 0.9))(rng, h, p)


def next_term(rng: Rng, h: Array, p: float) -> Array:
    """h^p and a next term, 1 or 2 higher, of either sign, up to half of the error on the coarsest
    level, as in published tables."""
    part, m = rng.uniform(-0.5, 0.5), rng.integers(1, 3)
    return h**p * (1.0 + part / (1.0 - part) * (h / h[0]) ** m)


def three_powers(rng: Rng, h: Array, p: float) -> Array:
    """h^p + b h^(p+1) + c h^(p+2), b and c of either sign, together below half on the coarsest."""
    b, c = rng.uniform(-0.3, 0.3, 2)
    s = h / h[0]
    return h**p * (1.0 + b * s + c * s**2)


def parity(rng: Rng, h: Array, p: float) -> Array:
    """h^p, every other level up by 5 to 40 % at first, by half of that from level to level."""
    swing = rng.uniform(0.05, 0.4) * 0.5 ** np.arange(len(h))
    return h**p * (1.0 + swing * (np.arange(len(h)) % 2))


def exponential_start(rng: Rng, h: Array, p: float) -> Array:
    """h^p (1 + c exp(-b (h_0/h - 1))): a start that is no power and soon over."""
    c, b = rng.uniform(-0.6, 2.0), rng.uniform(0.5, 2.0)
    return h**p * (1.0 + c * np.exp(-b * (h[0] / h - 1.0)))
