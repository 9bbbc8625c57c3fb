"""Run studies from Python: what the command line calls, and what a user may call."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from rich.console import Console

from esfem.common.bad_input import BadInput
from esfem.common.defaults import DEFAULT_OUT
from esfem.common.files import writable_folder
from esfem.meshes.library import check_meshes, meshes_of
from esfem.results.records import collected
from esfem.results.result_files import write_results
from esfem.results.study_result import StudyResult
from esfem.runs.store import cells_of
from esfem.runs.sweep import How, sweep
from esfem.studies.catalogue import load_studies
from esfem.studies.study import Study


def run_study(study: Study | Path | str, out: Path | str = DEFAULT_OUT, **how: Any) -> pd.DataFrame:
    """Run one study, or read what is stored of it: its records as a table, one row a run.

    Parameters
    ----------
    study : a Study, the path of a study file, or the name of a committed study.
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
    workers, processes = options.workers(), options.processes
    loaded = load_studies(studies)
    sizes = [(study.initial.mesh_surface, study.sweep.vertices) for study in loaded]
    for study, of_study in zip(loaded, sizes, strict=True):
        try:
            check_meshes(*of_study)
        except ValueError as error:
            raise BadInput(f"study '{study.name}': [sweep] {error}") from error
    out = writable_folder(Path(out))
    folders = [writable_folder(out / study.name, "records", "progress") for study in loaded]
    meshes = [meshes_of(*of_study, out / "meshes", console.print) for of_study in sizes]
    cells = [
        cells_of(study, folder.resolve(), triangulations)
        for study, folder, triangulations in zip(loaded, folders, meshes, strict=True)
    ]
    records = sweep([cell for own in cells for cell in own], workers, options, console)
    results = []
    for study, folder, own in zip(loaded, folders, cells, strict=True):
        results.append(collected(study, folder, own, records, console.print, processes))
        write_results(results[-1])
    return results
