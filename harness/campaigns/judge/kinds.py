r"""Synthetic tables with known truth.  What is right was settled before the first run.

Truth is the order as the swept parameter goes to 0 with the other term of the error taken away:
of A h^p + B tau^q swept in h it is p, of 10 h^3 + 0.03 h it is 1, of errors that grow or never
settle it is negative or 0.  With d = 0.2 and claim k:

* a *false pass* is PASS or SUPER where truth < k - d, or where the terms cancel (truth NaN);
* a *false fail* is FAIL or SUSPECT where truth >= k - d, but SUSPECT is right above k + 1.5;
* INCONCLUSIVE is never false, and it is not right either: its share is shown.

Where two terms make an error, the one that rules as h -> 0 is at least as large as the other on the
finest level: if it were smaller, the table would not show the order that counts as its truth.  The
kinds marked ``limit`` leave that ground: *hidden*, where the low power holds only 10 to 50 % on the
finest level, and *close*, h^(k+1/2) + h^(k-1/2) claimed to be k, whose slope over four levels is k
to 0.2.  They are shown apart and not in the totals.

*Clean* tables, which should PASS: a pure power of the claimed order, five levels or more, scatter
of 2 % at most.  Every kind draws k = 1..5, 4 to 8 levels at ratios 2^(-1/2), 1/2 or unequal, and
scatter of 0, 1, 2, 5 or 10 % (log-normal) unless its docstring says otherwise.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from esfem.judging.fits import Array
from esfem.judging.floors import Floor
from esfem.judging.validate import Direction

SCATTERS = (0.0, 0.01, 0.02, 0.05, 0.10)
RATIOS = ("2^-1/2", "1/2", "unequal")
NAN = float("nan")
Rng = np.random.Generator


@dataclass(frozen=True)
class Instance:
    """One table with its claim and truth, ``scatter`` and ``levels`` as drawn."""

    table: pd.DataFrame
    claim: float
    truth: float
    scatter: float
    levels: int
    clean: bool = False
    direction: Direction = "h"
    floors: tuple[Floor, ...] = ()
    other_order: float | None = None


@dataclass(frozen=True)
class Kind:
    """A kind of tables; ``draw`` makes one."""

    name: str
    draw: Callable[[Rng], Instance]
    limit: bool = False


def ladder(rng: Rng, fewest: int = 4) -> Array:
    """Levels, coarse to fine."""
    levels, ratio = int(rng.integers(fewest, 9)), RATIOS[rng.integers(3)]
    steps = {
        "2^-1/2": np.full(levels - 1, 0.5**0.5),
        "1/2": np.full(levels - 1, 0.5),
        "unequal": rng.uniform(0.45, 0.8, levels - 1),
    }[ratio]
    return rng.uniform(0.3, 1.0) * np.cumprod(np.append(1.0, steps))


def log_uniform(rng: Rng, low: float, high: float) -> float:
    """A number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def table_of(rng: Rng, h: Array, e: Array, scatter: float) -> pd.DataFrame:
    """The table of errors e, in units of their own, with scatter."""
    e = log_uniform(rng, 1e-3, 1e3) * e * np.exp(scatter * rng.normal(size=len(h)))
    return pd.DataFrame({"h": h, "error": e})


def clean(rng: Rng) -> Instance:
    """A pure power, as claimed, of five levels or more with scatter of 2 % at most."""
    k, h, scatter = (
        float(rng.integers(1, 6)),
        ladder(rng, fewest=5),
        float(rng.choice(SCATTERS[:3])),
    )
    return Instance(table_of(rng, h, h**k, scatter), k, k, scatter, len(h), clean=True)


Shape = Callable[[Rng, Array, float], Array]  # errors at levels h about the order k


def one_line(
    shape: Shape, gain: float = 0.0, truth: float = 0.0, least: int = 1
) -> Callable[[Rng], Instance]:
    """Tables of ``shape`` about k, claimed to be k + ``gain``, in truth of order k + ``truth``."""

    def draw(rng: Rng) -> Instance:
        k, h = float(rng.integers(least, 6)), ladder(rng)
        scatter = float(rng.choice(SCATTERS))
        table = table_of(rng, h, shape(rng, h, k), scatter)
        return Instance(table, k + gain, k + truth, scatter, len(h))

    return draw


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
