"""Reads stored results and the history of a baseline; refuses what a comparison cannot use."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from esfem.campaigns.baseline.change import Stored
from esfem.campaigns.baseline.compare import MESH
from esfem.common.bad_input import BadInput
from esfem.common.files import read_json
from esfem.results.result_files import HISTORY, VERDICTS, read_verdicts, result_of
from esfem.studies.study import CLAIMED_THEN


@dataclass(frozen=True)
class Entry:
    """A move of a baseline: when and why, the program and the digest of the results, the numerics
    of those before (or why there were none), and the changes that were found."""

    when: str
    why: str
    version: str
    numerics: str
    previous: str
    digest: str
    moved: list[dict[str, Any]]


def read_stored(folder: Path) -> Stored:
    """The results in the folder of a study, and why they are the baseline, if they are.

    Raises
    ------
    BadInput
        If they are missing, damaged, of an older version, or a baseline that was changed otherwise
        than by `esfem baseline --update`.
    """
    content = read_verdicts(folder, CLAIMED_THEN)
    records = result_of(folder, content).records
    if MESH not in records:
        raise BadInput(f"{folder / 'records.csv'}: column {MESH} is missing; run the study again")
    history = read_history(folder)
    if history and history[-1].digest != content.digest:
        raise BadInput(
            f"{folder / VERDICTS}: is not what {HISTORY} recorded last; "
            "only `esfem baseline --update` moves it"
        )
    return Stored(content, records, f"{history[-1].why}, {history[-1].when}" if history else "")


def read_history(folder: Path) -> list[Entry]:
    """The moves of a baseline, first to last; none if there is no history.

    Raises
    ------
    BadInput
        If the file is damaged.
    """
    path = folder / HISTORY
    return read_json(path, Annotated[list[Entry], Field(min_length=1)]) if path.exists() else []


def names_below(folder: Path) -> list[str]:
    """The studies that have results below the folder."""
    found = [path.parent.name for path in folder.glob(f"*/{VERDICTS}")]
    return sorted(name for name in found if not name.startswith("."))
