"""The linear system of one step, for four pairs (u, w): c M u - (A + F) w = a,  A u + M w = b.

Without F, (sqrt(c) M + i A)(sqrt(c) u + i w) = a + i sqrt(c) b: separate real and imaginary part to
see the two equations.  So one complex symmetric N x N factorisation serves all pairs; F goes to the
right-hand side, and GMRES on w alone finds the w that agrees with itself.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from solver.krylov import KrylovFailure, gmres
from solver.mesh import SparsePattern
from solver.reference_element import Array
from solver.symmetric_solver import Complex, symmetric_solver

KRYLOV_LIMIT = 60


class NotFinite(ArithmeticError):
    """The matrices of a step are not finite: what they were assembled on is no surface."""


@dataclass(frozen=True)
class Solution:
    """u, w (N, 4) and the number of GMRES iterations that it took."""

    u: Array
    w: Array
    iterations: int


class BlockSystem:
    """The block system on a fixed pattern.

    A class because it keeps the symbolic analysis of the pattern and the latest factors from call
    to call.
    """

    def __init__(self, pattern: SparsePattern, backend: str | None = None) -> None:
        self._solver = symmetric_solver(pattern, backend)

    def factor(self, c: float, M: sp.csr_array, A: sp.csr_array) -> None:
        """Factor sqrt(c) M + i A for c = delta_0 / tau > 0."""
        self._root = np.sqrt(c)
        data = self._root * M.data + 1j * A.data
        if not np.isfinite(data).all():
            raise NotFinite("M or A on the extrapolated surface is not finite")
        self._solver.factor(data)

    def solve(self, a: Array, b: Array) -> tuple[Array, Array]:
        """u, w (N, m) of c M u - A w = a, A u + M w = b for dual vectors a, b (N, m)."""
        y = self._solve(a, b)
        return y.real / self._root, y.imag

    def solve_coupled(
        self, a: Array, b: Array, F: Callable[[Array], Array], w_start: Array, tolerance: float
    ) -> Solution:
        """u, w (N, 4) of c M u - (A + F) w = a, A u + M w = b.

        Parameters
        ----------
        a, b : (N, 4) dual vectors.
        F : takes nodal w (N, 4) to the dual vector F w (N, 4).
        w_start : (N, 4) where GMRES starts.
        tolerance : bound on the change of w by one more pass through the system, relative to w.

        Raises
        ------
        KrylovFailure
            If the tolerance is not met within `KRYLOV_LIMIT` iterations, or a value is not finite.
        """
        y = self._solve(a + F(w_start), b)
        # Below the rounding of the solve, which mixes sqrt(c) u with w, there is nothing to iterate
        # for.
        rounding = 100 * np.finfo(float).eps * np.linalg.norm(y.real)
        bound = max(tolerance * np.linalg.norm(y.imag), rounding)
        if not np.isfinite(bound):
            raise KrylovFailure("GMRES: the right-hand side is not finite")
        answers: list[Complex] = []

        def defect(d: Array) -> Array:
            """d - (the w-part of the solution with F d on the right and zero data)."""
            answers.append(self._solve(F(d), 0.0))
            return d - answers[-1].imag

        coefficients = gmres(defect, y.imag - w_start, bound, KRYLOV_LIMIT)
        for coefficient, answer in zip(coefficients, answers, strict=True):
            y += coefficient * answer
        return Solution(y.real / self._root, y.imag, len(answers))

    def _solve(self, a: Array, b: Array | float) -> Complex:
        """sqrt(c) u + i w of c M u - A w = a, A u + M w = b for dual vectors a, b (N, m)."""
        right = np.empty(a.shape, dtype=np.complex128, order="F")
        right.real, right.imag = a, b if np.isscalar(b) else self._root * b
        return self._solver.solve(right)
