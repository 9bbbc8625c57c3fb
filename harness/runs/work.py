"""What a worker does with a cell: lease, record, checkpoint."""

import logging
import os
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, time

from filelock import SoftFileLease, Timeout

from esfem.common.bad_input import BadInput
from esfem.common.files import remove, write_text
from esfem.common.provenance import environment, numerics_digest
from esfem.runs.checkpoint import Keeper
from esfem.runs.run_case import run_case
from esfem.runs.run_pair import run_pair
from esfem.runs.store import AnyRecord, Cell, content, write_record
from esfem.solver.reference_element import Array

BUSY = "busy"  # another process computes the cell
BEAT = 5.0  # seconds from touch to touch of a lease
STALE = 60.0  # a lease untouched for so long has no holder any more
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
    with held(lease_of(cell.lease_path)) as ours:
        if not ours:
            return Outcome(BUSY)
        stored = None if orders.force else cell.stored(log.warning)
        if stored is not None:
            return Outcome(stored.status)
        keeper = keeper_of(cell, orders)
        try:
            record, snapshots = run(cell, reporter(cell, orders), keeper)
            write_record(cell.folder, cell.key, record, snapshots)
        finally:
            remove(cell.progress_path)
        if keeper is not None:
            keeper.discard()
        return Outcome(record.status, record.seconds["total"])


def run(
    cell: Cell, report: Callable[[float], None], keeper: Keeper | None
) -> tuple[AnyRecord, Array | None]:
    """The record of a cell, with the snapshots of one that is compared with other runs."""
    if cell.varied is None:
        return run_case(cell.case, cell.surface, report, keeper)
    return run_pair(cell.case, cell.varied, cell.surface, report, keeper), None


def lease_of(path: Path) -> SoftFileLease:
    """The lease of that path: of all processes that share the folder one has it, while it touches
    the file.

    A killed holder has lost it: at once if it was on this host, else when the same object has asked
    for `STALE` seconds and seen no touch, by its own clock. Should two processes compute a cell
    after all, they write the same record, each whole: leases save work, nothing hangs on them.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    return SoftFileLease(path, lease_duration=STALE, heartbeat_interval=BEAT)


@contextmanager
def held(lease: SoftFileLease) -> Iterator[bool]:
    """Hold the lease in the block if no other process does; tells whether it is held."""
    path = Path(lease.lock_file)
    with suppress(FileNotFoundError):  # an empty one: killed before it had written who it is
        if not path.stat().st_size and time() - path.stat().st_mtime > STALE:
            path.unlink()
    disown_zombie(lease)
    try:
        lease.acquire(blocking=False)
    except Timeout:
        yield False
        return
    try:
        yield True
    finally:
        lease.release()


def disown_zombie(lease: SoftFileLease) -> None:
    """Write into the lease of a zombie that another process had it, so that filelock takes it over.

    A killed process is a zombie until it is waited for, which in a container may be never; for
    filelock it runs as long.
    """
    owner = lease.owner
    if owner is None or not owner.start or not owner.hostname.startswith(platform.node()):
        return
    with suppress(OSError):  # it is gone
        state = Path(f"/proc/{owner.pid}/stat").read_text().rpartition(")")[2].split()
        if state[0] == "Z" and int(state[19]) == owner.start % 2**64:
            with open(lease.lock_file, "r+") as file:
                started, text = f"start={owner.start}\n", file.read()
                file.seek(0)
                file.write(text.replace(started, f"start={0:0{len(started) - 7}}\n"))


def keeper_of(cell: Cell, orders: Orders) -> Keeper | None:
    """The keeper of the checkpoint of a cell; one that cannot be used is told of and left aside."""
    if orders.checkpoint is None or cell.case.plugin.run is None:
        return None  # a scheme that is given by its step starts from the beginning
    plain, varied = content(cell.case, cell.surface.digest, cell.varied), cell.varied
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
        beside=None if varied is None else (varied.levels, varied.scheme.order),
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
