"""What a sentence is checked by: stored results of studies, of flows, and extra tables."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from harness.bad_input import BadInput
from harness.provenance import numerics_digest
from harness.stored_results import read_results
from harness.study import Study

FLOWS, EXTRA = "flows", "extra"  # folders, and what a name starts with: "flows/ellipsoid"


class Missing(Exception):
    """A result is not there, or not of this program; the message says which, and why."""


@dataclass(frozen=True)
class StudyData:
    """A study with its records (one row a run) and verdicts (one a variable, as stored)."""

    study: Study
    records: pd.DataFrame
    verdicts: list[dict[str, Any]]

    @property
    def finished(self) -> pd.DataFrame:
        """The runs that reached the final time."""
        return self.records[self.records["status"] == "ok"]


@dataclass(frozen=True)
class FlowData:
    """``checks.json`` of a flow: the file it was asked for, nodes, status, checks."""

    content: dict[str, Any]


@dataclass(frozen=True)
class Table:
    """The rows of an extra table."""

    rows: list[dict[str, Any]]


Evidence = StudyData | FlowData | Table


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
        return Table(_json(extra / f"{rest}.json", f"table {rest} has not been made")["table"])
    return study_data(runs / name, name)


def study_data(folder: Path, name: str) -> StudyData:
    """The stored results of a study; see `evidence`."""
    if not (folder / "verdicts.json").is_file():
        raise Missing(f"study {name} has not been run")
    try:
        study, records, _ = read_results(folder)
    except BadInput as error:
        raise Missing(str(error)) from error
    stored = _json(folder / "verdicts.json", f"study {name} has not been run")
    _current(f"study {name}", stored["numerics"])
    return StudyData(study, records, stored["verdicts"])


def flow_data(folder: Path, name: str) -> FlowData:
    """The stored results of a flow; see `evidence`."""
    content = _json(folder / "checks.json", f"flow {name} has not been run")
    _current(f"flow {name}", content["environment"]["numerics"])
    return FlowData(content)


def _current(name: str, numerics: str) -> None:
    if numerics != numerics_digest():
        raise Missing(f"{name} was run by numerics {numerics}, this is {numerics_digest()}")


def _json(path: Path, missing: str) -> dict[str, Any]:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise Missing(missing) from None
    except (OSError, ValueError) as error:
        raise Missing(f"{path.name}: cannot be read: {error}") from error
