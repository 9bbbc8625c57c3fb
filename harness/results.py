"""The results of a study on disk: tables, plots and verdicts.json.

verdicts.json is written last and holds a digest of every file and of itself: what was edited by
hand, damaged or half-written is refused by `harness.stored_results` and written anew by
`write_results`.
"""

import hashlib
import json
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from harness import provenance
from harness.bad_input import BadInput
from harness.claims import claims
from harness.closure import closure, digest
from harness.files import write_text
from harness.selection import exclusions
from harness.stored_results import check_digests, file_digest, own_digest, read_json
from harness.study import Study
from harness.tables import latex, markdown, rates_table
from harness.verdict import Verdict, worst
from harness.verdicts import judge

TABLES = ("records.csv", "floors.csv", "rates.csv", "table.md", "table.tex")
PLOTS = ("errors.svg", "errors.pdf", "energy.svg", "energy.pdf")


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
        content["files"] = {name: file_digest(folder / name) for name in TABLES + PLOTS}
        content["digest"] = own_digest(content)
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
    """Hash of what the files are made from: study, its claim, records, and the code that judges,
    tabulates and draws, which is this module and all that it imports."""
    claim = claims().get(study.study.claim or "")
    content = [
        study.model_dump_json(),
        *(table.to_csv(index=False) for table in (records, floors)),
        claim.model_dump_json() if claim else "",
        code_digest(),
    ]
    return hashlib.sha256("\n".join(content).encode()).hexdigest()


@cache
def code_digest() -> str:
    """Hash of the code that makes the files of a study from its records."""
    return digest(closure(__name__))


def _is_current(folder: Path, stamp: str) -> bool:
    try:
        stored = read_json(folder / "verdicts.json")
        check_digests(folder, stored, TABLES + PLOTS)
    except BadInput:
        return False
    return stored.get("stamp") == stamp


def plain(value: Any) -> Any:
    """What JSON knows: a number that is not finite is null."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
