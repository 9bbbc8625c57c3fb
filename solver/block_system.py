"""The linear system of one step, for four pairs (u, w): c M u - (A + F) w = a,  A u + M w = b.

Without F, (sqrt(c) M + i A)(sqrt(c) u + i w) = a + i sqrt(c) b: separate real and imaginary part to
see the two equations.  So one complex symmetric N x N factorisation serves all pairs; F goes to the
right-hand side, and GMRES on w alone finds the w that agrees with itself.

Where the pair (H, V) alone is coupled, in both equations, GMRES goes on with that pair alone
(`BlockSystem.solve_pair`).

While the surface moves little, the factors of an older one serve as a preconditioner for both u and
w (`BlockSystem.renew`).

GMRES measures pairs in a norm without a unit of length, in which the columns (L H, nu) and (L V, z)
stand: L is a length of the surface, so that a flow and its enlargement take the same iterations.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from esfem.solver.krylov import KrylovFailure, NotFinite, gmres
from esfem.solver.mesh import SparsePattern
from esfem.solver.reference_element import Array
from esfem.solver.reuse import Reuse
from esfem.solver.symmetric_solver import Complex, symmetric_solver

KRYLOV_LIMIT = 60

Linear = Callable[[Array], Array]


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

    Parameters
    ----------
    pattern : of the matrices.
    length : L > 0, see the module's docstring; 1 for surfaces of about the size of the unit sphere.
    backend : see `esfem.solver.symmetric_solver`.
    """

    def __init__(
        self, pattern: SparsePattern, backend: str | None = None, length: float = 1.0
    ) -> None:
        self._solver = symmetric_solver(pattern, backend)
        self.unit = np.array([length, 1.0, 1.0, 1.0])
        self._reuse = Reuse()
        self._c = 0.0  # that of the factors
        self._newer: tuple[sp.csr_array, sp.csr_array] | None = None  # M, A if not those factored

    def factor(self, c: float, M: sp.csr_array, A: sp.csr_array) -> None:
        """Factor sqrt(c) M + i A for c = delta_0 / tau > 0."""
        self._c, self._root, self._newer = c, np.sqrt(c), None
        self._solver.factor(_combined(self._root, M, A))

    def forget(self) -> None:
        """Drop the factors and what was learnt of reusing them: as new, but for the analysis."""
        self._reuse, self._c, self._newer = Reuse(), 0.0, None

    def renew(self, c: float, M: sp.csr_array, A: sp.csr_array, older: bool = True) -> None:
        """Take new matrices: factor them, or keep the ``older`` factors where these still do."""
        if older and c == self._c and self._reuse.promising:
            self._newer = M, A
        else:
            self.factor(c, M, A)

    def solve(self, a: Array, b: Array) -> tuple[Array, Array]:
        """u, w (N, m) of c M u - A w = a, A u + M w = b for dual vectors a, b (N, m)."""
        y = self._solve(a, b)
        return y.real / self._root, y.imag

    def solve_pair(
        self, a: Array, b: Array, C: Linear, tilde: Array, guess: Array, tolerance: float
    ) -> Solution:
        """u, w (N, 4) of c M u - A w = a, A u + M w = b, but with (H, V) coupled by C:

            c M H - A V = a_H + C_1 (H - H~, V - V~),  A H + M V = b_H + C_2 (H - H~, V - V~).

        Parameters
        ----------
        a, b : (N, 4) dual vectors.
        C : takes a nodal pair (H, V) (N, 2) to the dual pair (N, 2) on the right.
        tilde, guess : the pair (H~, V~), and that where GMRES starts, (N, 2).
        tolerance : as for `solve_coupled`, relative to the whole w.

        Raises
        ------
        KrylovFailure
            As `solve_coupled` does.
        """
        answers: list[Complex] = []

        def answer(d: Complex) -> Complex:
            """sqrt(c) H + i V of the solution with C d on the right and zero data, (N, 1)."""
            dual = C(np.column_stack([d.real / self._root, d.imag]))
            return self._solve(dual[:, :1], dual[:, 1:])

        def defect(d: Complex) -> Complex:
            answers.append(answer(d))
            return d - answers[-1]

        # One column, so that its unit of length is a factor of the bound alone.

        y, known, start = self._solve(a, b), self._pair(tilde), self._pair(guess)
        pair = y[:, :1] + answer(start - known) if (start != known).any() else y[:, :1]
        bound = _bound(self.unit * y, tolerance) / self.unit[0]
        coefficients = gmres(defect, pair - start, bound, KRYLOV_LIMIT)
        for coefficient, found in zip(coefficients, answers, strict=True):
            pair = pair + coefficient * found
        y[:, :1] = pair
        return self._solution(y, len(answers))

    def solve_coupled(
        self,
        a: Array,
        b: Array,
        F: Linear,
        w_start: Array,
        tolerance: float,
        u_start: Array | None = None,
    ) -> Solution:
        """u, w (N, 4) of c M u - (A + F) w = a, A u + M w = b.

        Parameters
        ----------
        a, b : (N, 4) dual vectors.
        F : takes nodal w (N, 4) to the dual vector F w (N, 4).
        w_start, u_start : (N, 4) where GMRES starts; u_start serves older factors alone.
        tolerance : bound on the change of w by one more pass through the system, relative to w, in
            the norm of (L V, z).

        Raises
        ------
        KrylovFailure
            If the tolerance is not met within `KRYLOV_LIMIT` iterations.
        NotFinite
            If a value is not finite.
        """
        wasted = 0
        if self._newer is not None:
            limit = self._reuse.fresh + 2 * Reuse.MORE
            try:
                start = self._root * u_start + 1j * w_start
                y, iterations = self._with_older_factors(
                    *self._newer, a, b, F, start, tolerance, limit
                )
                self._reuse.reused(iterations)
                return self._solution(y, iterations)
            except KrylovFailure:
                wasted = limit
                self._reuse.reused(limit)
                self.factor(self._c, *self._newer)
        y, iterations = self._with_factors(a, b, F, w_start, tolerance)
        self._reuse.factored(iterations)
        return self._solution(y, wasted + iterations)

    def _with_factors(
        self, a: Array, b: Array, F: Linear, w_start: Array, tolerance: float
    ) -> tuple[Complex, int]:
        """sqrt(c) u + i w by GMRES on w alone, and its iterations."""
        y, unit = self._solve(a + F(w_start), b), self.unit
        answers: list[Complex] = []

        def defect(d: Array) -> Array:
            """d - (the w-part of the solution with F d on the right and zero data), in units."""
            answers.append(self._solve(F(d / unit), 0.0))
            return d - unit * answers[-1].imag

        bound = _bound(unit * y, tolerance)
        coefficients = gmres(defect, unit * (y.imag - w_start), bound, KRYLOV_LIMIT)
        for coefficient, answer in zip(coefficients, answers, strict=True):
            y += coefficient * answer
        return y, len(answers)

    def _with_older_factors(
        self,
        M: sp.csr_array,
        A: sp.csr_array,
        a: Array,
        b: Array,
        F: Linear,
        y: Complex,
        tolerance: float,
        limit: int,
    ) -> tuple[Complex, int]:
        """sqrt(c) u + i w by GMRES on both from y, preconditioned, and its iterations."""
        data = _combined(self._root, M, A)
        K = sp.csr_array((data, M.indices, M.indptr), shape=M.shape)
        directions: list[Complex] = []
        unit = self.unit

        def image(d: Complex) -> Complex:
            """The older inverse of (sqrt(c) M + i A) d - F Im d, in units."""
            directions.append(d / unit)
            return unit * self._solver.solve(_columns(K, directions[-1]) - F(directions[-1].imag))

        defect = self._solver.solve(self._right(a + F(y.imag), b) - _columns(K, y))
        bound = _bound(unit * (y + defect), tolerance)
        coefficients = gmres(image, unit * defect, bound, limit)
        for coefficient, direction in zip(coefficients, directions, strict=True):
            y = y + coefficient * direction
        return y, len(directions)

    def _solve(self, a: Array, b: Array | float) -> Complex:
        """sqrt(c) u + i w of c M u - A w = a, A u + M w = b for dual vectors a, b (N, m)."""
        return self._solver.solve(self._right(a, b))

    def _right(self, a: Array, b: Array | float) -> Complex:
        """a + i sqrt(c) b."""
        right = np.empty(a.shape, dtype=np.complex128, order="F")
        right.real, right.imag = a, self._root * b
        return right

    def _pair(self, pair: Array) -> Complex:
        """sqrt(c) H + i V, (N, 1), of (H, V) (N, 2)."""
        return self._root * pair[:, :1] + 1j * pair[:, 1:]

    def _solution(self, y: Complex, iterations: int) -> Solution:
        """From y = sqrt(c) u + i w."""
        return Solution(y.real / self._root, y.imag, iterations)


def _combined(root: float, M: sp.csr_array, A: sp.csr_array) -> Complex:
    """The entries of sqrt(c) M + i A."""
    data = root * M.data + 1j * A.data
    if not np.isfinite(data).all():
        raise NotFinite("M or A on the extrapolated surface is not finite")
    return data


def _bound(y: Complex, tolerance: float) -> float:
    """Where GMRES may stop, with y = sqrt(c) u + i w in units."""
    # Below the rounding of the solve, which mixes sqrt(c) u with w, there is nothing to iterate
    # for.  It grows like 1/h: 56, 95, 123, 783 eps of sqrt(c) u for N = 954, 3834, 15354, 61434.
    rounding = 4 * np.sqrt(len(y)) * np.finfo(float).eps * np.linalg.norm(y.real)
    bound = max(tolerance * np.linalg.norm(y.imag), rounding)
    if not np.isfinite(bound):
        raise NotFinite("a right-hand side on the extrapolated surface is not finite")
    return float(bound)


def _columns(K: sp.csr_array, d: Complex) -> Complex:
    """K d column by column, for d (N, m) whose columns lie together in memory."""
    return np.stack([K @ column for column in d.T]).T
