"""The sweep: all cells of all studies over the cores, longest first, stored as soon as done.

Processes share nothing but the files of records, of leases and of checkpoints, so a sweep may be
killed, and several may work on the same studies at once.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from time import sleep
from typing import Protocol

from harness.cell import Cell
from harness.executors import Executor, WorkerLost
from harness.leases import is_held
from harness.store import read_record
from harness.work import BUSY, Orders, Outcome, compute

POLL_SECONDS = 0.5  # between looks at what other sweeps compute


class Monitor(Protocol):
    """Watches a sweep: on a terminal a live grid, elsewhere plain lines."""

    def __enter__(self) -> "Monitor": ...

    def __exit__(self, *exception: object) -> None: ...

    def say(self, line: str) -> None:
        """A message to the user."""

    def found(self, cell: Cell, status: str) -> None:
        """The cell has a stored record."""

    def finished(self, cell: Cell, status: str, seconds: float) -> None:
        """The cell was computed."""


def sweep(
    cells: Sequence[Cell],
    executor: Executor,
    orders: Orders,
    expected: Callable[[Cell], float],
    monitor: Monitor,
) -> None:
    """Compute and store every cell that has no valid record; with ``orders.force``, every cell.

    What is ``expected`` to take longest comes first; what another sweep computes meanwhile is
    waited for, and computed here if that one was killed. What is stored survives any interruption.
    """
    waiting = []
    for cell in cells:
        if not is_held(cell.lease_path):
            cell.progress_path.unlink(missing_ok=True)
        record = None if orders.force else read_record(cell.folder, cell.key, monitor.say)
        if record is None:
            waiting.append(cell)
        else:
            monitor.found(cell, record.status)
    waiting.sort(key=expected, reverse=True)
    while waiting:
        busy = [
            cell
            for cell, outcome in computed(waiting, executor, orders)
            if not told(cell, outcome, monitor)
        ]
        waiting = free_again(busy, monitor)


def computed(
    cells: Sequence[Cell], executor: Executor, orders: Orders
) -> Iterator[tuple[Cell, Outcome]]:
    """The cells with their outcomes; WorkerLost names those that have none."""
    missing = {id(cell): cell for cell in cells}
    try:
        for cell, outcome in executor.run(partial(compute, orders=orders), cells):
            del missing[id(cell)]
            yield cell, outcome
    except WorkerLost as error:
        names = ", ".join(f"{cell.study} {cell.label}" for cell in missing.values())
        raise WorkerLost(f"{error}; not finished: {names}") from error


def told(cell: Cell, outcome: Outcome, monitor: Monitor) -> bool:
    """Tell the monitor; False if another process computes the cell."""
    if outcome.status == BUSY:
        return False
    if outcome.seconds is None:
        monitor.found(cell, outcome.status)
    else:
        monitor.finished(cell, outcome.status, outcome.seconds)
    return True


def free_again(busy: Sequence[Cell], monitor: Monitor) -> list[Cell]:
    """Wait until the others have stored these cells, or have left some of them to us."""
    free: list[Cell] = []
    while busy and not free:
        sleep(POLL_SECONDS)
        still = []
        for cell in busy:
            if is_held(cell.lease_path):
                still.append(cell)
                continue
            record = read_record(cell.folder, cell.key, monitor.say)
            if record is None:
                free.append(cell)
            else:
                monitor.found(cell, record.status)
        busy = still
    return [*free, *busy]
