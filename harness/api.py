"""Run studies from Python: what the command line calls, and what a user may call."""

import os
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from rich.console import Console

from harness.bad_input import BadInput
from harness.cell import Cell, cells_of
from harness.collect import collect, collect_floors
from harness.defaults import DEFAULT_OUT, EVERY_SECONDS
from harness.display import Monitor
from harness.executors import executor_named
from harness.files import writable_folder
from harness.meshing.library import check_meshes, meshes_of
from harness.provenance import numerics_digest
from harness.quantities import is_axisymmetric
from harness.reference import profile_flow
from harness.result_files import write_results
from harness.store import record_path
from harness.study import Study, load_study
from harness.study_result import StudyResult
from harness.sweep import sweep
from harness.work import Orders


def run_study(
    study: Study | Path | str,
    out: Path | str = DEFAULT_OUT,
    jobs: int | None = None,
    force: bool = False,
    executor: str = "local",
    scheduler: str | None = None,
    checkpoint: float | None = EVERY_SECONDS,
) -> pd.DataFrame:
    """Run one study, or read what is stored of it: its records as a table, one row a run.

    Parameters
    ----------
    study : a Study, or the path of a study file.
    out : results go to ``out/<name of the study>``.
    jobs : number of processes, by default all cores.
    force : compute again what is stored.
    executor : "local", processes of this machine, or "dask", workers of a cluster.
    scheduler : address of the dask scheduler; without one, ``jobs`` local workers are started.
    checkpoint : seconds from checkpoint to checkpoint of a run, None for none; shorter runs write
        none.

    Raises
    ------
    BadInput
        With file, key, value and bound, before anything is computed.
    """
    how = (executor, scheduler, checkpoint)
    return run_studies([study], out, jobs, force, None, *how)[0].records


def run_studies(
    studies: Sequence[Study | Path | str],
    out: Path | str = DEFAULT_OUT,
    jobs: int | None = None,
    force: bool = False,
    console: Console | None = None,
    executor: str = "local",
    scheduler: str | None = None,
    checkpoint: float | None = EVERY_SECONDS,
) -> list[StudyResult]:
    """Run several studies in one sweep; see `run_study`."""
    console = Console(quiet=True) if console is None else console
    jobs = (os.cpu_count() or 1) if jobs is None else jobs
    if jobs < 1:
        raise BadInput(f"--jobs {jobs}: must be at least 1")
    if checkpoint is not None and not checkpoint >= 0:
        raise BadInput(f"--checkpoint {checkpoint}: must not be negative")
    workers = executor_named(executor, scheduler, jobs)
    loaded = [study if isinstance(study, Study) else load_study(Path(study)) for study in studies]
    names = [study.name for study in loaded]
    for name in names:
        if names.count(name) > 1:
            raise BadInput(
                f"[study] name = {name!r}: two of the given studies would share this folder"
            )
    sizes = {s.name: (s.solution.initial().mesh_surface, s.sweep.vertices) for s in loaded}
    for name, of_study in sizes.items():
        try:
            check_meshes(*of_study)
        except ValueError as error:
            raise BadInput(f"study '{name}': [sweep] {error}") from error
    out = writable_folder(Path(out))
    meshes = {name: meshes_of(*sizes[name], out / "meshes", console.print) for name in sizes}
    folders = {
        study.name: writable_folder(out / study.name, "records", "progress") for study in loaded
    }
    cells = {
        study.name: cells_of(study, folders[study.name].resolve(), meshes[study.name])
        for study in loaded
    }
    every = [cell for of_study in cells.values() for cell in of_study]
    check_references(every, force)
    with workers, Monitor(every, workers.workers, console) as monitor:
        orders = Orders(force, checkpoint, workers.owner, numerics_digest())
        found = sweep(every, workers, orders, monitor)
    results = []
    for study in loaded:
        own = cells[study.name]
        records = collect(own, found, console.print, jobs)
        floors = collect_floors(study, own, found, records)
        results.append(
            StudyResult(
                study,
                out / study.name,
                records,
                floors,
                write_results(out / study.name, study, records, floors),
            )
        )
    return results


def check_references(cells: Sequence[Cell], force: bool) -> None:
    """Raise BadInput unless the axisymmetric solver gets to all times of comparison of the runs
    that are to be computed."""
    for cell in cells:
        solution, case = cell.case.solution.initial(), cell.case
        stored = record_path(cell.folder, cell.key).exists() and not force
        if is_axisymmetric(solution) and not stored:
            try:
                profile_flow(solution, case.law, (0.0, *case.compare_at))
            except BadInput as error:
                raise BadInput(f"study '{cell.study}': {error}") from error
