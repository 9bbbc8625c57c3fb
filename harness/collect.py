"""From the stored records of a study to its tables of runs and of floors."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from harness.cell import Cell
from harness.errors import VARIABLES
from harness.floors import floors_table
from harness.rows import record_row
from harness.runner import Record
from harness.self_convergence import errors_against_finest
from harness.store import read_record
from harness.stored_results import REFERENCE
from harness.study import Study
from harness.study_result import StudyResult, judged

ERROR_COLUMNS = (("err_", ""), ("err_", "_l2"), ("t_", ""))


def collected(
    study: Study,
    folder: Path,
    cells: Sequence[Cell],
    say: Callable[[str], None] = lambda line: None,
    jobs: int = 1,
) -> StudyResult:
    """The result of a study, judged, from the records of its cells, as far as they have been run.

    ``say`` is told of what takes a while; that is done in ``jobs`` processes.
    """
    found = stored(cells)
    rows = rows_of(cells, found)
    runs = [rows[cell.key] for cell in cells if cell.key in rows and cell.floor is None]
    if study.initial.reference == "finest":
        errors = errors_against_finest(cells, found, say, jobs)
        runs = [against_finest_row(row, errors.get(row["key"])) for row in runs]
    records = pd.DataFrame(runs)
    varied = {c.floor: rows[c.key] for c in cells if c.key in rows and c.floor is not None}
    return judged(study, folder, records, floors_table(study, records, varied))


def stored(cells: Sequence[Cell]) -> dict[str, Record]:
    """The records of cells by key; cells without one are left out."""
    found = {cell.key: read_record(cell.folder, cell.key, lambda line: None) for cell in cells}
    return {key: record for key, record in found.items() if record is not None}


def rows_of(cells: Sequence[Cell], found: dict[str, Record]) -> dict[str, dict[str, Any]]:
    """The lines of records.csv by key, in the order of the cells."""
    return {c.key: record_row(c.study, c.key, found[c.key]) for c in cells if c.key in found}


def against_finest_row(row: dict[str, Any], errors: dict[str, float] | None) -> dict[str, Any]:
    """The row with its errors; a completed run without any is a reference, and has that status."""
    lacking = {f"{e}{v}{s}": np.nan for v in VARIABLES for e, s in ERROR_COLUMNS}
    if row["status"] != "ok" or errors is not None:
        return {**row, **lacking, **(errors or {})}
    return {**row, **lacking, "status": REFERENCE}
