"""How a step takes the reaction terms, those linear in w and, in Q, in H: three ways.

With u~, w~ extrapolated to t_n, and everything assembled at u~ on Gamma_h[x~], all three solve

    c M u - A w = a + F w*,   A u + M w = b + L (H* - H~),

where F w = (F1 V; F2 z), L H = int q H phi_j in the V-equation alone (Q = q H + r, so that b
holds Q of u~), and

    implicit       w* = w^n,           H* = H~
    extrapolated   w* = w~,            H* = H~     as every other nonlinear term of the method
    linearised     w* = (V^n; z~),     H* = H^n.

In each the error in time is of order q. They differ in what is stable: F1 V acts against the part
q H of Q in the V-equation. The second way takes both from the extrapolation and the third both from
the new level, the first one each from another: near the Clifford torus it amplifies at moderate
steps what the others do not. For ablations, "implicit-F1" and "implicit-F2" take w^n in one of the
two terms alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from esfem.solver.bdf import predicted
from esfem.solver.block_system import BlockSystem, Solution
from esfem.solver.reference_element import Array
from esfem.solver.system import System


class Level(Protocol):
    """A State, of which u, w (N, 4) are looked at."""

    @property
    def u(self) -> Array: ...

    @property
    def w(self) -> Array: ...


@dataclass(frozen=True)
class Known:
    """What is known before the solve, and how exact its answer shall be.

    Attributes
    ----------
    u, w : (N, 4), extrapolated with the order of the method.
    history : the last States, newest first, as many as there are.
    tolerance : of the Krylov iteration, relative to w.
    slack : it may stop earlier, at this fraction of an estimate of the error of w.
    unit : (4,) by which the columns are multiplied before they are compared.
    """

    u: Array
    w: Array
    history: Sequence[Level]
    tolerance: float
    slack: float
    unit: Array

    def guesses(self) -> tuple[Array, Array, float]:
        """u, w (N, 4) where GMRES starts, made of more States, and where it may stop."""
        unit = self.unit
        u, w = (predicted([getattr(s, name) for s in self.history], unit) for name in ("u", "w"))
        if self.slack == 0.0:
            return u, w, self.tolerance
        # The better guess tells the error of w~ from it.
        size = max(np.linalg.norm(unit * w), np.finfo(float).tiny)
        error = np.linalg.norm(unit * (w - self.w)) / size
        return u, w, max(self.tolerance, self.slack * float(error))


@dataclass(frozen=True)
class Reaction:
    """``solve`` takes the block system, the forms, a and b (N, 4), and what is known.

    ``older_factors`` tells that it can do with the factors of an older surface.
    """

    solve: Callable[[BlockSystem, System, Array, Array, Known], Solution]
    older_factors: bool


def implicit(block: BlockSystem, on: System, a: Array, b: Array, known: Known) -> Solution:
    """w* = w^n: GMRES on w."""
    u_start, w_start, tolerance = known.guesses()
    return block.solve_coupled(a, b, on.F, w_start, tolerance, u_start)


def implicit_in(*columns: int) -> Callable[..., Solution]:
    """w^n in these columns of w alone, w~ in the others: F1 and F2 apart, for ablations."""

    def solve(block: BlockSystem, on: System, a: Array, b: Array, known: Known) -> Solution:
        new = np.isin(np.arange(4), columns)
        u_start, w_start, tolerance = known.guesses()
        right = a + on.F(np.where(new, 0.0, known.w))

        def F(w: Array) -> Array:
            return on.F(np.where(new, w, 0.0))

        return block.solve_coupled(right, b, F, w_start, tolerance, u_start)

    return solve


def extrapolated(block: BlockSystem, on: System, a: Array, b: Array, known: Known) -> Solution:
    """w* = w~: one solve, no iteration.  Paper: section 7, linearly implicit BDF."""
    return Solution(*block.solve(a + on.F(known.w), b), iterations=0)


def linearised(block: BlockSystem, on: System, a: Array, b: Array, known: Known) -> Solution:
    """V* = V^n, H* = H^n, z* = z~: GMRES on the pair (H, V), from the extrapolated solution."""
    u_start, w_start, tolerance = known.guesses()
    pair, start = (
        np.column_stack([u[:, 0], w[:, 0]]) for u, w in ((known.u, known.w), (u_start, w_start))
    )
    return block.solve_pair(a + on.F(known.w), b, on.linear, pair, start, tolerance)


REACTIONS = {
    "implicit": Reaction(implicit, older_factors=True),
    "extrapolated": Reaction(extrapolated, older_factors=False),
    "linearised": Reaction(linearised, older_factors=False),
    "implicit-F1": Reaction(implicit_in(0), older_factors=True),
    "implicit-F2": Reaction(implicit_in(1, 2, 3), older_factors=True),
}
