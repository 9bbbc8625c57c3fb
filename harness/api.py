"""Run studies from Python: what the command line calls, and what a user may call."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from rich.console import Console

from harness.bad_input import BadInput
from harness.cell import cells_of
from harness.collect import collected
from harness.compute import How, compute
from harness.meshing import SurfaceMesh, check_vertices, committed_mesh_path, surface_mesh
from harness.results import write_results
from harness.store import writable_folder
from harness.study import Study, load_study
from harness.study_result import StudyResult

DEFAULT_OUT = Path("results/runs")


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
    console, options = console or Console(quiet=True), How(**how)
    workers = options.workers()
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
    compute([cell for own in cells for cell in own], workers, options, out, console)
    results = []
    for study, folder, own in zip(loaded, folders, cells, strict=True):
        results.append(collected(study, folder, own, console.print, options.processes))
        write_results(results[-1])
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


def check_meshes(study: Study) -> None:
    """Raise BadInput unless there is a mesh of each size, or one can be generated."""
    surface = study.initial.mesh_surface
    for vertices in study.sweep.vertices:
        try:
            check_vertices(surface, vertices)
        except ValueError as error:
            raise BadInput(f"study '{study.name}': [sweep] {error}") from error


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
