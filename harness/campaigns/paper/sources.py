"""What a sentence is checked by, stored results of studies, of flows, and extra tables; and what a
check of it finds."""

from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import BaseModel, ConfigDict

from esfem.common.bad_input import BadInput
from esfem.common.files import read_json
from esfem.common.provenance import numerics_digest
from esfem.flows.flow_results import CHECKS, CheckedFlow, read_checks
from esfem.judging.outcome import SEVERITY, Outcome
from esfem.results.result_files import VERDICTS, read_verdicts, result_of
from esfem.results.verdicts import Verdict, judge
from esfem.studies.study import Study

FLOWS, EXTRA = "flows", "extra"  # folders, and what a name starts with: "flows/ellipsoid"


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


@dataclass(frozen=True)
class StudyData:
    """A study with its records (one row a run), verdicts (one a variable) and floors."""

    study: Study
    records: pd.DataFrame
    verdicts: list[Verdict]
    floors: pd.DataFrame | None = None

    @property
    def finished(self) -> pd.DataFrame:
        """The runs that reached the final time."""
        return self.records[self.records["status"] == "ok"]

    def within(self, part: Part) -> "StudyData":
        """The runs of that part alone, judged anew; floors that were measured in it count."""
        study = part.of(self.study)
        records = _within(self.records, part)
        floors = None if self.floors is None else _within(self.floors, part)
        return StudyData(study, records, judge(study, records, floors), floors)


@dataclass(frozen=True)
class Table:
    """The rows of an extra table."""

    rows: list[dict[str, Any]]


Evidence = StudyData | CheckedFlow | Table


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


def joined(verdicts: list[Outcome]) -> Outcome:
    """The worst of them: what was not claimed, or not exercised, does not decide."""
    return max(verdicts, key=SEVERITY.index)


def stopped_runs(records: pd.DataFrame) -> str:
    """The runs that stop early: "V = 30: tau = 0.1 (t = 1), 0.05 (t = 0.85); V = 60: ..."."""
    stopped = records[records["status"] != "ok"].sort_values("tau", ascending=False)
    lines = []
    for vertices, runs in stopped.groupby("vertices"):
        ends = ", ".join(f"{run.tau:g} (t = {run.stopped_at:.3g})" for run in runs.itertuples())
        lines.append(f"V = {vertices}: tau = {ends}")
    return "; ".join(lines)


def evidence(runs: Path, extra: Path, name: str) -> Evidence:
    """The results of "STUDY", "flows/FLOW" or "extra/TABLE".

    Raises
    ------
    Missing
        If there are none, or they are of another version of the program.
    """
    kind, _, rest = name.rpartition("/")
    if kind == FLOWS:
        return flow_data(runs / FLOWS / rest, rest)
    if kind == EXTRA:
        return Table(_content(extra / f"{rest}.json", f"table {rest} has not been made")["table"])
    return study_data(runs / name, name)


def study_data(folder: Path, name: str) -> StudyData:
    """The stored results of a study; see `evidence`."""
    if not (folder / VERDICTS).is_file():
        raise Missing(f"study {name} has not been run")
    try:
        stored = read_verdicts(folder)
        result = result_of(folder, stored)
    except BadInput as error:
        raise Missing(str(error)) from error
    _current(f"study {name}", stored.numerics)
    return StudyData(result.study, result.records, result.verdicts, result.floors)


def flow_data(folder: Path, name: str) -> CheckedFlow:
    """What was checked of a flow; see `evidence`."""
    if not (folder / CHECKS).is_file():
        raise Missing(f"flow {name} has not been run")
    try:
        found = read_checks(folder)
    except BadInput as error:
        raise Missing(str(error)) from error
    _current(f"flow {name}", found.environment["numerics"])
    return found


def _within(table: pd.DataFrame, part: Part) -> pd.DataFrame:
    """The lines of a table with columns vertices and tau that lie in the part."""
    cells = zip(table["vertices"], table["tau"], strict=True)
    return table[[part.has(vertices, tau) for vertices, tau in cells]].reset_index(drop=True)


def _current(name: str, numerics: str) -> None:
    if numerics != numerics_digest():
        raise Missing(f"{name} was run by numerics {numerics}, this is {numerics_digest()}")


def _content(path: Path, missing: str) -> dict[str, Any]:
    if not path.exists():
        raise Missing(missing)
    try:
        return read_json(path, dict[str, Any])
    except BadInput as error:
        raise Missing(str(error)) from error
