"""The joint fit E(h, tau) = A h^p + B tau^q over a whole grid of runs, on log residuals."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import stdtrit

from esfem.judging.fits import Array

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

FEWEST_RUNS = 6
P, Q = np.linspace(-1.0, 8.0, 25), np.linspace(0.5, 5.0, 7)  # where the fits start
RATIOS = np.linspace(-6.0, 6.0, 25)  # of the terms at the finest h and tau, in logarithms
BETTER = 4.0  # of n log RSS, by which one sign of B is preferred
CANCELS = 0.1  # share of the smaller term from which cancellation counts


@dataclass(frozen=True)
class JointFit:
    """A h^p + B tau^q with a 95 % interval of p; ``q_given`` if q was not fitted.

    ``cancels`` if a negative B fits better by far, or as well where the terms are comparable.
    """

    A: float
    p: float
    p_interval: tuple[float, float]
    B: float
    q: float
    q_given: bool
    scatter: float
    cancels: bool

    def other_term(self, value: float) -> float:
        """B tau^q at tau = ``value``."""
        return float(np.exp(np.clip(np.log(self.B) + self.q * np.log(value), -700.0, 700.0)))


def joint_fit(h: Array, tau: Array, e: Array, q: float | None) -> JointFit | None:
    """The fit over runs (h, tau) with errors e, all (n,); None if they are too few.

    With two time steps only, B and q cannot both be found: then q is taken as given, or as 1, which
    leaves the most of the error to tau.
    """
    steps = len(np.unique(tau))
    if len(e) < FEWEST_RUNS or len(np.unique(h)) < 3 or steps < 2:
        return None
    fixed = (1.0 if q is None else q) if steps == 2 else None
    plus = _best(h, tau, e, fixed, 1.0)
    minus = _best(h, tau, e, fixed, -1.0)
    n = len(e)
    gain = n * np.log((2 * plus.cost + n * 1e-12) / (2 * minus.cost + n * 1e-12))
    share = np.exp(_ratio(minus.x, h, tau, fixed)).max()
    cancels = bool(share > CANCELS and gain > BETTER)
    return _described(plus, n, fixed, cancels)


def _best(h: Array, tau: Array, e: Array, fixed: float | None, sign: float) -> "OptimizeResult":
    """The better of the fits from two starts."""
    from scipy.optimize import least_squares  # slow to load; few tables have two parameters

    free = 4 if fixed is None else 3
    solutions = [
        least_squares(
            _residuals,
            start[:free],
            jac=_jacobian,
            method="lm",
            args=(h, tau, np.log(e), fixed, sign),
            max_nfev=80,
        )
        for start in _starts(h, tau, e, fixed, sign)
    ]
    return min(solutions, key=lambda solution: solution.cost)


def _starts(h: Array, tau: Array, e: Array, fixed: float | None, sign: float) -> Array:
    """The best (log A, p, log B, q) on a grid, and the best of those with other exponents.

    The grid has p, q and the ratio of the terms at the finest h and tau; A is linear in log E.
    """
    axes = np.meshgrid(P, Q if fixed is None else [fixed], RATIOS, indexing="ij")
    p, q, ratio = (axis.ravel() for axis in axes)
    x, t = np.log(h), np.log(tau)
    log_b = ratio + p * x.min() - q * t.min()
    r = np.exp(log_b[:, None] + q[:, None] * t - p[:, None] * x)
    left = np.log(e) - p[:, None] * x - np.log(np.abs(1.0 + sign * r) + 1e-9)
    log_a, ranked = left.mean(axis=1), np.argsort(left.var(axis=1))
    best = ranked[0]
    far = np.abs(p - p[best]) + np.abs(q - q[best]) > 1.0
    other = ranked[far[ranked]][0]
    return np.stack([log_a, p, log_a + log_b, q], axis=1)[[best, other]]


def _ratio(x: Array, h: Array, tau: Array, fixed: float | None) -> Array:
    """log of B tau^q / (A h^p)."""
    q = x[3] if fixed is None else fixed
    return np.clip(x[2] + q * np.log(tau) - x[0] - x[1] * np.log(h), -40.0, 40.0)


def _residuals(x: Array, h: Array, tau: Array, y: Array, fixed: float | None, sign: float) -> Array:
    """log |A h^p + sign B tau^q| - log E."""
    ratio = np.exp(_ratio(x, h, tau, fixed))
    return x[0] + x[1] * np.log(h) + np.log(np.abs(1.0 + sign * ratio) + 1e-9) - y


def _jacobian(x: Array, h: Array, tau: Array, y: Array, fixed: float | None, sign: float) -> Array:
    ratio = np.exp(_ratio(x, h, tau, fixed))
    other = sign * ratio / (np.abs(1.0 + sign * ratio) + 1e-9) * np.sign(1.0 + sign * ratio)
    columns = [1 - other, (1 - other) * np.log(h), other]
    if fixed is None:
        columns.append(other * np.log(tau))
    return np.stack(columns, axis=1)


def _described(solution: "OptimizeResult", n: int, fixed: float | None, cancels: bool) -> JointFit:
    x, free = solution.x, max(n - len(solution.x), 1)
    scatter = float(np.sqrt(2.0 * solution.cost / free))
    J = solution.jac
    normal = J.T @ J
    normal[np.diag_indices_from(normal)] *= 1.0 + 1e-10  # a term of no weight has a wide interval
    normal[np.diag_indices_from(normal)] += 1e-12
    errors = scatter * np.sqrt(np.maximum(np.diag(np.linalg.inv(normal)), 0.0))
    half = float(stdtrit(free, 0.975)) * errors[1]
    q = float(x[3]) if fixed is None else fixed
    return JointFit(
        A=float(np.exp(np.clip(x[0], -300, 300))),
        p=float(x[1]),
        p_interval=(float(x[1] - half), float(x[1] + half)),
        B=float(np.exp(np.clip(x[2], -300, 300))),
        q=q,
        q_given=fixed is not None,
        scatter=scatter,
        cancels=cancels,
    )
