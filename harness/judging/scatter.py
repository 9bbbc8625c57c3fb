"""How errors scatter about their law: sizes and patterns, with their priors.

Scatter of log E is normal.  Its size is unknown; levels scatter independently and alike, or add up
from level to level, or the coarse ones scatter more; one level may be an outlier, and the coarsest
ones may be pre-asymptotic, off by a factor that has nothing to do with the rest.  Digits that were
printed add the variance of their rounding.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from esfem.judging.table_columns import Array

SIZES = np.array([5e-4, 1.2e-3, 2.8e-3, 6.5e-3, 0.015, 0.035, 0.08, 0.18, 0.4, 0.9])
SIZE_PRIOR = np.array([1.0, 1.0, 1.0, 1.2, 1.3, 1.3, 1.1, 0.7, 0.25, 0.06])
ALIKE, WALK, COARSE = 0.74, 0.08, 0.08  # priors of the patterns
OUTLIER = 0.015  # of a level
WILD = 0.06  # of the coarsest level, and half as often of each one more
LAST = 3  # levels that are never pre-asymptotic
FAR = 0.8  # standard deviation of log E of an outlier or a wild level
RESOLUTION = 1e-6  # relative: no error is trusted beyond it
MOST_DIGITS = 7  # an error with more digits was not rounded for printing


@dataclass(frozen=True)
class Patterns:
    """Inverse covariances of log E, (patterns, n, n), with half the logarithm of their
    determinants.

    ``off`` tells which levels a pattern says to be off, (patterns, n); ``size`` the scatter of the
    others.
    """

    precise: Array
    log_det: Array
    prior: Array
    size: Array
    off: Array

    def at(self, chosen: NDArray[np.bool_]) -> "Patterns":
        """Some of them."""
        return Patterns(**{name: values[chosen] for name, values in vars(self).items()})


def patterns(errors: Array, x: Array) -> Patterns:
    """All patterns of the scatter of errors on levels x, coarse to fine."""
    n = len(errors)
    printed = printed_variance(errors)
    coarse = 0.2 + 0.8 * np.exp(x - x.max())  # the coarsest up to 5 times the finest
    off = [np.zeros(n)]
    how_often = [1.0]
    if n > 3:
        off += list(np.eye(n))
        how_often += [OUTLIER] * n
    for count in range(1, max(n - LAST, 1) + 1) if n > 3 else ():
        off.append((np.arange(n) < count).astype(float))
        how_often.append(WILD * 0.5 ** (count - 1))
    outs, often = np.array(off), np.array(how_often)
    sizes, share = SIZES[:, None], (SIZE_PRIOR / SIZE_PRIOR.sum())[:, None]
    # Independent, with a level off or none, and the coarse ones more; (patterns, n).
    variance = (sizes[:, :, None] ** 2 + FAR**2 * outs).reshape(-1, n) + printed
    variance = np.concatenate([variance, (5.0 * sizes * coarse) ** 2 + printed])
    steps = np.arange(n)[::-1]
    walk = np.minimum(steps[:, None], steps[None, :]) + 0.1 * np.eye(n)
    walks = sizes[:, :, None] ** 2 * walk + np.diag(printed)
    prior = np.concatenate(
        [(share * ALIKE * often).ravel(), share.ravel() * COARSE, share.ravel() * WALK]
    )
    return Patterns(
        precise=np.concatenate([np.eye(n) / variance[:, None, :], np.linalg.inv(walks)]),
        log_det=-0.5 * np.concatenate([np.log(variance).sum(axis=1), np.linalg.slogdet(walks)[1]]),
        prior=np.log(prior / prior.sum()),
        size=np.concatenate([np.repeat(SIZES, len(outs)), SIZES, SIZES]),
        off=np.concatenate([np.tile(outs, (len(SIZES), 1)), np.zeros((2 * len(SIZES), n))]),
    )


def printed_digits(errors: Array) -> int:
    """Significant digits that tell all errors; one more than `MOST_DIGITS` if those do not."""
    exponents = np.floor(np.log10(errors))
    mantissas = errors / 10.0**exponents
    for digits in range(1, MOST_DIGITS + 1):
        scaled = mantissas * 10.0 ** (digits - 1)
        if (np.abs(scaled - np.rint(scaled)) < 1e-7 * scaled).all():
            return digits
    return MOST_DIGITS + 1


def printed_variance(errors: Array) -> Array:
    """Of log E, by rounding to the digits that were printed, and by what is never resolved."""
    digits = printed_digits(errors)
    if digits > MOST_DIGITS:
        return np.full(len(errors), RESOLUTION**2)
    unit = 10.0 ** (np.floor(np.log10(errors)) - digits + 1)
    return (unit / errors) ** 2 / 12.0 + RESOLUTION**2
