"""Reads stored results and the history of a baseline; refuses what a comparison cannot use."""

import json
from pathlib import Path
from typing import Any

from harness.bad_input import BadInput
from harness.regression.change import Stored
from harness.regression.compare import MESH, RANK
from harness.stored_results import read_results
from harness.study import CLAIMED_THEN

HISTORY = "history.json"
NUMBERS = ("expected", "tolerance", "limit", "observed", "lower", "upper", "constant", "scatter")
TEXTS = ("variable", "claim", "direction", "verdict")
ENTRY = ("when", "why", "version", "numerics", "digest")


def read_stored(folder: Path) -> Stored:
    """The results in the folder of a study, and why they are the baseline, if they are.

    Raises
    ------
    BadInput
        If they are missing, damaged, of an older version, or a baseline that was changed otherwise
        than by `esfem baseline --update`.
    """
    records = read_results(folder, CLAIMED_THEN)[1]
    if MESH not in records:
        raise BadInput(f"{folder / 'records.csv'}: column {MESH} is missing; run the study again")
    path = folder / "verdicts.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    for verdict in content["verdicts"]:
        for name in (*TEXTS, *NUMBERS, "vertices", "tau"):
            if name not in verdict:
                raise BadInput(
                    f"{path}: variable {verdict.get('variable')} lacks {name!r}: was written by "
                    "another version; run the study and `esfem baseline --update` it"
                )
        if verdict["verdict"] not in RANK:
            raise BadInput(f"{path}: verdict = {verdict['verdict']}: none of {', '.join(RANK)}")
    history = read_history(folder)
    if history and history[-1]["digest"] != content["digest"]:
        raise BadInput(
            f"{path}: is not what {HISTORY} recorded last; only `esfem baseline --update` moves it"
        )
    last = history[-1] if history else None
    return Stored(content, records, f"{last['why']}, {last['when']}" if last else "")


def read_history(folder: Path) -> list[dict[str, Any]]:
    """The moves of a baseline, first to last; none if there is no history.

    Raises
    ------
    BadInput
        If the file is damaged.
    """
    path = folder / HISTORY
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return []
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{path}: cannot be read: {' '.join(str(error).split())}") from error
    if not isinstance(entries, list) or not entries:
        raise BadInput(f"{path}: must hold a list of moves")
    for entry in entries:
        lacking = [name for name in ENTRY if not isinstance(entry, dict) or name not in entry]
        if lacking:
            raise BadInput(f"{path}: a move lacks {lacking[0]!r}")
    return entries


def names_below(folder: Path) -> list[str]:
    """The studies that have results below the folder."""
    found = [path.parent.name for path in folder.glob("*/verdicts.json")]
    return sorted(name for name in found if not name.startswith("."))


def not_a_baseline(out: Path) -> None:
    """Raise BadInput if results written to ``out`` would move a baseline."""
    if any(out.glob(f"*/{HISTORY}")):
        raise BadInput(f"--out {out}: holds baselines, which `esfem baseline --update` alone moves")
