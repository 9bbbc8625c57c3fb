"""How many threads a process uses, and who uses them.

MKL and the kernels of `solver.pointwise` use all of them: those OMP_NUM_THREADS allows, as in the
processes of a sweep, or all cores.  NumPy's own BLAS, whose products are small here, keeps to one:
its threads and those of MKL wait for each other, and a step took more than twice as long.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from functools import lru_cache
from typing import Any, TypeVar

from threadpoolctl import ThreadpoolController

T = TypeVar("T")


def thread_count() -> int:
    """Threads that this process may use."""
    wanted = os.environ.get("OMP_NUM_THREADS", "")
    if wanted.isdigit() and int(wanted) > 0:
        return int(wanted)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def one_blas_thread() -> AbstractContextManager[object]:
    """Within the block NumPy and SciPy multiply matrices with one thread."""
    return _openblas().limit(limits=1)


def spread(function: Callable[..., T], *items: Sequence[Any]) -> list[T]:
    """``function`` of each item in turn, or of several at a time where there are threads."""
    if thread_count() == 1 or len(items[0]) == 1:
        return [function(*item) for item in zip(*items, strict=True)]
    return list(_pool().map(function, *items))


@lru_cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(thread_count())


@lru_cache
def _openblas() -> ThreadpoolController:
    return ThreadpoolController().select(internal_api="openblas")
