"""Direct solution of complex symmetric systems on one fixed CSR pattern: MKL PARDISO, or SuperLU.

Both offer ``factor(data)`` with the complex entries of the whole pattern, and ``solve(b)`` for b of
shape (N, m).
"""

import ctypes
import importlib.metadata
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol
from weakref import finalize

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from esfem.solver.mesh import SparsePattern

Complex = NDArray[np.complex128]
AnyArray = NDArray[Any]


class FactorisationError(ArithmeticError):
    """The direct solver could not factor the matrix or solve with it."""


class SymmetricSolver(Protocol):
    """A direct solver that has seen the pattern and may be given new values again and again."""

    def factor(self, data: Complex) -> None:
        """Factor the symmetric matrix with these entries, in the order of the CSR pattern."""

    def solve(self, b: Complex) -> Complex:
        """Solution for the right-hand sides b (N, m)."""


@lru_cache
def mkl() -> ctypes.CDLL | None:
    """The runtime library of the installed ``mkl`` wheel, or None."""
    try:
        files = importlib.metadata.files("mkl") or []
    except importlib.metadata.PackageNotFoundError:
        return None
    for file in files:
        if "mkl_rt" in file.name and file.suffix != ".lib":
            try:
                library = ctypes.CDLL(str(Path(file.locate()).resolve()))
            except OSError:  # there, but not for this system: SuperLU then
                return None
            library.MKL_CBWR_Set(
                2
            )  # MKL_CBWR_AUTO: the same bits run after run, whatever the memory alignment
            return library
    return None


class Pardiso:
    """MKL PARDISO for complex symmetric matrices (matrix type 6); analyses the pattern once.

    A class because it owns memory of the library that must be given back.
    """

    ANALYSE, FACTOR, SOLVE, RELEASE = 11, 22, 33, -1
    COMPLEX_SYMMETRIC = 6

    def __init__(self, pattern: SparsePattern) -> None:
        library = mkl()
        if library is None:
            raise FactorisationError(
                "backend = 'pardiso': the package mkl is not installed; allowed here: 'superlu'"
            )
        self._pattern = pattern
        self._handle = np.zeros(64, dtype=np.int64)
        self._parameters = np.zeros(64, dtype=np.int32)
        self._parameters[0] = 1  # the values below, not the defaults
        self._parameters[1] = 2  # fill-reducing order: nested dissection
        self._parameters[9] = 8  # perturb pivots below 1e-8 of the matrix norm
        self._parameters[20] = 1  # Bunch-Kaufman pivots
        self._parameters[23] = 1  # two-level factorisation: the better one for two threads
        self._parameters[34] = 1  # indices count from zero
        self._call = bind(
            library,
            self._handle,
            self._parameters,
            self.COMPLEX_SYMMETRIC,
            pattern.upper_indptr,
            pattern.upper_indices,
        )
        self._data = np.ones(len(pattern.upper), dtype=np.complex128)
        self._run(self.ANALYSE)
        finalize(self, self._call, self.RELEASE, self._data, self._data[:0], self._data[:0], 1)

    def _run(self, phase: int, b: Complex | None = None, x: Complex | None = None) -> None:
        empty = np.zeros(0, dtype=np.complex128)
        columns = 1 if b is None else b.shape[1]
        error = self._call(
            phase, self._data, empty if b is None else b, empty if x is None else x, columns
        )
        if error:
            raise FactorisationError(f"PARDISO phase {phase}: error {error}")

    def factor(self, data: Complex) -> None:
        self._data = data[self._pattern.upper]
        self._run(self.FACTOR)

    def solve(self, b: Complex) -> Complex:
        b = np.asfortranarray(b)
        x = np.empty_like(b)
        self._run(self.SOLVE, b, x)
        return x


def bind(
    library: ctypes.CDLL,
    handle: AnyArray,
    parameters: AnyArray,
    kind: int,
    indptr: AnyArray,
    indices: AnyArray,
) -> Callable[[int, AnyArray, AnyArray, AnyArray, int], int]:
    """PARDISO for a matrix type with all but (phase, values, b, x, columns of b) given; returns its
    error code."""

    def integer(value: int) -> object:
        return ctypes.byref(ctypes.c_int32(value))

    def address(array: AnyArray) -> ctypes.c_void_p:
        return array.ctypes.data_as(ctypes.c_void_p)

    def call(phase: int, data: AnyArray, b: AnyArray, x: AnyArray, columns: int) -> int:
        error = ctypes.c_int32(0)
        library.pardiso(
            address(handle),
            integer(1),  # one factorisation kept
            integer(1),  # use that one
            integer(kind),
            integer(phase),
            integer(len(indptr) - 1),
            address(data),
            address(indptr),
            address(indices),
            address(parameters[:0]),  # no permutation given
            integer(columns),
            address(parameters),
            integer(0),  # silent
            address(b),
            address(x),
            ctypes.byref(error),
        )
        return error.value

    return call


class SuperLU:
    """SciPy's SuperLU behind the same two calls; analyses afresh at each factorisation."""

    def __init__(self, pattern: SparsePattern) -> None:
        self._pattern = pattern

    def factor(self, data: Complex) -> None:
        N = len(self._pattern.indptr) - 1
        # The matrix is symmetric, so its CSR arrays are its CSC arrays.
        matrix = sp.csc_matrix((data, self._pattern.indices, self._pattern.indptr), shape=(N, N))
        try:
            self._factors = splu(
                matrix,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise FactorisationError(f"SuperLU: {error}") from error

    def solve(self, b: Complex) -> Complex:
        right: Complex = np.ascontiguousarray(b)
        return self._factors.solve(right)


BACKENDS: dict[str, Callable[[SparsePattern], SymmetricSolver]] = {
    "pardiso": Pardiso,
    "superlu": SuperLU,
}


def symmetric_solver(pattern: SparsePattern, backend: str | None = None) -> SymmetricSolver:
    """The named backend, by default PARDISO where MKL is installed and SuperLU elsewhere.

    Raises
    ------
    ValueError
        If there is no backend of that name.
    """
    name = symmetric_solver_name() if backend is None else backend
    if name not in BACKENDS:
        raise ValueError(f"backend = {backend!r}: must be one of {', '.join(BACKENDS)}")
    return BACKENDS[name](pattern)


def symmetric_solver_name() -> str:
    """The backend that is used when none is asked for."""
    return "superlu" if mkl() is None else "pardiso"
