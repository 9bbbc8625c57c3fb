"""The usual rules, which the simulation judges beside the judge: true if order k is accepted."""

from collections.abc import Callable

import numpy as np

from esfem.judging.fits import Array

LEAST = 0.2  # below the order, as everywhere


def all_pairs(h: Array, e: Array, k: float) -> bool:
    """Every pairwise rate is at least k - 0.2."""
    return bool((_rates(h, e) >= k - LEAST).all())


def last_pair(h: Array, e: Array, k: float) -> bool:
    """The rate of the finest pair is."""
    return bool(_rates(h, e)[-1] >= k - LEAST)


def plain_slope(h: Array, e: Array, k: float) -> bool:
    """The least-squares slope over all levels is."""
    return bool(np.polyfit(np.log(h), np.log(e), 1)[0] >= k - LEAST)


def gci(h: Array, e: Array, k: float) -> bool:
    """Roache's: the order of the three finest levels is, and they are in the asymptotic range.

    The order p solves (e1 - e2) / (e2 - e3) = (h1^p - h2^p) / (h2^p - h3^p); the range is
    |(e2 - C) / (e3 - C) / (h2 / h3)^k - 1| < 0.1 for the extrapolated C.
    """
    differences = e[-3] - e[-2], e[-2] - e[-1]
    if differences[0] * differences[1] <= 0:
        return False
    p = np.linspace(0.05, 9.0, 900)
    left = (h[-3] ** p - h[-2] ** p) / (h[-2] ** p - h[-1] ** p)
    order = float(p[np.argmin(np.abs(np.log(left * differences[1] / differences[0])))])
    if order < k - LEAST:
        return False
    C = e[-1] - differences[1] / ((h[-2] / h[-1]) ** order - 1.0)
    return bool(abs(C) < 0.1 * e[-1])


def _rates(h: Array, e: Array) -> Array:
    return np.diff(np.log(e)) / np.diff(np.log(h))


RULES: dict[str, Callable[[Array, Array, float], bool]] = {
    "all pairs": all_pairs,
    "last pair": last_pair,
    "plain slope": plain_slope,
    "GCI": gci,
}
