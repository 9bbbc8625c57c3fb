"""Results of a study, read back and checked: edited, damaged or half-written ones are refused."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pydantic import ValidationError

from harness.bad_input import BadInput
from harness.energies import energy_before
from harness.study import Study
from solver.laws import Energy

REFERENCE = "reference"  # the status of a run that others are compared with
STATUSES = ("ok", "diverged", "failed", REFERENCE)
# What tables and verdicts read from records.csv.
WHOLE = ("vertices", "nodes", "steps")
POSITIVE = (*WHOLE, "h", "tau", "final_time")
ENERGIES = ("energy_0", "energy_T", "willmore_0", "willmore_T")
NUMBERS = (*POSITIVE, "stopped_at", *ENERGIES, "seconds")
ANEW = "`esfem run` writes it anew"


def read_results(
    folder: Path, context: dict[str, str] | None = None
) -> tuple[Study, pd.DataFrame, pd.DataFrame]:
    """The study, the records and the floors stored in its folder.

    With the ``context`` `harness.study.CLAIMED_THEN` the study may claim what it may not today.

    Raises
    ------
    BadInput
        If verdicts.json, records.csv or floors.csv is missing, damaged or was edited.
    """
    path = folder / "verdicts.json"
    stored = read_json(path)
    try:
        parameters = json.dumps(stored.get("parameters"))
        study = Study.model_validate_json(parameters, context=context)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, ("parameters", *first["loc"])))
        raise BadInput(f"{path}: {where}: {_one_line(first['msg'])}; {ANEW}") from error
    records = read_records(folder, study.variables, study.law.energy)
    check_digests(folder, stored, ("records.csv", "floors.csv"))
    return study, records, pd.read_csv(folder / "floors.csv")


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
    try:
        records = pd.read_csv(path, low_memory=False)
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}; {ANEW}") from error
    except ValueError as error:
        raise BadInput(f"{path}: cannot be read: {_one_line(error)}; {ANEW}") from error
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


def check_digests(folder: Path, stored: dict[str, Any], names: Sequence[str]) -> None:
    """Whether verdicts.json and the named files are as they were written.

    Raises
    ------
    BadInput
        Naming the first file that is not.
    """
    if "digest" not in stored or not isinstance(stored.get("files"), dict):
        raise BadInput(f"{folder / 'verdicts.json'}: holds no digests; {ANEW}")
    if stored["digest"] != own_digest(stored):
        raise BadInput(f"{folder / 'verdicts.json'}: was edited or damaged; {ANEW}")
    for name in names:
        try:
            found = file_digest(folder / name)
        except OSError as error:
            raise BadInput(f"{folder / name}: cannot be read: {error.strerror}; {ANEW}") from error
        if stored["files"].get(name) != found:
            raise BadInput(f"{folder / name}: was edited or damaged; {ANEW}")


def read_json(path: Path) -> dict[str, Any]:
    """The object in a JSON file; BadInput if there is none."""
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}; {ANEW}") from error
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{path}: cannot be read: {_one_line(error)}; {ANEW}") from error
    if not isinstance(stored, dict):
        raise BadInput(f"{path}: cannot be read: must hold an object; {ANEW}")
    return stored


def file_digest(path: Path) -> str:
    """SHA-256 of the bytes of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def own_digest(content: dict[str, Any]) -> str:
    """Digest of verdicts.json without the field that holds it."""
    rest = {name: value for name, value in content.items() if name != "digest"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def _one_line(error: object) -> str:
    return " ".join(str(error).split())
