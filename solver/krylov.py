"""GMRES for a handful of iterations, which hands out what it needs of the operator's work."""

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from esfem.solver.reference_element import Array

Vector = TypeVar("Vector", Array, NDArray[np.complex128])


class NotFinite(ArithmeticError):
    """A matrix or a right-hand side is not finite: what it was assembled on is no surface."""


class KrylovFailure(ArithmeticError):
    """GMRES did not reach its tolerance within its limit of iterations."""


def gmres(
    apply: Callable[[Vector], Vector], r: Vector, bound: float, limit: int
) -> NDArray[np.floating[Any]]:
    """Coefficients y with |r - sum_j y_j apply(v_j)| <= bound, for the v_j that were applied.

    A caller that remembers what its ``apply`` found on the way has the solution without another
    call: everything is linear in y.

    Parameters
    ----------
    apply : the operator, on vectors like r; called len(y) times, first with r / |r|.
    r : the residual at the start, any shape; complex numbers count as pairs of real ones.
    bound : on the Euclidean norm of the residual.
    limit : of the number of calls.

    Raises
    ------
    KrylovFailure
        If the bound is not met within the limit.
    NotFinite
        If a value is not finite.

    References
    ----------
    Saad, Iterative Methods for Sparse Linear Systems, algorithm 6.9.
    """
    residual = float(np.linalg.norm(r))
    if residual <= bound:
        return np.zeros(0)
    basis, H = [r / residual], np.zeros((limit + 1, limit))
    target = np.zeros(limit + 1)
    target[0] = residual
    for j in range(limit):
        q = apply(basis[j])
        for i, v in enumerate(basis):
            H[i, j] = np.vdot(v, q).real
            q = q - H[i, j] * v
        H[j + 1, j] = np.linalg.norm(q)
        if not np.isfinite(H[: j + 2, j]).all():
            raise NotFinite("GMRES: a value is not finite")
        y = np.linalg.lstsq(H[: j + 2, : j + 1], target[: j + 2])[0]
        residual = float(np.linalg.norm(target[: j + 2] - H[: j + 2, : j + 1] @ y))
        if residual <= bound:
            return y
        basis.append(q / H[j + 1, j])
    raise KrylovFailure(f"GMRES: residual above {bound:.1e} after {limit} iterations")
