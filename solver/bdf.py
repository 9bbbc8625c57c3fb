"""Backward difference formulas of order 1 to 5, linearly implicit: data that check themselves."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import factorial, prod
from typing import ClassVar

import numpy as np

from esfem.solver.reference_element import Array

ORDERS = (1, 2, 3, 4, 5)


@dataclass(frozen=True)
class BDF:
    """BDF of order q and the extrapolation that goes with it.

    u'(t_n) ~ (1/tau) sum_{j=0}^q delta_j u^{n-j},  u_ext(t_n) = sum_{j=0}^{q-1} gamma_j u^{n-1-j},
    delta(zeta) = sum_{l=1}^q (1 - zeta)^l / l and gamma(zeta) = (1 - (1 - zeta)^q) / zeta.

    Raises
    ------
    ValueError
        If the coefficients are not those of a method of order q = len(gamma): the formulas must be
        exact on polynomials of degree q (delta) and q - 1 (gamma).

    References
    ----------
    Akrivis, Lubich, Numer. Math. 131 (2015); the paper, section 7, uses q = 1, 2.
    """

    delta: tuple[Fraction, ...]
    gamma: tuple[Fraction, ...]

    def __post_init__(self) -> None:
        q = len(self.gamma)
        if len(self.delta) != q + 1:
            raise ValueError(
                f"delta: must have {q + 1} coefficients for order {q}, has {len(self.delta)}"
            )
        for m in range(q + 1):
            # On u(t) = t^m / m! with tau = 1, t_n = 0: u(t_{n-j}) = (-j)^m / m!, u'(0) = 1 if m ==
            # 1 else 0.
            derivative = sum(
                d * Fraction((-j) ** m, factorial(m)) for j, d in enumerate(self.delta)
            )
            if derivative != (m == 1):
                raise ValueError(f"delta = {self.delta}: not exact on t^{m}, so not of order {q}")
        for m in range(q):
            value = sum(g * Fraction((-1 - j) ** m) for j, g in enumerate(self.gamma))
            if value != (m == 0):
                raise ValueError(f"gamma = {self.gamma}: not exact on t^{m}, so not of order {q}")

    @property
    def order(self) -> int:
        """The order q."""
        return len(self.gamma)

    TABLE: ClassVar[dict[int, "BDF"]]

    @classmethod
    def of_order(cls, q: int) -> "BDF":
        """The method of order q in 1..5; ValueError for another q."""
        if q not in cls.TABLE:
            raise ValueError(f"bdf = {q!r}: must be one of {ORDERS}")
        return cls.TABLE[q]


def _fractions(text: str) -> tuple[Fraction, ...]:
    return tuple(Fraction(word) for word in text.split())


BDF.TABLE = {
    1: BDF(_fractions("1 -1"), _fractions("1")),
    2: BDF(_fractions("3/2 -2 1/2"), _fractions("2 -1")),
    3: BDF(_fractions("11/6 -3 3/2 -1/3"), _fractions("3 -3 1")),
    4: BDF(_fractions("25/12 -4 3 -4/3 1/4"), _fractions("4 -6 4 -1")),
    5: BDF(_fractions("137/60 -5 5 -10/3 5/4 -1/5"), _fractions("5 -10 10 -5 1")),
}


def extrapolation_weights(columns: int) -> list[float]:
    """Weights of the linearly implicit Euler method with 1, 2, ..., ``columns`` substeps.

    Its error has an expansion in powers of the step. With steps tau/m, these Lagrange weights at
    zero of the nodes 1/m, prod_{l != m} m / (m - l), leave a local error of tau^(columns + 1).

    References
    ----------
    Deuflhard, SIAM Rev. 27 (1985); Hairer, Wanner, Solving ODEs II, section IV.9.
    """
    substeps = range(1, columns + 1)
    return [float(prod(Fraction(m, m - l) for l in substeps if l != m)) for m in substeps]


def combine(coefficients: Sequence[float], vectors: Sequence[Array]) -> Array:
    """sum_j coefficients_j vectors_j."""
    return sum((c * v for c, v in zip(coefficients, vectors, strict=True)), np.zeros(()))


def predicted(past: Sequence[Array], unit: Array | float = 1.0) -> Array:
    """The next value by backward differences: sum_{i<m} nabla^i w, newest of ``past`` first.

    nabla^m w is by what the same formula missed the newest value: m is where that is least, in the
    Euclidean norm of ``unit`` (C,) times w (N, C).
    """
    guess, best, rows = past[0], np.inf, list(past)
    total = past[0]
    while len(rows) > 1:
        rows = [newer - older for newer, older in pairwise(rows)]
        missed = float(np.linalg.norm(unit * rows[0]))
        if missed < best:
            guess, best = total, missed
        total = total + rows[0]
    return guess
