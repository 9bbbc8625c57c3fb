"""The cells of studies, computed as it is asked for."""

import os
from collections.abc import Sequence
from dataclasses import dataclass

from rich.console import Console

from esfem.common.bad_input import BadInput
from esfem.common.defaults import EVERY_SECONDS
from esfem.common.provenance import numerics_digest
from esfem.measuring.profile import profile_flow
from esfem.runs.cell import Cell
from esfem.runs.display import Monitor
from esfem.runs.executors import Executor, executor_named
from esfem.runs.run_case import Record
from esfem.runs.store import record_path
from esfem.runs.sweep import sweep
from esfem.runs.work import Orders


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


def compute(
    cells: Sequence[Cell], workers: Executor, how: How, console: Console
) -> dict[Cell, Record]:
    """Sweep over the cells: their records, as far as they can be computed.

    Raises
    ------
    BadInput
        If a reference cannot be computed.
    """
    orders = Orders(how.force, how.checkpoint, workers.owner, numerics_digest())
    check_references(cells, how.force)
    with workers, Monitor(cells, workers.workers, console) as monitor:
        return sweep(cells, workers, orders, monitor)


def check_references(cells: Sequence[Cell], force: bool) -> None:
    """Raise BadInput unless the axisymmetric solver gets to all times of comparison of the runs
    that are to be computed."""
    for cell in cells:
        case = cell.case
        if case.initial.reference != "axisymmetric":
            continue
        if force or not record_path(cell.folder, cell.key).exists():
            try:
                profile_flow(case.initial, case.law, (0.0, *case.compare_at))
            except BadInput as error:
                raise BadInput(f"study '{cell.study}': {error}") from error
