"""What a report is made from: all that a folder of results holds."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, model_validator

from harness.bad_input import BadInput
from harness.loading import folders_of_results, load_result
from harness.reporting.flow_inputs import FlowResult, read_flows
from harness.study_result import StudyResult
from harness.verdict import Outcome

Kind = TypeVar("Kind")
Cell = str | float | int | bool | None


class Sentence(BaseModel):
    """One line of ``sentences.json``: a sentence of a paper, and what was measured about it."""

    model_config = ConfigDict(frozen=True)

    label: str
    section: str
    quote: str
    study: str
    measured: Cell
    expected: Cell
    verdict: Outcome
    note: str = ""


class Extra(BaseModel):
    """One file ``extra/NAME.json``: a section of its own; ``figure`` is an SVG file beside it."""

    model_config = ConfigDict(frozen=True)

    title: str
    text: str = ""
    table: list[dict[str, Cell]] = Field(default_factory=list)
    figure: str | None = None
    alt: str = ""

    @model_validator(mode="after")
    def _described(self) -> "Extra":
        if self.figure is not None and (Path(self.figure).name != self.figure or not self.alt):
            raise ValueError("figure: must be the name of an SVG file beside it, and have an alt")
        return self


@dataclass(frozen=True)
class Inputs:
    """All that is shown.

    ``extras`` are by the stem of their file; ``unfinished`` are folders with records of runs, but
    without the results of a study.
    """

    folder: Path
    studies: list[StudyResult]
    flows: list[FlowResult]
    sentences: list[Sentence]
    extras: dict[str, Extra]
    unfinished: list[str]


def read_inputs(folder: Path) -> Inputs:
    """All results in a folder.

    Raises
    ------
    BadInput
        If there is nothing to show, or a file is damaged.
    """
    studies = [load_result(found) for found in folders_of_results(folder)]
    sentences, extras = folder / "sentences.json", sorted(folder.glob("extra/*.json"))
    inputs = Inputs(
        folder,
        studies,
        read_flows(folder / "flows"),
        _read(sentences, list[Sentence]) if sentences.exists() else [],
        {path.stem: _read(path, Extra) for path in extras},
        _unfinished(folder),
    )
    if not (studies or inputs.flows or inputs.sentences or inputs.extras):
        raise BadInput(f"{folder}: holds no results (no STUDY/verdicts.json, no flows/NAME)")
    return inputs


def _unfinished(folder: Path) -> list[str]:
    """Folders of studies that were begun, and have no results yet."""
    begun = {path.parent for path in folder.glob("*/records") if path.is_dir()}
    return sorted(path.name for path in begun if not (path / "verdicts.json").exists())


def _read(path: Path, kind: type[Kind]) -> Kind:
    """The content of a JSON file, checked.

    Raises
    ------
    BadInput
        Naming the file, the key and what is wrong with it.
    """
    try:
        return TypeAdapter(kind).validate_python(read_json(path))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise BadInput(f"{path}: {where}: {first['msg']}, is {first['input']!r}") from error


def read_json(path: Path) -> Any:
    """The content of a JSON file; BadInput if it cannot be read."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise BadInput(f"{path}: cannot be read: {' '.join(str(error).split())}") from error
