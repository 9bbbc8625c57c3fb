"""The results of a study on disk: tables, plots and verdicts.json."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pandas as pd

from harness import provenance
from harness.store import read_record, write_text
from harness.study import Study
from harness.sweep import Cell
from harness.tables import latex, markdown, rates_table, record_row
from harness.verdicts import Verdict, exclusions, judge, worst

TABLES = ("records.csv", "rates.csv", "table.md", "table.tex")
PLOTS = ("errors.svg", "errors.pdf", "energy.svg", "energy.pdf")


def collect(cells: Sequence[Cell]) -> pd.DataFrame:
    """The records of the cells as a table, one row a run; cells without a record are left out."""
    rows = []
    for cell in cells:
        record = read_record(cell.folder, cell.key, lambda line: None)
        if record is not None:
            rows.append(record_row(cell.study, cell.key, record))
    return pd.DataFrame(rows)


def write_results(folder: Path, study: Study, records: pd.DataFrame) -> list[Verdict]:
    """Judge the records and write all files of the study, unless the same are there already."""
    verdicts = judge(study, records)
    stamp = _stamp(study, records)
    if not _is_current(folder, stamp):
        from harness.plots import (
            save_plots,
        )  # matplotlib takes a second to load: only when there is something to draw

        write_text(folder / "records.csv", records.to_csv(index=False))
        write_text(folder / "rates.csv", rates_table(records).to_csv(index=False))
        write_text(folder / "table.md", markdown(study, records, verdicts))
        write_text(folder / "table.tex", latex(study, records))
        save_plots(folder, study, records)
        write_text(
            folder / "verdicts.json",
            json.dumps(_verdicts_json(study, records, verdicts, stamp), indent=1),
        )
    return verdicts


def _verdicts_json(
    study: Study, records: pd.DataFrame, verdicts: list[Verdict], stamp: str
) -> dict:
    def plain(value: object) -> object:
        return None if isinstance(value, float) and np.isnan(value) else value

    return {
        "study": study.name,
        "title": study.study.title,
        "verdict": worst(verdicts),
        "excluded": exclusions(study, records),
        "verdicts": [{name: plain(value) for name, value in asdict(v).items()} for v in verdicts],
        "parameters": study.model_dump(mode="json"),
        "version": provenance.version(),
        "numerics": provenance.numerics_digest(),
        "command": provenance.command(),
        "machine": provenance.machine(),
        "seconds": float(records["seconds"].sum()),
        "stamp": stamp,
    }


def _stamp(study: Study, records: pd.DataFrame) -> str:
    """Hash of what the files are made from: study, records, claims, and the code of the harness."""
    sources = [provenance.code(path) for path in sorted(Path(__file__).parent.glob("*.py"))]
    claims = Path(__file__).with_name("claims.toml").read_text(encoding="utf-8")
    content = [study.model_dump_json(), records.to_csv(index=False), claims, *sources]
    return hashlib.sha256("\n".join(content).encode()).hexdigest()


def _is_current(folder: Path, stamp: str) -> bool:
    try:
        stored = json.loads((folder / "verdicts.json").read_text(encoding="utf-8"))["stamp"]
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return stored == stamp and all((folder / name).exists() for name in TABLES + PLOTS)
