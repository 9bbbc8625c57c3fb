"""Direct solution with real sparse matrices of any pattern: MKL PARDISO, or SuperLU."""

import ctypes
from collections.abc import Callable
from weakref import finalize

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from esfem.solver import symmetric_solver
from esfem.solver.krylov import NotFinite
from esfem.solver.reference_element import Array
from esfem.solver.symmetric_solver import FactorisationError, bind

ANALYSE_AND_FACTOR, SOLVE, RELEASE = 12, 33, -1
REAL_UNSYMMETRIC = 11


def factored(K: sp.csr_array | sp.csc_array) -> Callable[[Array], Array]:
    """Factor K (N, N): the function that takes b (N,) or (N, m) to K^-1 b.

    Raises
    ------
    FactorisationError
        If K is singular for the solver.
    NotFinite
        If K is not finite.
    """
    if not np.isfinite(K.data).all():
        raise NotFinite("a matrix is not finite")
    # At a size near 1, by a power of two: neither solver then sees a unit.
    size = 2.0 ** np.frexp(np.abs(K.data).max(initial=0.0))[1]
    library = symmetric_solver.mkl()
    unit = K / size
    solve = (
        _by_superlu(unit.tocsc()) if library is None else _by_pardiso(library, sp.csr_array(unit))
    )
    return lambda b: solve(b / size)


def _by_superlu(K: sp.csc_array) -> Callable[[Array], Array]:
    try:
        return splu(K).solve
    except RuntimeError as error:
        raise FactorisationError(f"SuperLU: {error}") from error


def _by_pardiso(library: ctypes.CDLL, K: sp.csr_array) -> Callable[[Array], Array]:
    K.sort_indices()
    indptr, indices = K.indptr.astype(np.int32), K.indices.astype(np.int32)
    parameters = np.zeros(64, dtype=np.int32)
    parameters[0] = 1  # the values below, not the defaults
    parameters[1] = 2  # fill-reducing order: nested dissection
    parameters[9] = 13  # perturb pivots below 1e-13 of the matrix norm
    parameters[10] = parameters[12] = 1  # scaling and matching, for indefinite blocks
    parameters[7] = 2  # steps of refinement
    parameters[34] = 1  # indices count from zero
    handle = np.zeros(64, dtype=np.int64)
    call = bind(library, handle, parameters, REAL_UNSYMMETRIC, indptr, indices)
    data, none = np.array(K.data, dtype=float), np.zeros(0)
    error = call(ANALYSE_AND_FACTOR, data, none, none, 1)
    if error:
        raise FactorisationError(f"PARDISO phase {ANALYSE_AND_FACTOR}: error {error}")

    def solve(b: Array) -> Array:
        right = np.asfortranarray(b.reshape(len(b), -1), dtype=float)
        x = np.empty_like(right)
        error = call(SOLVE, data, right, x, right.shape[1])
        if error:
            raise FactorisationError(f"PARDISO phase {SOLVE}: error {error}")
        return x.reshape(b.shape)

    finalize(solve, call, RELEASE, data, none, none, 1)
    return solve
