r"""What errors may do besides falling as a power: families of shapes, with their priors.

On the levels x = log(s / s_finest) >= 0 a model is log E = a + p x + g(x).  Most shapes bend once,

    g(x) = t log(1 + c exp(m x)),  c = +- exp(v):

a *next order* (c > 0) is A s^p + B s^(p+m), or the root of the sum of their squares (t = 1/2), a
*difference* (t = 1, c < 0) A s^p - B s^(p+m), a *saturation* (-1 <= t < 0) A s^p / (1 + C s^m)^|t|;
a *log factor* is A s^p log(S / s).  All of these are of order p, and p is free.  A *drift* is a
slope that goes on changing: its order is the slope two levels beyond the finest, for nothing says
where it ends.

A *plateau* A s^p + C and *rounding*, A s^p + C s^-r, have the slope 0 or -r of their last part, and
the order p of their first one; errors that *turn* fall and then grow for good; *no order* has no
slope.  Each shape tells how much of the finest error belongs to a floor.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from esfem.judging.table_columns import Array

# The priors of the families, by what is seen in published tables: most are a power, perhaps with a
# visible next term.
FAMILIES = {
    "pure power": 0.34,
    "next order": 0.24,
    "difference": 0.10,
    "saturation": 0.10,
    "log factor": 0.01,
    "drift": 0.03,
    "plateau": 0.08,
    "rounding": 0.03,
    "turn": 0.02,
    "no order": 0.05,
}
NAMES = tuple(FAMILIES)
# Gaps between two exponents: whole steps are the rule.
GAPS = {0.25: 0.03, 1 / 3: 0.03, 0.5: 0.12, 0.75: 0.05, 1.0: 0.33, 1.5: 0.08, 2.0: 0.28, 3.0: 0.08}
POWERS = {-1.0: 0.5, -0.5: 0.3, -0.3: 0.2}  # t of saturations
SQUARES = 0.2  # prior of two parts whose squares add
SHOWS = 0.03  # share of the coarsest error from which on a second term is one
RULED, GROWN = 2.0, 4.0  # what falls to a floor, or to a growing one, was once so much larger
LEAST_ORDER = 0.2  # of what falls
NEVER = -9.0  # the order of errors that have none
SPLIT = 5  # parts of a step in v, where the data tell them apart


@dataclass(frozen=True)
class Orders:
    """What models say of the order, an entry each.

    ``slope`` is p where it is not free, else NaN; then ``order`` is the order.  With a free slope
    the order is slope + ``shift``, and more than ``least``: a further term that does not fall is a
    floor.  ``floor`` is the share of a floor in the finest error, and ``family`` an index of
    `NAMES`.
    """

    family: NDArray[np.int_]
    least: Array
    slope: Array
    order: Array
    shift: Array
    floor: Array

    def __len__(self) -> int:
        return len(self.family)


@dataclass(frozen=True)
class Shapes(Orders):
    """g on each level, (shapes, n), with log priors that sum to one over all families.

    Of shapes that bend once ``t``, ``sign``, ``m`` and ``v``, with the step ``dv`` to the next one;
    NaN of others.
    """

    g: Array
    prior: Array
    t: Array
    sign: Array
    m: Array
    v: Array
    dv: Array

    def at(self, chosen: NDArray[np.int_]) -> "Shapes":
        """Some of them."""
        return Shapes(**{name: values[chosen] for name, values in vars(self).items()})

    def split(self, x: Array) -> "Shapes":
        """Shapes that bend once, each in `SPLIT` along v, on levels x."""
        part = self.at(np.repeat(np.arange(len(self)), SPLIT))
        within = (np.arange(SPLIT) - (SPLIT - 1) / 2) / SPLIT
        v = part.v + part.dv * np.tile(within, len(self))
        new = {
            "v": v,
            "g": _bend(x, part.t, part.sign, part.m, v),
            "prior": part.prior - np.log(SPLIT),
            "floor": np.where(part.floor > 0, 1.0 / (1.0 + np.exp(v)), 0.0),
        }
        return Shapes(**{**vars(part), **new})


def shapes(x: Array, k: float, step: float, plateaus: bool) -> Shapes:
    """All shapes on levels x, (n,), coarse to fine, about a claimed order k.

    ``step`` is log of the ratio of levels; ``plateaus`` is False where the floors are known.
    """
    return _shapes(tuple(x.tolist()), k, step, plateaus)


@lru_cache(maxsize=32)
def _shapes(levels: tuple[float, ...], k: float, step: float, plateaus: bool) -> Shapes:
    x = np.array(levels)
    parts = [
        _pure(x),
        _next_orders(x),
        _differences(x),
        _saturations(x),
        _log_factors(x),
        _drifts(x, step),
        _none(x),
        *([_turns(x, k)] if len(x) > 3 else []),
        *([_plateaus(x, k), _rounding(x, k)] if plateaus else []),
    ]
    joined = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in vars(parts[0])
    }
    joined["prior"] -= np.log(np.exp(joined["prior"]).sum())
    return Shapes(**joined)


def _bend(x: Array, t: Array, sign: Array, m: Array, v: Array) -> Array:
    """t log(1 +- exp(v + m x)), (shapes, n)."""
    part = sign[:, None] * np.exp(v[:, None] + m[:, None] * x)
    return t[:, None] * np.log1p(np.maximum(part, -1.0 + 1e-9))


def _family(name: str, g: Array, weights: Array | float = 1.0, **facts: Array | float) -> Shapes:
    """Shapes of one family, whose weights are scaled to its prior."""
    n = len(g)
    w = np.broadcast_to(np.asarray(weights, float), n)
    blank = dict.fromkeys(("slope", "order", "t", "sign", "m", "v", "dv"), np.nan)
    full = {**blank, "least": -np.inf, "shift": 0.0, "floor": 0.0, **facts}
    return Shapes(
        g=g,
        prior=np.log(FAMILIES[name] * w / w.sum()),
        family=np.full(n, NAMES.index(name)),
        **{key: np.broadcast_to(np.asarray(v, float), n).copy() for key, v in full.items()},
    )


def _bends(name: str, x: Array, weights: Array, bend: dict[str, Array], **facts: Array) -> Shapes:
    """Shapes that bend once."""
    g = _bend(x, bend["t"], bend["sign"], bend["m"], bend["v"])
    return _family(name, g, weights, **bend, **facts)


def _steps(low: Array, high: Array, count: int) -> tuple[Array, Array]:
    """The middles of so many steps between each low and high, and their lengths; one after the
    other."""
    length = (high - low) / count
    middles = low[:, None] + length[:, None] * (np.arange(count) + 0.5)
    return middles.ravel(), np.repeat(length, count)


def _weighted(table: dict[float, float]) -> tuple[Array, Array]:
    return np.array(list(table)), np.array(list(table.values()))


def _pure(x: Array) -> Shapes:
    return _family("pure power", np.zeros((1, len(x))))


def _next_orders(x: Array, count: int = 12) -> Shapes:
    """From a second term of 3 % on the coarsest level to as much as the first on the finest one;
    norms add, or squares of them."""
    gaps, weights = _weighted(GAPS)
    v, dv = _steps(np.minimum(np.log(SHOWS) - gaps * x.max(), -1.0), 0.0 * gaps, count)
    m, one = np.repeat(gaps, count), np.ones(len(gaps) * count)
    bend = {
        "t": np.concatenate([one, 0.5 * one]),
        "sign": np.ones(2 * len(m)),
        **{name: np.concatenate([u, 2.0 * u]) for name, u in (("m", m), ("v", v), ("dv", dv))},
    }
    w = np.outer([1.0 - SQUARES, SQUARES], np.repeat(weights, count)).ravel()
    return _bends("next order", x, w, bend, least=np.full(len(w), LEAST_ORDER))


def _differences(x: Array, count: int = 10) -> Shapes:
    """What is taken away is 3 to 95 % on the coarsest level."""
    gaps, weights = _weighted(GAPS)
    top = gaps * x.max()
    v, dv = _steps(np.log(SHOWS) - top, np.log(0.95) - top, count)
    m = np.repeat(gaps, count)
    one = np.ones_like(m)
    bend = {"t": one, "sign": -one, "m": m, "v": v, "dv": dv}
    share = np.exp(v + m * x.max())  # even in the share, not in its logarithm
    return _bends("difference", x, np.repeat(weights, count) * share, bend)


def _saturations(x: Array, count: int = 9) -> Shapes:
    gaps, weights = _weighted(GAPS)
    v, dv = _steps(np.minimum(np.log(SHOWS) - gaps * x.max(), -1.0), 0.0 * gaps, count)
    powers, how_often = _weighted(POWERS)
    m, w = np.repeat(gaps, count), np.repeat(weights, count)
    bend = {"m": m, "v": v, "dv": dv}
    bend = {name: np.tile(values, len(powers)) for name, values in bend.items()}
    bend["t"], bend["sign"] = np.repeat(powers, len(m)), np.ones(len(m) * len(powers))
    return _bends("saturation", x, np.outer(how_often, w).ravel(), bend)


def _log_factors(x: Array) -> Shapes:
    beyond = np.array([0.4, 0.7, 1.1, 1.6, 2.5, 4.0])
    return _family("log factor", np.log(beyond[:, None] + x.max() - x))


def _drifts(x: Array, step: float) -> Shapes:
    """Slopes that change by so much over the table, and as fast over two levels more."""
    change = np.array([-1.0, -0.6, -0.35, -0.2, -0.1, -0.05, 0.05, 0.1, 0.2, 0.35, 0.6, 1.0])
    c = change / float(x.max())
    return _family("drift", 0.5 * c[:, None] * x**2, shift=-2.0 * step * c)


def _none(x: Array) -> Shapes:
    return _family("no order", np.zeros((1, len(x))), slope=0.0, order=NEVER)


def _plateaus(x: Array, k: float) -> Shapes:
    return _floors("plateau", x, k, _orders(k), np.zeros(1), 12)


def _rounding(x: Array, k: float) -> Shapes:
    return _floors("rounding", x, k, _orders(k)[::2], np.array([0.6, 1.4]), 9)


def _floors(name: str, x: Array, k: float, orders: Array, growths: Array, count: int) -> Shapes:
    """What falls is `RULED` or `GROWN` times the floor on the coarsest level, and the floor shows
    on the finest."""
    p, r = (axis.ravel() for axis in np.meshgrid(orders, growths, indexing="ij"))
    low = np.minimum(np.log(np.where(r > 0.0, GROWN, RULED)) - (p + r) * x.max(), 0.0)
    v, dv = _steps(low, np.full(len(p), np.log(20.0)), count)
    p, r = np.repeat(p, count), np.repeat(r, count)
    one = np.ones_like(p)
    bend = {"t": one, "sign": one, "m": p + r, "v": v, "dv": dv}
    facts = {"slope": -r, "order": p, "floor": 1.0 / (1.0 + np.exp(v))}
    return _bends(name, x, 1.0 / (1.0 + np.abs(p - k)), bend, **facts)


def _orders(k: float) -> Array:
    """Orders of a part that falls to a floor: quarters about the claim."""
    p: Array = np.maximum(k + 0.25 * np.arange(-12, 13), LEAST_ORDER)
    return np.unique(p)


def _turns(x: Array, k: float) -> Shapes:
    """Down with an order, then up with another from one of the inner levels on."""
    axes = np.meshgrid(k + np.array([-1.0, 0.0, 1.0]), np.array([2.0, 3.0, 5.0, 8.0]), x[1:-1])
    down, up, at = (axis.ravel()[:, None] for axis in axes)
    g = down * np.maximum(x - at, 0.0) - up * np.minimum(x, at)
    return _family("turn", g, slope=0.0, order=NEVER)
