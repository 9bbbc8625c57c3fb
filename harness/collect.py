"""From the stored records of a study to its tables of runs and of floors."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from harness.cell import Cell
from harness.errors import VARIABLES
from harness.floors import floors_table
from harness.quantities import is_self_convergence
from harness.rows import record_row
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
    """The result of a study whose cells have been computed, judged; see `collect`."""
    records = collect(cells, say, jobs)
    return judged(study, folder, records, collect_floors(study, cells, records))


def collect(
    cells: Sequence[Cell], say: Callable[[str], None] = lambda line: None, jobs: int = 1
) -> pd.DataFrame:
    """The records of a study's cells as a table, one row a run; cells without one are left out.

    ``say`` is told of what takes a while; that is done in ``jobs`` processes.
    """
    cells = [cell for cell in cells if cell.floor is None]
    found = {cell.key: read_record(cell.folder, cell.key, lambda line: None) for cell in cells}
    records = {key: record for key, record in found.items() if record is not None}
    rows = [record_row(c.study, c.key, records[c.key]) for c in cells if c.key in records]
    if len(cells) and is_self_convergence(cells[0].case.initial):
        errors = errors_against_finest(cells, records, say, jobs)
        rows = [against_finest_row(row, errors.get(row["key"])) for row in rows]
    return pd.DataFrame(rows)


def collect_floors(study: Study, cells: Sequence[Cell], records: pd.DataFrame) -> pd.DataFrame:
    """The floors of a study (`harness.floors.floors_table`), as far as they have been measured."""
    rows = {}
    for cell in cells:
        record = read_record(cell.folder, cell.key, lambda line: None) if cell.floor else None
        if record is not None:
            rows[cell.floor] = record_row(cell.study, cell.key, record)
    return floors_table(study, records, rows)


def against_finest_row(row: dict[str, Any], errors: dict[str, float] | None) -> dict[str, Any]:
    """The row with its errors; a completed run without any is a reference, and has that status."""
    lacking = {f"{e}{v}{s}": np.nan for v in VARIABLES for e, s in ERROR_COLUMNS}
    if row["status"] != "ok" or errors is not None:
        return {**row, **lacking, **(errors or {})}
    return {**row, **lacking, "status": REFERENCE}
