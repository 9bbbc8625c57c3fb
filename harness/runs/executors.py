"""Where the cells of a sweep are computed: processes of this machine, or workers of a cluster.

Both share nothing with the sweep but the files: what a worker returns is a few words.
"""

import logging
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, as_completed
from contextlib import suppress
from typing import Any, Self, TypeVar

from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.process_executor import TerminatedWorkerError

from esfem.common.bad_input import BadInput

Item = TypeVar("Item")
Result = TypeVar("Result")
# A cell a core: more threads would fight for them, and may sum in another order.
ONE_THREAD = {
    f"{library}_NUM_THREADS": "1"
    for library in ("OMP", "MKL", "OPENBLAS", "BLIS", "VECLIB", "NUMEXPR", "NUMBA")
}
IDLE_SECONDS = 300  # a process that has nothing to do ends itself
CONNECT_SECONDS = 60.0  # a scheduler that restarts may take so long
TLS = "tls://"
RESTARTS = 10  # of the scheduler, after which a sweep gives up
log = logging.getLogger("esfem")


class WorkerLost(RuntimeError):
    """A worker process ended without a result, killed from outside or for lack of memory."""


class LocalProcesses:
    """So many processes of this machine, with one thread each; ``owner`` is the process with which
    they are to end."""

    def __init__(self, jobs: int) -> None:
        self.workers, self.owner = jobs, os.getpid()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        pass  # the processes are kept for the next sweep; idle ones end by themselves

    def run(
        self, function: Callable[[Item], Result], items: Sequence[Item]
    ) -> Iterator[tuple[Item, Result]]:
        """Each item with its result, as soon as it is there; WorkerLost if there will be none.

        Items start in the order given.
        """
        # One that has grown ends itself between two items, and another takes its place.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        workers = min(self.workers, len(items))
        pool = get_reusable_executor(workers, timeout=IDLE_SECONDS, env=ONE_THREAD)
        futures = {pool.submit(function, item): item for item in items}
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        except TerminatedWorkerError as error:
            raise WorkerLost("a worker process was killed") from error
        finally:
            if not all(future.done() for future in futures):
                pool.shutdown(wait=False, kill_workers=True)


class DaskWorkers:
    """The workers of a dask.distributed scheduler, or so many local ones if no address is given.

    A scheduler runs what it is sent. Local ones listen to this process alone, by certificates that
    only it has; one at tls://... to those who have the certificates of dask's configuration; any
    other to everybody who reaches its port.

    A worker that dies loses its cell to another one. When the scheduler dies, the sweep waits for
    it to come back at the same address and submits what is not finished.
    """

    owner = None

    def __init__(self, scheduler: str | None, jobs: int) -> None:
        self._scheduler, self._jobs = scheduler, jobs

    def __enter__(self) -> Self:
        self._connect()
        if self._scheduler is not None and not self._scheduler.startswith(TLS):
            log.warning(
                "--scheduler %s: whoever reaches that port can run programs as you; "
                "tls:// asks for a certificate (README, Long sweeps)",
                self._scheduler,
            )
        return self

    def __exit__(self, *exception: object) -> None:
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()

    @property
    def workers(self) -> int:
        """Threads of all workers that are there now, at least one."""
        return max(sum(self._client.nthreads().values()), 1)

    def run(
        self, function: Callable[[Item], Result], items: Sequence[Item]
    ) -> Iterator[tuple[Item, Result]]:
        """As that of `LocalProcesses`."""
        from distributed import KilledWorker
        from distributed import as_completed as completed
        from distributed.comm.core import CommClosedError

        left = dict(enumerate(items))
        for _ in range(RESTARTS):
            futures: dict[Any, int] = {
                self._client.submit(function, item, priority=-i, pure=False): i
                for i, item in left.items()
            }
            try:
                for future in completed(list(futures)):
                    result = future.result()
                    yield left.pop(futures[future]), result
                return
            except KilledWorker as error:
                raise WorkerLost(f"several workers were killed: {error}") from error
            except (CancelledError, CommClosedError):  # the latter if a result was on its way
                with suppress(Exception):  # it is broken in any case
                    self._client.close()
                self._connect()
        raise WorkerLost(f"the scheduler was lost {RESTARTS} times")

    def _connect(self) -> None:
        try:
            if self._scheduler is None:
                import cryptography  # noqa: F401  makes the certificates of local workers
            from distributed import Client, LocalCluster
            from distributed.security import Security
        except ImportError as error:
            raise BadInput(
                f"--executor dask: needs the package {error.name}: "
                "pip install 'esfem-willmore[cluster]'"
            ) from error
        self._cluster = None
        if self._scheduler is None:
            self._cluster = LocalCluster(
                n_workers=self._jobs,
                threads_per_worker=1,
                dashboard_address=None,
                security=Security.temporary(),
            )
            self._client = Client(self._cluster, timeout=CONNECT_SECONDS)
            return
        if self._scheduler.startswith(TLS):
            _check_certificates(self._scheduler)
        try:
            self._client = Client(self._scheduler, timeout=CONNECT_SECONDS)
        except (OSError, ValueError, RuntimeError) as error:
            reason = " ".join(str(error).split())
            raise BadInput(f"--scheduler {self._scheduler}: cannot be reached: {reason}") from error


def _check_certificates(scheduler: str) -> None:
    """Raise BadInput unless dask's configuration, files or variables, names those of a client."""
    from dask import config

    for name in ("ca-file", "client.cert", "client.key"):
        key = f"--scheduler {scheduler}: dask's configuration, distributed.comm.tls.{name}"
        path = config.get(f"distributed.comm.tls.{name}", None)
        if path is None and name != "client.key":  # which the file of the certificate may hold
            raise BadInput(f"{key}: must name a file, is not there (README, Long sweeps)")
        if path is not None and not os.path.isfile(path):
            raise BadInput(f"{key} = {path}: there is no such file")


Executor = LocalProcesses | DaskWorkers


def executor_named(name: str, scheduler: str | None, jobs: int) -> Executor:
    """The executor "local" or "dask".

    Raises
    ------
    BadInput
        If there is no such executor, or it takes no scheduler.
    """
    if name not in ("local", "dask"):
        raise BadInput(f"--executor {name}: must be local or dask")
    if name == "local" and scheduler is not None:
        raise BadInput(f"--scheduler {scheduler}: needs --executor dask")
    return LocalProcesses(jobs) if name == "local" else DaskWorkers(scheduler, jobs)
