"""The linear system of one step, for four pairs (u, w): c M u - (A + F) w = a,  A u + M w = b.

Without F, (sqrt(c) M + i A)(sqrt(c) u + i w) = a + i sqrt(c) b: separate real and imaginary part to
see the two equations.  So one complex symmetric N x N factorisation serves all pairs; F goes to the
right-hand side, and GMRES on w alone finds the w that agrees with itself.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, gmres

from solver.mesh import SparsePattern
from solver.reference_element import Array
from solver.symmetric_solver import symmetric_solver

KRYLOV_LIMIT = 60


class NotFinite(ArithmeticError):
    """The matrices of a step are not finite: what they were assembled on is no surface."""


class KrylovFailure(ArithmeticError):
    """GMRES did not reach its tolerance within `KRYLOV_LIMIT` iterations."""


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
        y = self._solver.solve(a + 1j * self._root * b)
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
        shape, zero = w_start.shape, np.zeros_like(b)

        def defect(d: Array) -> Array:
            """d - (the w-part of the solution with F d on the right and zero data)."""
            d = d.reshape(shape)
            return (d - self.solve(F(d), zero)[1]).ravel()

        u, w = self.solve(a + F(w_start), b)
        residual = (w - w_start).ravel()
        # Below the rounding of the solve, which mixes sqrt(c) u with w, there is nothing to iterate
        # for.
        rounding = 100 * np.finfo(float).eps * self._root * np.linalg.norm(u)
        bound = max(tolerance * np.linalg.norm(w), rounding)
        if not np.isfinite(bound):
            raise KrylovFailure("GMRES: the right-hand side is not finite")
        steps: list[float] = []
        operator = LinearOperator((residual.size, residual.size), matvec=defect, dtype=np.float64)
        d, info = gmres(
            operator,
            residual,
            rtol=0.0,
            atol=bound,
            restart=KRYLOV_LIMIT,
            maxiter=1,
            callback=steps.append,
            callback_type="pr_norm",
        )
        if info:
            raise KrylovFailure(f"GMRES: residual above {bound:.1e} after {len(steps)} iterations")
        u, w = self.solve(a + F(w_start + d.reshape(shape)), b)
        return Solution(u, w, len(steps))
