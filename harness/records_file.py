"""records.csv, a row a run, read back: what tables and verdicts could not use is refused."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from harness.bad_input import BadInput
from harness.energies import energy_before
from harness.files import reading
from solver.laws import Energy

REFERENCE = "reference"  # the status of a run that others are compared with
STATUSES = ("ok", "diverged", "failed", REFERENCE)
# What tables and verdicts read from records.csv.
WHOLE = ("vertices", "nodes", "steps")
POSITIVE = (*WHOLE, "h", "tau", "final_time")
ENERGIES = ("energy_0", "energy_T", "willmore_0", "willmore_T")
NUMBERS = (*POSITIVE, "stopped_at", *ENERGIES, "seconds")
ANEW = "`esfem run` writes it anew"


def read_records(
    folder: Path, variables: Sequence[str], energy: Energy | None = None
) -> pd.DataFrame:
    """records.csv, checked: its columns, their types, the statuses, and that no run occurs twice.

    It must hold the errors of the ``variables``. With the ``energy`` of the law, a table of a
    version that had W in the columns of the energy is read, too.

    Raises
    ------
    BadInput
        Naming the file, the column and the value.
    """
    path = folder / "records.csv"
    with reading(path, ANEW):
        records = pd.read_csv(path, low_memory=False)
    if energy is not None:
        records = _with_willmore(records, energy)
    objection = _objection(records, variables)
    if objection:
        raise BadInput(f"{path}: {objection}; {ANEW}")
    return records.astype({name: "int64" for name in WHOLE})


def _with_willmore(records: pd.DataFrame, energy: Energy) -> pd.DataFrame:
    """The table with columns of W, which those of the energy held before there were such."""
    if "willmore_T" in records.columns or "energy_T" not in records.columns:
        return records
    for end in ("0", "T"):
        if {f"energy_{end}", f"area_{end}"} <= set(records.columns):
            records[f"willmore_{end}"] = records[f"energy_{end}"]
            records[f"energy_{end}"] = energy_before(
                energy, lambda name, end=end: records[f"{name}_{end}"]
            )
    return records


def _objection(records: pd.DataFrame, variables: Sequence[str]) -> str | None:
    """The first thing wrong with a table of records."""
    numbers = (*NUMBERS, *(f"err_{name}" for name in variables))
    missing = [name for name in ("status", *numbers) if name not in records.columns]
    if missing:
        return f"column {missing[0]} is missing"
    if records.empty:
        return "holds no run"
    if not isinstance(records.index, pd.RangeIndex):
        return "has more entries in its lines than in its header"
    unknown = records.loc[~records["status"].isin(STATUSES), "status"]
    if len(unknown):
        return f"status = {unknown.iloc[0]}: must be one of {', '.join(STATUSES)}"
    for name in numbers:
        bad = _not_allowed(records, name)
        if len(bad):
            return f"{name} = {bad.iloc[0]}: must be {_allowed(name)}"
    twice = records[records.duplicated(["vertices", "tau"])]
    if len(twice):
        run = twice.iloc[0]
        return f"vertices = {run['vertices']}, tau = {run['tau']:g} occurs twice"
    return None


def _not_allowed(records: pd.DataFrame, name: str) -> pd.Series:
    """The entries of a column that are not what `_allowed` says."""
    column = records[name]
    number = pd.to_numeric(column, errors="coerce").astype(float)
    # A run that stopped early has no error and no final energy; one that did not, no such time.
    # A table of an earlier version may not know the energy of any run.
    stopped = records["status"] != "ok"
    may_lack = {
        **dict.fromkeys(("stopped_at", "energy_0", "willmore_0"), True),
        "energy_T": stopped | records["energy_T"].isna().all(),
        "willmore_T": stopped,
    }
    is_error = name.startswith("err_")
    lacking = may_lack.get(name, stopped if is_error else False)
    good = np.isfinite(number) & (column.dtype != bool)
    if name in POSITIVE:
        good &= number > 0
    if name in WHOLE:
        good &= (number % 1 == 0) & (number < 2**53)
    if is_error:
        good &= number >= 0
    return column[~(good | (column.isna() & lacking))]


def _allowed(name: str) -> str:
    if name in WHOLE:
        return "a positive whole number"
    if name in POSITIVE:
        return "a positive number"
    stopped = "a number, 0 or more; empty if the run stopped"
    return stopped if name.startswith("err_") else "a number"
