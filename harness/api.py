"""Run studies from Python: what the command line calls, and what a user may call."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from rich.console import Console

from harness.bad_input import BadInput
from harness.display import monitor
from harness.meshing import SurfaceMesh, committed_mesh_path, surface_mesh
from harness.results import collect, write_results
from harness.store import writable_folder
from harness.study import Study, load_study
from harness.sweep import cells_of, sweep
from harness.verdicts import Verdict
from reference_solutions import SOLUTIONS

DEFAULT_OUT = Path("results/runs")


@dataclass(frozen=True)
class StudyResult:
    """A study with its records (one row a run) and its verdicts (one a variable)."""

    study: Study
    folder: Path
    records: pd.DataFrame
    verdicts: list[Verdict]


def run_study(
    study: Study | Path | str,
    out: Path | str = DEFAULT_OUT,
    jobs: int | None = None,
    force: bool = False,
) -> pd.DataFrame:
    """Run one study, or read what is stored of it: its records as a table, one row a run.

    Parameters
    ----------
    study : a Study, or the path of a study file.
    out : results go to ``out/<name of the study>``.
    jobs : number of processes, by default all cores.
    force : compute again what is stored.

    Raises
    ------
    BadInput
        With file, key, value and bound, before anything is computed.
    """
    return run_studies([study], out, jobs, force)[0].records


def run_studies(
    studies: Sequence[Study | Path | str],
    out: Path | str = DEFAULT_OUT,
    jobs: int | None = None,
    force: bool = False,
    console: Console | None = None,
) -> list[StudyResult]:
    """Run several studies in one sweep over the cores; see `run_study`."""
    console = Console(quiet=True) if console is None else console
    jobs = (os.cpu_count() or 1) if jobs is None else jobs
    if jobs < 1:
        raise BadInput(f"--jobs {jobs}: must be at least 1")
    loaded = [study if isinstance(study, Study) else load_study(Path(study)) for study in studies]
    names = [study.name for study in loaded]
    for name in names:
        if names.count(name) > 1:
            raise BadInput(
                f"[study] name = {name!r}: two of the given studies would share this folder"
            )
    out = writable_folder(Path(out))
    meshes = {study.name: meshes_of(study, out / "meshes", console) for study in loaded}
    cells = {
        study.name: cells_of(study, writable_folder(out / study.name), meshes[study.name])
        for study in loaded
    }
    every = [cell for of_study in cells.values() for cell in of_study]
    with monitor(every, console) as watch:
        sweep(every, jobs, force, watch)
    results = []
    for study in loaded:
        records = collect(cells[study.name])
        results.append(
            StudyResult(
                study, out / study.name, records, write_results(out / study.name, study, records)
            )
        )
    return results


def meshes_of(study: Study, cache: Path, console: Console) -> dict[int, SurfaceMesh]:
    """The triangulations by vertices: committed, else from ``cache``, else made and kept there."""
    surface = SOLUTIONS[study.solution.name].mesh_surface
    meshes = {}
    try:
        for vertices in study.sweep.vertices:
            path = cache / surface / f"V{vertices:05d}.npz"
            if path.exists() and not committed_mesh_path(surface, vertices).exists():
                meshes[vertices] = SurfaceMesh.load(path)
            else:
                meshes[vertices] = surface_mesh(surface, vertices, console.print)
                if not committed_mesh_path(surface, vertices).exists():
                    meshes[vertices].save(path)
    except ValueError as error:
        raise BadInput(f"study '{study.name}': [sweep] vertices: {error}") from error
    return meshes
