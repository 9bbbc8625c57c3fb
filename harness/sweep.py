"""The sweep: all cells of all studies over the cores, longest first, stored as soon as done."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Protocol

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from harness.case import Case
from harness.floors import floor_cases
from harness.judging.floors import FloorName
from harness.meshing import SurfaceMesh
from harness.runner import run_case
from harness.store import key, read_record, record_path, write_record, write_text
from harness.study import Study


class WorkerLost(RuntimeError):
    """A worker process ended without a result, killed from outside or for lack of memory."""


REPORT_SECONDS = 0.5  # a running cell tells its progress at most this often


@dataclass(frozen=True)
class Cell:
    """One run of one study: where its record goes, and on which triangulation it is computed.

    ``floor`` names the floor that it measures; None for a cell of the sweep itself.
    """

    study: str
    folder: Path
    case: Case
    surface: SurfaceMesh
    floor: FloorName | None = None

    @property
    def key(self) -> str:
        """The key of its record."""
        return key(self.case, self.surface.digest)

    @property
    def label(self) -> str:
        """For a line of progress."""
        return self.case.label + (f", {self.floor} floor" if self.floor else "")

    @property
    def progress_path(self) -> Path:
        """The file in which a running cell tells the fraction it has done."""
        return self.folder / "progress" / self.key

    @property
    def cost(self) -> float:
        """Expected work in arbitrary units, for the order of the queue and the remaining time.

        Nodes a triangulation vertex grow like k^2; a step grows a little faster than its nodes.
        """
        nodes = len(self.surface.vertices) * self.case.scheme.degree**2
        return self.case.steps * (nodes**1.15 + 300.0)


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


def cells_of(study: Study, folder: Path, surfaces: dict[int, SurfaceMesh]) -> list[Cell]:
    """The cells of a study with results in ``folder`` and triangulations by number of vertices,
    those that measure its floors last."""
    sweep = [Cell(study.name, folder, case, surfaces[case.vertices]) for case in study.cases()]
    return sweep + [
        Cell(study.name, folder, case, surfaces[case.vertices], floor)
        for floor, case in floor_cases(study).items()
    ]


def sweep(cells: Sequence[Cell], jobs: int, force: bool, monitor: Monitor) -> None:
    """Compute and store every cell that has no valid record; with ``force``, every cell.

    Each cell runs in a process of its own with one thread; what is stored survives any
    interruption.
    """
    waiting = []
    for cell in cells:
        cell.progress_path.unlink(missing_ok=True)
        record = None if force else read_record(cell.folder, cell.key, monitor.say)
        if record is None:
            waiting.append(cell)
        else:
            monitor.found(cell, record.status)
    if not waiting:
        return
    waiting.sort(key=lambda cell: cell.cost, reverse=True)
    by_path = {record_path(cell.folder, cell.key): cell for cell in waiting}
    with parallel_config(backend="loky", inner_max_num_threads=1):
        run = Parallel(
            n_jobs=min(jobs, len(waiting)), return_as="generator_unordered", batch_size=1
        )
        try:
            done = run(delayed(compute)(cell, os.getpid()) for cell in waiting)
            for path, status, seconds in done:
                monitor.finished(by_path.pop(path), status, seconds)
        except TerminatedWorkerError as error:
            names = ", ".join(f"{cell.study} {cell.label}" for cell in by_path.values())
            raise WorkerLost(f"a worker process was killed; not finished: {names}") from error


def compute(cell: Cell, owner: int) -> tuple[Path, str, float]:
    """Run one cell and store its record; returns the path of that, the status and the seconds.

    ``owner`` is the process that asked for it: when that was killed, its workers end themselves.
    """
    last = -REPORT_SECONDS

    def report(fraction: float) -> None:
        nonlocal last
        if owner not in (os.getpid(), os.getppid()):
            os._exit(1)
        if monotonic() - last >= REPORT_SECONDS:
            last = monotonic()
            write_text(cell.progress_path, f"{fraction:.4f}")

    report(0.0)
    try:
        record, snapshots = run_case(cell.case, cell.surface, report)
        write_record(cell.folder, cell.key, record, snapshots)
    finally:
        cell.progress_path.unlink(missing_ok=True)
    return record_path(cell.folder, cell.key), record.status, record.seconds["total"]


def progress(cell: Cell) -> float | None:
    """The fraction that a running cell last told, or None if it is not running."""
    try:
        return float(cell.progress_path.read_text())
    except (OSError, ValueError):
        return None
