"""What a report is made from: all that a folder of results holds."""

from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from esfem.common.bad_input import BadInput
from esfem.common.files import read_json
from esfem.flows.flow_results import FlowResult, read_flows
from esfem.judging.outcome import Outcome
from esfem.report.extra import Cell, StoredExtra
from esfem.results.result_files import VERDICTS, load_results
from esfem.results.study_result import StudyResult


class Sentence(BaseModel):
    """One line of ``sentences.json``: a sentence of a paper, and what was measured about it;
    ``error`` says in which error, where the sentence does not."""

    model_config = ConfigDict(frozen=True)

    label: str
    section: str
    quote: str
    study: str
    measured: Cell
    expected: Cell
    verdict: Outcome
    note: str = ""
    error: str = ""


@dataclass(frozen=True)
class ResultsFolder:
    """All that is shown.

    ``extras`` are by the stem of their file; ``unfinished`` are folders with records of runs, but
    without the results of a study.
    """

    folder: Path
    studies: list[StudyResult]
    flows: list[FlowResult]
    sentences: list[Sentence]
    extras: dict[str, StoredExtra]
    unfinished: list[str]


def read_folder(folder: Path) -> ResultsFolder:
    """All results in a folder.

    Raises
    ------
    BadInput
        If there is nothing to show, or a file is damaged.
    """
    studies = load_results(folder)
    sentences, extras = folder / "sentences.json", sorted(folder.glob("extra/*.json"))
    results = ResultsFolder(
        folder,
        studies,
        read_flows(folder / "flows"),
        read_json(sentences, list[Sentence]) if sentences.exists() else [],
        {path.stem: read_json(path, StoredExtra) for path in extras},
        _unfinished(folder),
    )
    if not (studies or results.flows or results.sentences or results.extras):
        raise BadInput(f"{folder}: holds no results (no STUDY/{VERDICTS}, no flows/NAME)")
    return results


def _unfinished(folder: Path) -> list[str]:
    """Folders of studies that were begun, and have no results yet."""
    begun = {path.parent for path in folder.glob("*/records") if path.is_dir()}
    return sorted(path.name for path in begun if not (path / VERDICTS).exists())
