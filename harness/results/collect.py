"""From the stored records of a study to its tables of runs and of floors."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from esfem.measuring.lift import VARIABLES
from esfem.results.records_file import REFERENCE
from esfem.results.rows import record_row
from esfem.results.study_result import StudyResult, judged
from esfem.runs.against_finest import errors_against_finest
from esfem.runs.cell import Cell
from esfem.runs.run_case import Record
from esfem.studies.study import Study
from esfem.studies.variations import floors_table

ERROR_COLUMNS = (("err_", ""), ("err_", "_l2"), ("t_", ""))


def collected(
    study: Study,
    folder: Path,
    cells: Sequence[Cell],
    records: Mapping[Cell, Record],
    say: Callable[[str], None] = lambda line: None,
    jobs: int = 1,
) -> StudyResult:
    """The result of a study, judged, from the records of its cells, as far as they have been run.

    ``say`` is told of what takes a while; that is done in ``jobs`` processes.
    """
    rows = rows_of(cells, records)
    own = [cell for cell in cells if cell.floor is None]
    runs = [rows[cell] for cell in own if cell in rows]
    if study.initial.reference == "finest":
        found = {cell.key: records[cell] for cell in own if cell in records}
        errors = errors_against_finest(own, found, say, jobs)
        runs = [against_finest_row(row, errors.get(row["key"])) for row in runs]
    table = pd.DataFrame(runs)
    varied = {cell.floor: row for cell, row in rows.items() if cell.floor is not None}
    return judged(study, folder, table, floors_table(study, table, varied))


def rows_of(cells: Sequence[Cell], records: Mapping[Cell, Record]) -> dict[Cell, dict[str, Any]]:
    """The lines of records.csv, in the order of the cells; cells without a record are left out."""
    return {c: record_row(c.study, c.key, records[c]) for c in cells if c in records}


def against_finest_row(row: dict[str, Any], errors: dict[str, float] | None) -> dict[str, Any]:
    """The row with its errors; a completed run without any is a reference, and has that status."""
    lacking = {f"{e}{v}{s}": np.nan for v in VARIABLES for e, s in ERROR_COLUMNS}
    if row["status"] != "ok" or errors is not None:
        return {**row, **lacking, **(errors or {})}
    return {**row, **lacking, "status": REFERENCE}
