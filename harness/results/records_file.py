"""records.csv, a row a run, read back: what tables and verdicts could not use is refused."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

from esfem.common.bad_input import BadInput
from esfem.common.files import reading
from esfem.measuring.energies import energy_before
from esfem.solver.laws import Energy

REFERENCE = "reference"  # the status of a run that others are compared with
STATUSES = ("ok", "diverged", "failed", REFERENCE)
ANEW = "`esfem run` writes it anew"


@dataclass(frozen=True)
class Column:
    """What the numbers of a column must be, in words and by a test; ``lacks`` says of which runs it
    may be empty: "none", those that "stopped" early, or "all"."""

    allowed: str
    holds: Callable[[pd.Series], pd.Series]
    lacks: Literal["none", "stopped", "all"] = "none"


WHOLE = Column("a positive whole number", lambda n: (n > 0) & (n % 1 == 0) & (n < 2**53))
POSITIVE = Column("a positive number", lambda n: n > 0)
NUMBER = Column("a number", np.isfinite)
ERROR = Column("a number, 0 or more; empty if the run stopped", lambda n: n >= 0, "stopped")
# What tables and verdicts read from records.csv, beside the errors.
COLUMNS = {
    **dict.fromkeys(("vertices", "nodes", "steps"), WHOLE),
    **dict.fromkeys(("h", "tau", "final_time"), POSITIVE),
    **dict.fromkeys(("stopped_at", "energy_0", "willmore_0"), replace(NUMBER, lacks="all")),
    **dict.fromkeys(("energy_T", "willmore_T"), replace(NUMBER, lacks="stopped")),
    "seconds": NUMBER,
}


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
    return records.astype({name: "int64" for name in COLUMNS if COLUMNS[name] is WHOLE})


def _with_willmore(records: pd.DataFrame, energy: Energy) -> pd.DataFrame:
    """The table with columns of W, which those of the energy held before there were such."""
    if "willmore_T" in records.columns or "energy_T" not in records.columns:
        return records

    def column(name: str, end: str) -> pd.Series:
        return records[f"{name}_{end}"]

    for end in ("0", "T"):
        if {f"energy_{end}", f"area_{end}"} <= set(records.columns):
            records[f"willmore_{end}"] = records[f"energy_{end}"]
            records[f"energy_{end}"] = energy_before(energy, partial(column, end=end))
    return records


def _objection(records: pd.DataFrame, variables: Sequence[str]) -> str | None:
    """The first thing wrong with a table of records."""
    columns = {**COLUMNS, **dict.fromkeys((f"err_{name}" for name in variables), ERROR)}
    further = [f"{kind}_{name}" for kind in ("nodal", "idle") for name in variables]
    columns |= dict.fromkeys((name for name in further if name in records.columns), ERROR)
    missing = [name for name in ("status", *columns) if name not in records.columns]
    if missing:
        return f"column {missing[0]} is missing"
    if records.empty:
        return "holds no run"
    if not isinstance(records.index, pd.RangeIndex):
        return "has more entries in its lines than in its header"
    unknown = records.loc[~records["status"].isin(STATUSES), "status"]
    if len(unknown):
        return f"status = {unknown.iloc[0]}: must be one of {', '.join(STATUSES)}"
    if records["energy_T"].isna().all():  # as a table of an earlier version has it of some laws
        columns["energy_T"] = COLUMNS["energy_0"]
    for name, column in columns.items():
        bad = _not_allowed(records, name, column)
        if len(bad):
            return f"{name} = {bad.iloc[0]}: must be {column.allowed}"
    if "moved" in records and not records["moved"].dropna().isin((True, False)).all():
        return f"moved = {records['moved'].iloc[0]}: must be True or False"
    twice = records[records.duplicated(["vertices", "tau"])]
    if len(twice):
        run = twice.iloc[0]
        return f"vertices = {run['vertices']}, tau = {run['tau']:g} occurs twice"
    return None


def _not_allowed(records: pd.DataFrame, name: str, column: Column) -> pd.Series:
    """The entries that are not what the column must hold."""
    entries = records[name]
    number = pd.to_numeric(entries, errors="coerce").astype(float)
    may_lack = {"none": False, "stopped": records["status"] != "ok", "all": True}[column.lacks]
    good = np.isfinite(number) & column.holds(number) & (entries.dtype != bool)
    return entries[~(good | (entries.isna() & may_lack))]
