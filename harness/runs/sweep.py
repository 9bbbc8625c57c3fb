"""The sweep: all cells of all studies over the cores, longest first, stored as soon as done.

Processes share nothing but the files of records, of leases and of checkpoints, so a sweep may be
killed, and several may work on the same studies at once.
"""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from time import sleep

from rich.console import Console

from esfem.common.bad_input import BadInput
from esfem.common.defaults import EVERY_SECONDS
from esfem.common.provenance import numerics_digest
from esfem.measuring.shape import profile_flow
from esfem.reference_solutions import SurfaceFlow
from esfem.runs.display import Monitor
from esfem.runs.executors import Executor, WorkerLost, executor_named
from esfem.runs.store import AnyRecord, Cell, record_path
from esfem.runs.work import BUSY, Orders, Outcome, compute, held, lease_of

POLL_SECONDS = 0.5  # between looks at what other sweeps compute


@dataclass(frozen=True, kw_only=True)
class How:
    """How studies are run.

    Parameters
    ----------
    jobs : number of processes, by default all cores.
    force : compute again what is stored.
    executor : "local", processes of this machine, or "dask", workers of a cluster.
    scheduler : address of the dask scheduler; without one, ``jobs`` local workers are started.
    checkpoint : seconds from checkpoint to checkpoint of a run, None for none; shorter runs write
        none.

    Raises
    ------
    BadInput
        If a number is not allowed.
    """

    jobs: int | None = None
    force: bool = False
    executor: str = "local"
    scheduler: str | None = None
    checkpoint: float | None = EVERY_SECONDS

    def __post_init__(self) -> None:
        if self.jobs is not None and self.jobs < 1:
            raise BadInput(f"--jobs {self.jobs}: must be at least 1")
        if self.checkpoint is not None and not self.checkpoint >= 0:
            raise BadInput(f"--checkpoint {self.checkpoint}: must not be negative")

    @property
    def processes(self) -> int:
        """So many are started."""
        return self.jobs or os.cpu_count() or 1

    def workers(self) -> Executor:
        """Where cells are computed; BadInput if there is no such place."""
        return executor_named(self.executor, self.scheduler, self.processes)


def sweep(
    cells: Sequence[Cell], workers: Executor, how: How, console: Console
) -> dict[Cell, AnyRecord]:
    """The record of every cell; those that have no valid one, with ``how.force`` all, are computed
    and stored first, those that cost most before others.

    What another sweep computes meanwhile is waited for, and computed here if that one was killed.
    What is stored survives any interruption.

    Raises
    ------
    BadInput
        If a reference cannot be computed.
    WorkerLost
        Naming the cells that are not finished.
    """
    check_references(cells, how.force)
    orders = Orders(how.force, how.checkpoint, workers.owner, numerics_digest())
    records: dict[Cell, AnyRecord] = {}
    with workers, Monitor(cells, workers.workers, console) as monitor:
        waiting = []
        for cell in cells:
            clear(cell)
            if how.force or not found(cell, records, monitor):
                waiting.append(cell)
        waiting.sort(key=lambda cell: cell.weight, reverse=True)
        while waiting:
            busy = []
            for cell, outcome in computed(waiting, workers, orders):
                if outcome.status == BUSY:
                    busy.append(cell)
                else:
                    found(cell, records, monitor, outcome.seconds)
            waiting = free_again(busy, records, monitor)
    return records


def check_references(cells: Sequence[Cell], force: bool) -> None:
    """Raise BadInput unless the axisymmetric solver gets to all times of comparison of the runs
    that are to be computed."""
    for cell in cells:
        case, solution = cell.case, cell.case.initial
        if not isinstance(solution, SurfaceFlow) or solution.reference != "axisymmetric":
            continue
        if force or not record_path(cell.folder, cell.key).exists():
            try:
                profile_flow(solution, case.law, (0.0, *case.compare_at))
            except BadInput as error:
                raise BadInput(f"study '{cell.study}': {error}") from error


def clear(cell: Cell) -> None:
    """Remove what a killed process has left of its lease and of its progress."""
    if cell.lease_path.exists() or cell.progress_path.exists():
        with held(lease_of(cell.lease_path)) as ours:
            if ours:
                cell.progress_path.unlink(missing_ok=True)


def found(
    cell: Cell, records: dict[Cell, AnyRecord], monitor: Monitor, seconds: float | None = None
) -> bool:
    """Read the record of a cell that took so many ``seconds`` here, and tell the monitor of it;
    False if there is none."""
    record = cell.stored(monitor.say)
    if record is not None:
        records[cell] = record
        monitor.done(cell, record.status, seconds)
    return record is not None


def computed(
    cells: Sequence[Cell], executor: Executor, orders: Orders
) -> Iterator[tuple[Cell, Outcome]]:
    """The cells with their outcomes; WorkerLost names those that have none."""
    missing = dict.fromkeys(cells)
    try:
        for cell, outcome in executor.run(partial(compute, orders=orders), cells):
            del missing[cell]
            yield cell, outcome
    except WorkerLost as error:
        names = ", ".join(f"{cell.study} {cell.label}" for cell in missing)
        raise WorkerLost(f"{error}; not finished: {names}") from error


def free_again(
    busy: Sequence[Cell], records: dict[Cell, AnyRecord], monitor: Monitor
) -> list[Cell]:
    """Wait until the others have stored these cells, or have left some of them to us."""
    leases = {cell: lease_of(cell.lease_path) for cell in busy}
    free: list[Cell] = []
    while leases and not free:
        sleep(POLL_SECONDS)
        for cell, lease in list(leases.items()):
            with held(lease) as ours:
                if ours and not found(cell, records, monitor):
                    free.append(cell)
            if ours:
                del leases[cell]
    return [*free, *leases]
