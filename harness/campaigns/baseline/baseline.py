"""``esfem baseline``: what the baselines are and why; ``--update`` is the only way to move one."""

import os
import shutil
from dataclasses import dataclass
from datetime import UTC, datetime
from math import isnan
from pathlib import Path
from typing import Any

from rich.console import Console

from esfem.campaigns.baseline.change import Change, Stored
from esfem.campaigns.baseline.compare import compare
from esfem.campaigns.baseline.stored import Entry, names_below, read_history, read_stored
from esfem.common.bad_input import BadInput
from esfem.common.files import write_json, writing
from esfem.common.provenance import numerics_digest
from esfem.results.result_files import HISTORY, VERDICTS, check_files
from esfem.studies.catalogue import study_path
from esfem.studies.study import load_study

FEWEST_WORDS = 3
TOLD = ("variable", "what", "baseline", "current", "effect")  # of a change, by the history


@dataclass(frozen=True)
class Move:
    """Results that are to be the baseline in ``target``; ``previous`` is what they are compared
    with, or the reason that there is nothing."""

    source: Path
    target: Path
    stored: Stored
    history: list[Entry]
    previous: Stored | str


def show_baselines(baseline: Path, console: Console) -> None:
    """Print each baseline, its moves and why they were made."""
    for name in names_below(baseline):
        console.print(name, style="bold")
        for entry in read_history(baseline / name) or [None]:
            line = "no history: never moved by `esfem baseline --update`"
            if entry is not None:
                origin = f"{entry.version} (numerics {entry.numerics})"
                line = f"{entry.when}  {origin}: {entry.why}"
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
    for move in [planned(name, out, baseline) for name in dict.fromkeys(names)]:
        with writing(move.target):
            entry = carry_out(move, why)
        line = "is the baseline already, nothing recorded"
        if entry is not None:
            line = f"baseline moved, {len(entry.moved)} changes recorded"
        console.print(f"{move.stored.study}: {line}", soft_wrap=True)


def planned(name: str, out: Path, baseline: Path) -> Move:
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


def carry_out(move: Move, why: str) -> Entry | None:
    """Replace the folder of the baseline as a whole; returns the entry of the history.

    None, and nothing is done, if the very same results are the baseline.
    """
    content, first = move.stored.content, isinstance(move.previous, str)
    if move.history and move.history[-1].digest == content.digest and not first:
        return None
    entry = Entry(
        when=f"{datetime.now(UTC):%Y-%m-%d}",
        why=why,
        version=content.version,
        numerics=content.numerics,
        previous=move.previous if first else move.previous.content.numerics,
        digest=content.digest,
        moved=[] if first else [_plain(c) for c in compare(move.previous, move.stored) if c.moved],
    )
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


def _previous(target: Path) -> Stored | str:
    """The baseline so far, or why there is none to compare with; a damaged one may be replaced."""
    if not (target / VERDICTS).exists():
        return "no baseline before"
    try:
        return read_stored(target)
    except BadInput as error:
        return f"not comparable: {str(error).removeprefix(f'{target.parent}/')}"


def _plain(change: Change) -> dict[str, Any]:
    """A change as JSON: what is known of it, without what its entry says already."""
    told = {name: getattr(change, name) for name in TOLD}
    numbers = {"by": change.by, "tolerance": change.tolerance}
    known = {name: number for name, number in numbers.items() if not isnan(number)}
    return {name: text for name, text in told.items() if text} | known
