"""Committed results: damaged ones fail a test, those of an older program are told of.

While the program is being changed, results/ is behind it: it is made anew in the end, not with
every commit. Until then a test that compares a committed result with the program passes, and says
"older than the program" in the summary of warnings. With ``STRICT = True`` it fails: the switch
for a state of the program in which everything committed has been made by it.

Damage is another matter, and fails in both: a file that is not the one whose digest was recorded.
"""

import json
import warnings
from pathlib import Path
from typing import Any

import pytest

from esfem.campaigns.publish import files_of_study
from esfem.results.result_files import check_digests

STRICT = False
RESULTS = Path(__file__).resolve().parents[2] / "results"


def by_this_program(what: str, stored: str, here: str, remedy: str) -> bool:
    """Whether a committed result is of this program; if it is not, that is told, or a failure.

    Parameters
    ----------
    what : names the result.
    stored, here : the digest or version that it records, and that of this program.
    remedy : the command that makes it anew.
    """
    if stored == here:
        return True
    line = f"older than the program: {what} is by {stored}, this is {here}; {remedy}"
    if STRICT:
        pytest.fail(line)
    warnings.warn(line, stacklevel=2)
    return False


def whole(folder: Path) -> dict[str, Any]:
    """verdicts.json of a study, after it and all files beside it were found as they were written.

    Figures may be left out of what is committed. The content is not read by the rules of this
    program, which may have changed since.

    Raises
    ------
    BadInput
        If a file was edited, damaged or lost.
    """
    content = json.loads((folder / "verdicts.json").read_text(encoding="utf-8"))
    named = content.get("files", {})
    figures = [name for name in named if (folder / name).is_file()]
    names = {*(set(files_of_study(folder)) & set(named)), *figures}
    check_digests(folder, content, sorted(names))
    return content


def studies_below(folder: str) -> list[Path]:
    """The folders of studies in a folder of results/."""
    return sorted(path.parent for path in (RESULTS / folder).glob("*/verdicts.json"))
