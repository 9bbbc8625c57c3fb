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

from harness import provenance
from harness.bad_input import BadInput
from harness.closure import closure, digest
from harness.files import write_text
from harness.stored_results import check_digests, file_digest, own_digest, read_json
from harness.study_result import StudyResult
from harness.tables import latex, markdown, rates_table

TABLES = ("records.csv", "floors.csv", "rates.csv", "table.md", "table.tex")
PLOTS = ("errors.svg", "errors.pdf", "energy.svg", "energy.pdf")


def write_results(result: StudyResult) -> None:
    """Write all files of the study into its folder, unless the same are there already."""
    folder, stamp = result.folder, _stamp(result)
    if _is_current(folder, stamp):
        return
    from harness.plots import save_plots  # matplotlib is slow to load: where something is drawn

    tables = (result.records.to_csv(index=False), result.floors.to_csv(index=False))
    tables += (rates_table(result).to_csv(index=False), markdown(result), latex(result))
    for name, text in zip(TABLES, tables, strict=True):
        write_text(folder / name, text)
    save_plots(folder, result)
    content = _verdicts_json(result, stamp)
    content["files"] = {name: file_digest(folder / name) for name in TABLES + PLOTS}
    content["digest"] = own_digest(content)
    write_text(folder / "verdicts.json", json.dumps(content, indent=1))


def _verdicts_json(result: StudyResult, stamp: str) -> dict:
    return {
        "study": result.study.name,
        "title": result.study.title,
        "verdict": result.outcome,
        "excluded": result.excluded,
        "verdicts": [plain(asdict(v)) for v in result.verdicts],
        "parameters": result.study.model_dump(mode="json"),
        "version": provenance.version(),
        "numerics": provenance.numerics_digest(),
        "command": provenance.command(),
        "machine": provenance.machine(),
        "dependencies": provenance.dependencies(),
        "seconds": float(result.records["seconds"].sum()),
        "stamp": stamp,
    }


def _stamp(result: StudyResult) -> str:
    """Hash of what the files are made from: study, its claim, records, and the code that judges,
    tabulates and draws, which is this module and all that it imports."""
    claim = result.study.claimed
    content = [
        result.study.model_dump_json(),
        *(table.to_csv(index=False) for table in (result.records, result.floors)),
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
