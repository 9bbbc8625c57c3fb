"""Baselines: results of studies, committed with the reasons for each move.

``esfem baseline --update`` is the only way to move one.
"""

import os
import shutil
from dataclasses import dataclass
from datetime import UTC, datetime
from math import isnan
from pathlib import Path
from typing import Any

from rich.console import Console

from esfem.campaigns.baseline.change import Change, Stored
from esfem.campaigns.baseline.compare import MESH, compare
from esfem.common.bad_input import BadInput
from esfem.common.files import read_json, write_json, writing
from esfem.common.provenance import numerics_digest
from esfem.results.result_files import HISTORY, VERDICTS, check_files, read_verdicts, result_of
from esfem.studies.catalogue import study_path
from esfem.studies.study import CLAIMED_THEN, load_study

FEWEST_WORDS = 3
# Of a change, by the history.
TOLD = ("variable", "what", "baseline", "current", "effect", "place", "by", "tolerance")


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


@dataclass(frozen=True)
class Move:
    """Results that are to be the baseline in ``target``; ``previous`` is what they are compared
    with, or the reason that there is nothing."""

    source: Path
    target: Path
    stored: Stored
    history: list[Entry]
    previous: Stored | str


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
    if not path.exists():
        return []
    history = read_json(path, list[Entry])
    if not history:
        raise BadInput(f"{path}: holds no move")
    return history


def names_below(folder: Path) -> list[str]:
    """The studies that have results below the folder."""
    found = [path.parent.name for path in folder.glob(f"*/{VERDICTS}")]
    return sorted(name for name in found if not name.startswith("."))


def show_baselines(baseline: Path, console: Console) -> None:
    """Print each baseline, its moves and why they were made."""
    for name in names_below(baseline):
        console.print(name, style="bold")
        lines = [
            f"{entry.when}  {entry.version} (numerics {entry.numerics}): {entry.why}"
            for entry in read_history(baseline / name)
        ]
        for line in lines or ["no history: never moved by `esfem baseline --update`"]:
            console.print(f"  {line}", soft_wrap=True)


def update(names: list[str], why: str, out: Path, baseline: Path, console: Console) -> None:
    """Make the stored results of the studies their baseline, all or none, and record why.

    Raises
    ------
    BadInput
        If no study or no reason is given, or results are missing, damaged or not current.
    """
    if not names:
        raise BadInput("--update: name the studies whose baseline is to move")
    if len(why.split()) < FEWEST_WORDS or not why.isprintable():
        raise BadInput(f"--why {why!r}: tell the reason, in {FEWEST_WORDS} words or more, one line")
    for move in [_planned(name, out, baseline) for name in dict.fromkeys(names)]:
        with writing(move.target):
            entry = _carry_out(move, why)
        line = "is the baseline already, nothing recorded"
        if entry is not None:
            line = f"baseline moved, {len(entry.moved)} changes recorded"
        console.print(f"{move.stored.study}: {line}", soft_wrap=True)


def _planned(name: str, out: Path, baseline: Path) -> Move:
    """The move of one study, if its results are current."""
    study = load_study(study_path(name))
    source, target = out / study.name, baseline / study.name
    first = f"run `esfem run {name} --out {out}` first"
    if not (source / VERDICTS).exists():
        raise BadInput(f"{source}: holds no results; {first}")
    history = read_history(target)
    in_place = target.exists() and source.resolve() == target.resolve()
    if in_place and history:
        raise BadInput(f"--out {out}: is the baseline itself; results come from another folder")
    stored = read_stored(source)
    check_files(source, stored.content.files, tuple(stored.content.files))
    if stored.content.numerics != numerics_digest():
        made = f"computed by numerics {stored.content.numerics}, this is {numerics_digest()}"
        raise BadInput(f"{source}: {made}; {first}")
    if stored.content.parameters != study:
        raise BadInput(f"{source}: not the results of the study as it is now; {first}")
    previous = "written in place" if in_place else _previous(target)
    return Move(source, target, stored, history, previous)


def _previous(target: Path) -> Stored | str:
    """The baseline so far, or why there is none to compare with; a damaged one may be replaced."""
    if not (target / VERDICTS).exists():
        return "no baseline before"
    try:
        return read_stored(target)
    except BadInput as error:
        return f"not comparable: {str(error).removeprefix(f'{target.parent}/')}"


def _carry_out(move: Move, why: str) -> Entry | None:
    """Replace the folder of the baseline as a whole; returns the entry of the history.

    None, and nothing is done, if the very same results are the baseline.
    """
    content, previous, moved = move.stored.content, move.previous, []
    if isinstance(previous, Stored):
        if move.history and move.history[-1].digest == content.digest:
            return None
        moved = [_plain(change) for change in compare(previous, move.stored) if change.moved]
        previous = previous.content.numerics
    today = f"{datetime.now(UTC):%Y-%m-%d}"
    made = content.version, content.numerics
    entry = Entry(today, why, *made, previous, content.digest, moved)
    staged = move.target.with_name(f".{move.target.name}.new.{os.getpid()}")
    try:
        staged.mkdir(parents=True)
        for name in (*content.files, VERDICTS):
            shutil.copyfile(move.source / name, staged / name)
        write_json(staged / HISTORY, [*move.history, entry])
        _swap(staged, move.target)
    finally:
        shutil.rmtree(staged, ignore_errors=True)
    return entry


def _plain(change: Change) -> dict[str, Any]:
    """A change as JSON: what is known of it, without what its entry says already."""
    told = {name: getattr(change, name) for name in TOLD}
    return {
        name: fact
        for name, fact in told.items()
        if fact != "" and not (isinstance(fact, float) and isnan(fact))
    }


def _swap(staged: Path, target: Path) -> None:
    """The staged folder takes the place of the target, and keeps the folders in that."""
    old = target.with_name(f".{target.name}.old.{os.getpid()}")
    if not target.exists():
        os.rename(staged, target)
        return
    os.rename(target, old)
    try:
        os.rename(staged, target)
    except OSError:
        os.rename(old, target)
        raise
    for path in old.iterdir():
        if path.is_dir():  # records and progress, which are not committed
            os.rename(path, target / path.name)
    shutil.rmtree(old)
