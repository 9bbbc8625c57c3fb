"""From the stored records of a study to its tables of runs and of floors."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from harness.cell import Cell
from harness.errors import VARIABLES
from harness.floors import floors_table
from harness.quantities import is_self_convergence
from harness.records_file import REFERENCE
from harness.rows import record_row
from harness.runner import Record
from harness.self_convergence import errors_against_finest
from harness.study import Study

ERROR_COLUMNS = (("err_", ""), ("err_", "_l2"), ("t_", ""))


def collect(
    cells: Sequence[Cell],
    records: Mapping[Cell, Record],
    say: Callable[[str], None] = lambda line: None,
    jobs: int = 1,
) -> pd.DataFrame:
    """The records of a study's cells as a table, one row a run; cells without one are left out.

    ``say`` is told of what takes a while; that is done in ``jobs`` processes.
    """
    cells = [cell for cell in cells if cell.floor is None]
    own = {cell.key: records[cell] for cell in cells if cell in records}
    rows = [record_row(cell.study, cell.key, own[cell.key]) for cell in cells if cell.key in own]
    if len(cells) and is_self_convergence(cells[0].case.solution.initial()):
        errors = errors_against_finest(cells, own, say, jobs)
        rows = [against_finest_row(row, errors.get(row["key"])) for row in rows]
    return pd.DataFrame(rows)


def collect_floors(
    study: Study, cells: Sequence[Cell], records: Mapping[Cell, Record], table: pd.DataFrame
) -> pd.DataFrame:
    """The floors of a study (`harness.floors.floors_table`), as far as they have been measured;
    ``table`` is that of its runs."""
    rows = {
        cell.floor: record_row(cell.study, cell.key, records[cell])
        for cell in cells
        if cell.floor and cell in records
    }
    return floors_table(study, table, rows)


def against_finest_row(row: dict[str, Any], errors: dict[str, float] | None) -> dict[str, Any]:
    """The row with its errors; a completed run without any is a reference, and has that status."""
    lacking = {f"{e}{v}{s}": np.nan for v in VARIABLES for e, s in ERROR_COLUMNS}
    if row["status"] != "ok" or errors is not None:
        return {**row, **lacking, **(errors or {})}
    return {**row, **lacking, "status": REFERENCE}
