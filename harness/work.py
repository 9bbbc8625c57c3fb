"""What a worker does with a cell: lease, record, checkpoint."""

import logging
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from time import monotonic

from harness.bad_input import BadInput
from harness.cell import Cell
from harness.checkpoint import Keeper
from harness.files import remove, write_text
from harness.leases import acquire
from harness.provenance import environment, numerics_digest
from harness.runner import run_case
from harness.store import content, read_record, write_record

BUSY = "busy"  # another process computes the cell
REPORT_SECONDS = 0.5  # a running cell tells its progress at most this often
log = logging.getLogger("esfem")  # on standard error, or in the log of a cluster's worker


@dataclass(frozen=True)
class Orders:
    """What a sweep tells its workers.

    ``force`` computes also what is stored; ``checkpoint`` is the time between two checkpoints of a
    run in seconds, None for no checkpoint; workers end themselves when ``owner`` was killed;
    ``numerics`` tells a worker of another version from ours.
    """

    force: bool = False
    checkpoint: float | None = None
    owner: int | None = None
    numerics: str = ""


@dataclass(frozen=True)
class Outcome:
    """The status of the record, or `BUSY`; ``seconds`` is None if it was there already."""

    status: str
    seconds: float | None = None


def compute(cell: Cell, orders: Orders) -> Outcome:
    """Run one cell and store its record, unless another process does or has."""
    if numerics_digest() != orders.numerics:
        raise BadInput(
            f"a worker runs other code than this sweep: numerics {numerics_digest()} there, "
            f"{orders.numerics} here"
        )
    lease = acquire(cell.lease_path)
    if lease is None:
        return Outcome(BUSY)
    with lease:
        stored = None if orders.force else read_record(cell.folder, cell.key, log.warning)
        if stored is not None:
            return Outcome(stored.status)
        keeper = keeper_of(cell, orders)
        try:
            record, snapshots = run_case(cell.case, cell.surface, reporter(cell, orders), keeper)
            write_record(cell.folder, cell.key, record, snapshots)
        finally:
            remove(cell.progress_path)
        if keeper is not None:
            keeper.discard()
        return Outcome(record.status, record.seconds["total"])


def keeper_of(cell: Cell, orders: Orders) -> Keeper | None:
    """The keeper of the checkpoint of a cell; one that cannot be used is told of and left aside."""
    if orders.checkpoint is None or cell.case.plugin.run is None:
        return None  # a scheme that is given by its step starts from the beginning
    plain = content(cell.case, cell.surface.digest)
    words = {k: v for k, v in environment().items() if k != "machine"}
    identity = {**words, **{k: str(v) for k, v in (plain.pop("case") | plain).items()}}
    keeper = Keeper(
        cell.checkpoint_path,
        identity,
        cell.case.levels,
        cell.case.scheme.order,
        orders.checkpoint,
        say=log.warning,
        refused=lambda line: log.warning("%s; the run starts anew", line),
    )
    if orders.force:
        keeper.discard()
    return keeper


def reporter(cell: Cell, orders: Orders) -> Callable[[float], None]:
    """Tells the fraction done to the sweep, and ends this process if that was killed."""
    last = -REPORT_SECONDS

    def report(fraction: float) -> None:
        nonlocal last
        if orders.owner not in (None, os.getpid(), os.getppid()):
            os._exit(1)
        if monotonic() - last >= REPORT_SECONDS:
            last = monotonic()
            with suppress(OSError):  # a full disk: the run may still end well
                write_text(cell.progress_path, f"{fraction:.4f}")

    report(0.0)
    return report
