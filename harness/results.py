"""The results of a study on disk: tables, plots and verdicts.json.

verdicts.json is written last and holds a digest of every file and of itself: what was edited by
hand, damaged or half-written is refused by `read_results` and written anew by `write_results`.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pydantic import ValidationError

from harness import provenance
from harness.bad_input import BadInput
from harness.collect import REFERENCE
from harness.selection import exclusions
from harness.store import write_text
from harness.study import Study
from harness.tables import latex, markdown, rates_table
from harness.verdict import Verdict, worst
from harness.verdicts import judge

TABLES = ("records.csv", "floors.csv", "rates.csv", "table.md", "table.tex")
PLOTS = ("errors.svg", "errors.pdf", "energy.svg", "energy.pdf")
STATUSES = ("ok", "diverged", "failed", REFERENCE)
# What tables and verdicts read from records.csv.
WHOLE = ("vertices", "nodes", "steps")
POSITIVE = (*WHOLE, "h", "tau", "final_time")
NUMBERS = (*POSITIVE, "stopped_at", "energy_0", "energy_T", "seconds")
ANEW = "`esfem run` writes it anew"


def write_results(
    folder: Path, study: Study, records: pd.DataFrame, floors: pd.DataFrame
) -> list[Verdict]:
    """Judge the records and write all files of the study, unless the same are there already."""
    verdicts = judge(study, records, floors)
    stamp = _stamp(study, records, floors)
    if not _is_current(folder, stamp):
        from harness.plots import (
            save_plots,
        )  # matplotlib takes a second to load: only when there is something to draw

        write_text(folder / "records.csv", records.to_csv(index=False))
        write_text(folder / "floors.csv", floors.to_csv(index=False))
        write_text(folder / "rates.csv", rates_table(study, records).to_csv(index=False))
        write_text(folder / "table.md", markdown(study, records, floors, verdicts))
        write_text(folder / "table.tex", latex(study, records))
        save_plots(folder, study, records)
        content = _verdicts_json(study, records, verdicts, stamp)
        content["files"] = {name: _file_digest(folder / name) for name in TABLES + PLOTS}
        content["digest"] = _own_digest(content)
        write_text(folder / "verdicts.json", json.dumps(content, indent=1))
    return verdicts


def _verdicts_json(
    study: Study, records: pd.DataFrame, verdicts: list[Verdict], stamp: str
) -> dict:
    return {
        "study": study.name,
        "title": study.study.title,
        "verdict": worst(verdicts),
        "excluded": exclusions(study, records),
        "verdicts": [plain(asdict(v)) for v in verdicts],
        "parameters": study.model_dump(mode="json"),
        "version": provenance.version(),
        "numerics": provenance.numerics_digest(),
        "command": provenance.command(),
        "machine": provenance.machine(),
        "dependencies": provenance.dependencies(),
        "seconds": float(records["seconds"].sum()),
        "stamp": stamp,
    }


def _stamp(study: Study, records: pd.DataFrame, floors: pd.DataFrame) -> str:
    """Hash of what the files are made from: study, records, claims, and the code of the harness."""
    here = Path(__file__).parent
    files = sorted([*here.glob("*.py"), *here.glob("judging/*.py")])
    sources = [floors.to_csv(index=False), *map(provenance.code, files)]
    claims = Path(__file__).with_name("claims.toml").read_text(encoding="utf-8")
    content = [study.model_dump_json(), records.to_csv(index=False), claims, *sources]
    return hashlib.sha256("\n".join(content).encode()).hexdigest()


def _is_current(folder: Path, stamp: str) -> bool:
    try:
        stored = _read_json(folder / "verdicts.json")
        check_digests(folder, stored, TABLES + PLOTS)
    except BadInput:
        return False
    return stored.get("stamp") == stamp


def read_results(folder: Path) -> tuple[Study, pd.DataFrame, pd.DataFrame]:
    """The study, the records and the floors stored in its folder.

    Raises
    ------
    BadInput
        If verdicts.json, records.csv or floors.csv is missing, damaged or was edited.
    """
    path = folder / "verdicts.json"
    stored = _read_json(path)
    try:
        study = Study.model_validate_json(json.dumps(stored.get("parameters")))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, ("parameters", *first["loc"])))
        raise BadInput(f"{path}: {where}: {_one_line(first['msg'])}; {ANEW}") from error
    records = read_records(folder, study.variables)
    check_digests(folder, stored, ("records.csv", "floors.csv"))
    return study, records, pd.read_csv(folder / "floors.csv")


def read_records(folder: Path, variables: Sequence[str]) -> pd.DataFrame:
    """records.csv, checked: its columns, their types, the statuses, and that no run occurs twice.

    It must hold the errors of the ``variables``.

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
    objection = _objection(records, variables)
    if objection:
        raise BadInput(f"{path}: {objection}; {ANEW}")
    return records.astype({name: "int64" for name in WHOLE})


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
    may_lack = {"stopped_at": True, "energy_0": True, "energy_T": records["status"] != "ok"}
    is_error = name.startswith("err_")
    lacking = may_lack.get(name, records["status"] != "ok" if is_error else False)
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
    if stored["digest"] != _own_digest(stored):
        raise BadInput(f"{folder / 'verdicts.json'}: was edited or damaged; {ANEW}")
    for name in names:
        try:
            found = _file_digest(folder / name)
        except OSError as error:
            raise BadInput(f"{folder / name}: cannot be read: {error.strerror}; {ANEW}") from error
        if stored["files"].get(name) != found:
            raise BadInput(f"{folder / name}: was edited or damaged; {ANEW}")


def _read_json(path: Path) -> dict[str, Any]:
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}; {ANEW}") from error
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{path}: cannot be read: {_one_line(error)}; {ANEW}") from error
    if not isinstance(stored, dict):
        raise BadInput(f"{path}: cannot be read: must hold an object; {ANEW}")
    return stored


def _file_digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def plain(value: Any) -> Any:
    """What JSON knows: a number that is not finite is null."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def _own_digest(content: dict[str, Any]) -> str:
    """Digest of verdicts.json without the field that holds it."""
    rest = {name: value for name, value in content.items() if name != "digest"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def _one_line(error: object) -> str:
    return " ".join(str(error).split())
