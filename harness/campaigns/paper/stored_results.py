"""What a sentence is checked by, stored results of studies, of flows, and extra tables; and what a
check of it finds."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pydantic import BaseModel, ConfigDict

from esfem.common.bad_input import BadInput
from esfem.common.files import read_json
from esfem.common.provenance import numerics_digest
from esfem.flows.flow_results import CHECKS, CheckedFlow, read_checks
from esfem.judging.outcome import Outcome
from esfem.results.result_files import VERDICTS, read_verdicts, result_of
from esfem.results.study_result import StudyResult, judged
from esfem.studies.study import Study

FLOWS, EXTRA = "flows", "extra"  # folders, and what a name starts with: "flows/ellipsoid"
Row = dict[str, Any]
Evidence = StudyResult | CheckedFlow | list[Row]  # the rows are those of an extra table
NO_RUN = "no run reaches T"


class Missing(Exception):
    """A result is not there, or not of this program; the message says which, and why."""


class Part(BaseModel):
    """A part of the (h, tau) grid of a study, its ends included: on what a sentence is read."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    vertices_from: int = 0
    vertices_to: int | None = None
    tau_from: float = 0.0
    tau_to: float | None = None

    def has(self, vertices: int, tau: float) -> bool:
        """Whether the cell lies in this part."""
        most, largest = self.vertices_to or inf, self.tau_to or inf
        return self.vertices_from <= vertices <= most and self.tau_from <= tau <= largest

    def of(self, study: Study) -> Study:
        """The study on this part of its grid; ValueError if none of it is left."""
        sweep = study.sweep
        vertices = [v for v in sweep.vertices if self.has(v, self.tau_from)]
        tau = [t for t in sweep.tau if self.has(self.vertices_from, t)]
        if not (vertices and tau):
            raise ValueError(f"part = {self!r}: holds no run of {study.name}")
        smaller = sweep.model_copy(update={"vertices": vertices, "tau": tau})
        return study.model_copy(update={"sweep": smaller})

    def lines(self, table: pd.DataFrame) -> pd.DataFrame:
        """The lines of a table with columns vertices and tau that lie in this part."""
        cells = zip(table["vertices"], table["tau"], strict=True)
        kept = np.array([self.has(vertices, tau) for vertices, tau in cells], dtype=bool)
        return table[kept].reset_index(drop=True)


def within(result: StudyResult, part: Part) -> StudyResult:
    """The runs of that part alone, judged anew; floors that were measured in it count."""
    records, floors = part.lines(result.records), part.lines(result.floors)
    return judged(part.of(result.study), result.folder, records, floors)


def finished(result: StudyResult) -> pd.DataFrame:
    """The runs that reached the final time."""
    return result.records[result.records["status"] == "ok"]


def stopped_runs(records: pd.DataFrame) -> str:
    """The runs that stop early: "V = 30: tau = 0.1 (t = 1), 0.05 (t = 0.85); V = 60: ..."."""
    stopped = records[records["status"] != "ok"].sort_values("tau", ascending=False)
    lines = []
    for vertices, runs in stopped.groupby("vertices"):
        ends = ", ".join(f"{run.tau:g} (t = {run.stopped_at:.3g})" for run in runs.itertuples())
        lines.append(f"V = {vertices}: tau = {ends}")
    return "; ".join(lines)


@dataclass(frozen=True)
class Finding:
    """``measured`` and ``expected`` in words and numbers, the verdict, and what must be known to
    read it."""

    measured: str
    expected: str
    verdict: Outcome
    note: str = ""


def held(holds: bool) -> Outcome:
    """The verdict on something that holds, or does not."""
    return "pass" if holds else "fail"


def evidence(runs: Path, extra: Path, name: str) -> Evidence:
    """The results of "STUDY", "flows/FLOW" or "extra/TABLE".

    Raises
    ------
    Missing
        If there are none, or they are of another version of the program.
    """
    kind, _, rest = name.rpartition("/")
    if kind == FLOWS:
        return stored_flow(runs / FLOWS / rest, rest)
    if kind == EXTRA:
        return stored_table(extra / f"{rest}.json", rest)
    return stored_study(runs / name, name)


def stored_study(folder: Path, name: str) -> StudyResult:
    """The stored results of a study; see `evidence`."""
    with _readable(folder / VERDICTS, f"study {name} has not been run"):
        stored = read_verdicts(folder)
        result = result_of(folder, stored)
    _current(f"study {name}", stored.numerics)
    return result


def stored_flow(folder: Path, name: str) -> CheckedFlow:
    """What was checked of a flow; see `evidence`."""
    with _readable(folder / CHECKS, f"flow {name} has not been run"):
        found = read_checks(folder)
    _current(f"flow {name}", found.environment["numerics"])
    return found


def stored_table(path: Path, name: str) -> list[Row]:
    """The rows of an extra table; see `evidence`."""
    with _readable(path, f"table {name} has not been made"):
        rows: list[Row] = read_json(path, dict[str, Any])["table"]
    return rows


@contextmanager
def _readable(path: Path, missing: str) -> Iterator[None]:
    """`Missing` if the file is not there, with that message, or what is read in here is damaged."""
    if not path.is_file():
        raise Missing(missing)
    try:
        yield
    except BadInput as error:
        raise Missing(str(error)) from error


def _current(name: str, numerics: str) -> None:
    if numerics != numerics_digest():
        raise Missing(f"{name} was run by numerics {numerics}, this is {numerics_digest()}")
