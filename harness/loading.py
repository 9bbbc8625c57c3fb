"""Stored results of studies, read and judged afresh."""

from pathlib import Path

from harness.bad_input import BadInput
from harness.stored_results import read_results
from harness.study_result import StudyResult, judged


def load_results(folder: Path) -> list[StudyResult]:
    """The results stored in the folder of a study, or of several studies.

    Raises
    ------
    BadInput
        If there are none, or those of a study are damaged.
    """
    folders = folders_of_results(folder)
    if not folders:
        raise BadInput(f"{folder}: holds no results (no verdicts.json there or one level below)")
    return [load_result(found) for found in folders]


def folders_of_results(folder: Path) -> list[Path]:
    """Which folders hold results of a study: this one, and those in it."""
    try:
        found = sorted([*folder.glob("verdicts.json"), *folder.glob("*/verdicts.json")])
    except OSError as error:
        raise BadInput(f"{folder}: cannot be read: {error.strerror}") from error
    return [path.parent for path in found if not path.parent.name.startswith(".")]


def load_result(folder: Path) -> StudyResult:
    """The results stored in a study's folder, judged afresh.

    Raises
    ------
    BadInput
        If a file is missing or damaged.
    """
    study, records, floors = read_results(folder)
    try:
        return judged(study, folder, records, floors)
    except (ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{folder}: records cannot be judged: {error!r}") from error
