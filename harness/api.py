"""Run studies from Python: what the command line calls, and what a user may call."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from rich.console import Console

from harness.bad_input import BadInput
from harness.cell import Cell, cells_of
from harness.checkpoint import EVERY_SECONDS
from harness.collect import collected
from harness.cost import fitted, stored_timings
from harness.display import monitor
from harness.executors import Executor, executor_named
from harness.meshing import SurfaceMesh, check_vertices, committed_mesh_path, surface_mesh
from harness.provenance import numerics_digest
from harness.quantities import is_axisymmetric
from harness.reference import profile_flow
from harness.results import write_results
from harness.store import record_path, writable_folder
from harness.study import Study, load_study
from harness.study_result import StudyResult
from harness.sweep import sweep
from harness.work import Orders

DEFAULT_OUT = Path("results/runs")


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


def run_study(study: Study | Path | str, out: Path | str = DEFAULT_OUT, **how: Any) -> pd.DataFrame:
    """Run one study, or read what is stored of it: its records as a table, one row a run.

    Parameters
    ----------
    study : a Study, or the path of a study file.
    out : results go to ``out/<name of the study>``.
    how : ``jobs``, ``force``, ``executor``, ``scheduler``, ``checkpoint``, see `How`.

    Raises
    ------
    BadInput
        With file, key, value and bound, before anything is computed.
    """
    return run_studies([study], out, **how)[0].records


def run_studies(
    studies: Sequence[Study | Path | str],
    out: Path | str = DEFAULT_OUT,
    console: Console | None = None,
    **how: Any,
) -> list[StudyResult]:
    """Run several studies in one sweep; see `run_study`. The ``console`` is told."""
    options, console = How(**how), console or Console(quiet=True)
    executor = executor_named(options.executor, options.scheduler, options.processes)
    loaded = loaded_studies(studies)
    for study in loaded:
        check_meshes(study)
    out = writable_folder(Path(out))
    folders = [writable_folder(out / study.name, "records", "progress") for study in loaded]
    meshes = [meshes_of(study, out / "meshes", console) for study in loaded]
    cells = [
        cells_of(study, folder.resolve(), triangulations)
        for study, folder, triangulations in zip(loaded, folders, meshes, strict=True)
    ]
    compute([cell for own in cells for cell in own], executor, options, out, console)
    results = [
        collected(study, folder, own, console.print, options.processes)
        for study, folder, own in zip(loaded, folders, cells, strict=True)
    ]
    for result in results:
        write_results(result)
    return results


def loaded_studies(studies: Sequence[Study | Path | str]) -> list[Study]:
    """The studies, read from their files; BadInput if two of them have one name."""
    loaded = [study if isinstance(study, Study) else load_study(Path(study)) for study in studies]
    names = [study.name for study in loaded]
    for name in names:
        if names.count(name) > 1:
            raise BadInput(
                f"[study] name = {name!r}: two of the given studies would share this folder"
            )
    return loaded


def compute(
    cells: Sequence[Cell], executor: Executor, how: How, out: Path, console: Console
) -> None:
    """Sweep over the cells; BadInput if a reference cannot be computed."""
    check_references(cells, how.force)
    expected = fitted(stored_timings(out)).seconds
    with executor, monitor(cells, expected, executor.workers, console) as watch:
        orders = Orders(how.force, how.checkpoint, executor.owner, numerics_digest())
        sweep(cells, executor, orders, expected, watch)


def check_meshes(study: Study) -> None:
    """Raise BadInput unless there is a mesh of each size, or one can be generated."""
    surface = study.initial.mesh_surface
    for vertices in study.sweep.vertices:
        try:
            check_vertices(surface, vertices)
        except ValueError as error:
            raise BadInput(f"study '{study.name}': [sweep] {error}") from error


def check_references(cells: Sequence[Cell], force: bool) -> None:
    """Raise BadInput unless the axisymmetric solver gets to all times of comparison of the runs
    that are to be computed."""
    for cell in cells:
        case = cell.case
        if not is_axisymmetric(case.initial):
            continue
        if force or not record_path(cell.folder, cell.key).exists():
            try:
                profile_flow(case.initial, case.law, (0.0, *case.compare_at))
            except BadInput as error:
                raise BadInput(f"study '{cell.study}': {error}") from error


def meshes_of(study: Study, cache: Path, console: Console) -> dict[int, SurfaceMesh]:
    """The triangulations by vertices: committed, else from ``cache``, else made and kept there."""
    surface = study.initial.mesh_surface
    return {v: mesh_in(surface, v, cache, console) for v in study.sweep.vertices}


def mesh_in(surface: str, vertices: int, cache: Path, console: Console) -> SurfaceMesh:
    """The triangulation of so many vertices: committed, else from ``cache``, else made and kept.

    Raises
    ------
    BadInput
        If there is none, or it cannot be kept.
    """
    path = cache / surface / f"V{vertices:05d}.npz"
    committed = committed_mesh_path(surface, vertices).exists()
    try:
        if not committed and path.exists():
            try:
                return SurfaceMesh.load(path, surface, vertices)
            except ValueError as error:
                os.replace(path, path.with_suffix(".npz.damaged"))
                console.print(f"{error}; set aside, will be generated again", markup=False)
        mesh = surface_mesh(surface, vertices, console.print)
        if not committed:
            mesh.save(path)
        return mesh
    except ValueError as error:
        raise BadInput(f"mesh of {surface}, V = {vertices}: {error}") from error
    except OSError as error:
        raise BadInput(f"{path}: cannot be written: {error.strerror}") from error
