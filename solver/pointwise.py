"""Formulas at one quadrature point, and the loops that compute them at all points.

A *formula* is a function of numbers; its vectors are tuples of three.  A *kernel* loops over points
p, hands their numbers to formulas and stores the results.  Numba compiles kernels and what they
call; without a compiler the same lines compute with whole arrays in place of numbers.

Fields at quadrature points are Fortran arrays: elements run fastest, so that each component, here
``a[i, p]``, is one stretch of memory.
"""

import hashlib
import logging
import os
import stat
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache, wraps
from pathlib import Path

import numpy as np
from numba import config, njit
from numba.extending import register_jitable

from esfem.solver.reference_element import Array
from esfem.solver.threads import thread_count

formula = register_jitable

POINTS_A_THREAD = 20_000  # below, a second thread costs more than it brings

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]  # by rows

_interpreted = False
log = logging.getLogger("esfem")  # on standard error; never an exception, as a warning may be


@contextmanager
def interpreted() -> Iterator[None]:
    """Within the block Python runs the formulas, as they are now, and not their compiled form."""
    global _interpreted
    before, _interpreted = _interpreted, True
    try:
        yield
    finally:
        _interpreted = before


def kernel(loop: Callable[..., None]) -> Callable[..., None]:
    """Decorator: ``loop(start, stop, *fields)`` becomes ``run(*fields)`` over all points.

    Fields have shape (..., P); what the loop makes it stores in those it is given for that.
    """
    compiled = _compiled(loop)

    @wraps(loop)
    def run(*fields: Array) -> None:
        if _interpreted:
            with np.errstate(all="ignore"):  # as in compiled code
                loop(0, 1, *(field[..., None, :] for field in fields))
            return
        P = fields[0].shape[-1]
        parts = max(1, min(thread_count(), P // POINTS_A_THREAD))
        bounds = [P * i // parts for i in range(parts + 1)]
        if parts == 1:
            compiled(0, P, *fields)
        else:
            list(_pool().map(lambda i: compiled(bounds[i], bounds[i + 1], *fields), range(parts)))

    return run


def flat(field: Array) -> Array:
    """A field (E, Q, ...) as (..., Q E): components in reverse, points last; a view if it can."""
    return np.ascontiguousarray(field.T).reshape(*field.T.shape[:-2], -1)


def empty_field(*shape: int) -> Array:
    """An uninitialised field (E, Q, ...) of which `flat` is a view."""
    return np.empty(shape, order="F")


@formula
def at(a: Array, p: int) -> Vector:
    """The vector a (3, P) at point p."""
    return a[0, p], a[1, p], a[2, p]


@formula
def put(a: Array, p: int, v: Vector) -> None:
    """Store a vector in a (3, P) at point p."""
    a[0, p], a[1, p], a[2, p] = v


@formula
def matrix_at(A: Array, p: int) -> Matrix:
    """The matrix A (3, 3, P), columns first, at point p."""
    return at(A[:, 0], p), at(A[:, 1], p), at(A[:, 2], p)


@formula
def put_matrix(A: Array, p: int, rows: Matrix) -> None:
    """Store a matrix in A (3, 3, P), columns first, at point p."""
    put(A[:, 0], p, rows[0])
    put(A[:, 1], p, rows[1])
    put(A[:, 2], p, rows[2])


@formula
def dot(a: Vector, b: Vector) -> float:
    """a . b"""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@formula
def cross(a: Vector, b: Vector) -> Vector:
    """a x b"""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@formula
def times(s: float, a: Vector) -> Vector:
    """s a"""
    return s * a[0], s * a[1], s * a[2]


@formula
def plus(a: Vector, b: Vector) -> Vector:
    """a + b"""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@formula
def matrix_times(s: float, A: Matrix) -> Matrix:
    """s A"""
    return times(s, A[0]), times(s, A[1]), times(s, A[2])


@formula
def matrix_plus(A: Matrix, B: Matrix) -> Matrix:
    """A + B"""
    return plus(A[0], B[0]), plus(A[1], B[1]), plus(A[2], B[2])


@formula
def transpose(A: Matrix) -> Matrix:
    """A^T"""
    a, b, c = A
    return (a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2])


@formula
def square(A: Matrix) -> float:
    """|A|^2 (Frobenius)"""
    return dot(A[0], A[0]) + dot(A[1], A[1]) + dot(A[2], A[2])


@formula
def apply(S: Matrix, a: Vector) -> Vector:
    """S a"""
    return dot(S[0], a), dot(S[1], a), dot(S[2], a)


def _compiled(loop: Callable[..., None]) -> Callable[..., None]:
    folder = _cache_folder()
    if folder is None:
        return njit(nogil=True, error_model="numpy")(loop)
    # Numba makes the variables of this module from the environment, unseen by a type checker.
    before, config.CACHE_DIR = config.CACHE_DIR, str(folder)  # type: ignore[attr-defined]
    try:
        return njit(cache=True, nogil=True, error_model="numpy")(loop)
    finally:
        config.CACHE_DIR = before  # type: ignore[attr-defined]


@lru_cache
def _cache_folder() -> Path | None:
    """Where compiled kernels are kept: below NUMBA_CACHE_DIR or in __pycache__; None for nowhere.

    Numba looks at the file of a kernel alone to tell whether it is stale; so a folder is named by a
    hash of all files here. Its index is a pickle: a folder in which somebody else may have written
    is not used, and each process compiles for itself.
    """
    here = Path(__file__).parent
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(here.glob("*.py"))))
    parent = Path(os.environ.get("NUMBA_CACHE_DIR") or here / "__pycache__").resolve()
    folder = parent / f"kernels-{digest.hexdigest()[:16]}"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            return None
        objection = _objection(folder)
    except OSError:
        return None
    if objection:
        log.warning("%s; it is not used, and each process compiles for itself", objection)
    return None if objection else folder


def _objection(folder: Path) -> str | None:
    """Why what lies in the folder is not to be run; None if nobody but us can have put it there.

    The folder must be closed to all others (as it was made), and it and all in it our own. Then the
    modes of its files, which Numba leaves to the umask, do not matter. Its parent may be open, as a
    checkout under umask 002 is: what others put there in place of our folder is theirs.
    """
    if os.name == "nt":  # has no such modes; profiles of users are closed to each other
        return None
    us, mode = os.geteuid(), os.lstat(folder).st_mode
    if not stat.S_ISDIR(mode):
        return f"{folder}: is a link, must be a folder"
    if mode & 0o077:
        return f"{folder}: has mode {mode & 0o777:04o}, must be 0700"
    for path in (folder, *folder.rglob("*")):
        owner = os.lstat(path).st_uid
        if owner != us:
            return f"{path}: belongs to user {owner}, must be that of user {us}"
    return None


@lru_cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(thread_count())
