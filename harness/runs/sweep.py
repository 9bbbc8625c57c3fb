"""The sweep: all cells of all studies over the cores, longest first, stored as soon as done.

Processes share nothing but the files of records, of leases and of checkpoints, so a sweep may be
killed, and several may work on the same studies at once.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from time import sleep

from esfem.runs.cell import Cell
from esfem.runs.display import Monitor
from esfem.runs.executors import Executor, WorkerLost
from esfem.runs.run_case import Record
from esfem.runs.work import BUSY, Orders, Outcome, compute, held, lease_of

POLL_SECONDS = 0.5  # between looks at what other sweeps compute


def sweep(
    cells: Sequence[Cell], executor: Executor, orders: Orders, monitor: Monitor
) -> dict[Cell, Record]:
    """The record of every cell; those that have no valid one, with ``orders.force`` all, are
    computed and stored first, those that cost most before others.

    What another sweep computes meanwhile is waited for, and computed here if that one was killed.
    What is stored survives any interruption.
    """
    records: dict[Cell, Record] = {}
    waiting = []
    for cell in cells:
        clear(cell)
        if orders.force or not found(cell, records, monitor):
            waiting.append(cell)
    waiting.sort(key=lambda cell: cell.weight, reverse=True)
    while waiting:
        busy = []
        for cell, outcome in computed(waiting, executor, orders):
            if outcome.status == BUSY:
                busy.append(cell)
            else:
                found(cell, records, monitor, outcome.seconds)
        waiting = free_again(busy, records, monitor)
    return records


def clear(cell: Cell) -> None:
    """Remove what a killed process has left of its lease and of its progress."""
    if cell.lease_path.exists() or cell.progress_path.exists():
        with held(lease_of(cell.lease_path)) as ours:
            if ours:
                cell.progress_path.unlink(missing_ok=True)


def found(
    cell: Cell, records: dict[Cell, Record], monitor: Monitor, seconds: float | None = None
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


def free_again(busy: Sequence[Cell], records: dict[Cell, Record], monitor: Monitor) -> list[Cell]:
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
