"""The campaign of seeded bugs: tried, told, written."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from esfem.campaigns.mutants.campaign import (
    GOOD,
    Key,
    Seen,
    Trial,
    Tried,
    attempt,
    coarse_studies,
    prepared,
)
from esfem.campaigns.mutants.markdown import frame, kept, summary, write, write_lines
from esfem.campaigns.mutants.mutant import MUTANTS, Mutant
from esfem.common.bad_input import BadInput
from esfem.runs.executors import LocalProcesses


def chosen(only: Sequence[str]) -> tuple[Mutant, ...]:
    """The mutants of these names or groups; all if there are none.

    Raises
    ------
    BadInput
        If a name is neither.
    """
    groups = dict.fromkeys(mutant.group for mutant in MUTANTS)
    for name in only:
        if name not in groups and all(name != mutant.name for mutant in MUTANTS):
            told = ", ".join(groups)
            raise BadInput(f"--only {name}: must be a mutant or one of its groups: {told}")
    return tuple(m for m in MUTANTS if not only or m.name in only or m.group in only)


def run_mutants(
    only: Sequence[str], jobs: int, every: bool, resume: bool, out: Path, console: Console
) -> int:
    """Try the mutants, print and write the report; the exit status.

    Each result is stored at once; the report is written when there are all. Results that the same
    program, judge and studies made are kept for mutants that are not tried again; with ``resume``
    those that have one are not.

    0 if all that are not equivalent are caught and the program itself is good, 1 otherwise.
    """
    there = set(kept(frame([]), out)["mutant"]) if resume else set()
    mutants = [mutant for mutant in chosen(only) if mutant.name not in there]
    studies = coarse_studies()
    tried: list[Tried] = []
    expected: dict[Key, Seen] = {}
    trials: list[Trial] = []
    with Progress(console=console) as progress:
        task = progress.add_task("the program itself", total=len(studies))
        for study in studies:
            ready, found = prepared(study)
            tried.append(ready)
            expected |= found
            progress.advance(task)
        for key, verdict in expected.items():
            if verdict.outcome not in GOOD:
                console.print(f"not good without any mutant: {': '.join(key)}: {verdict.outcome}")
        task = progress.add_task("mutants", total=len(mutants))
        one = partial(attempt, tried=tried, expected=expected, every=every)
        for _, trial in LocalProcesses(jobs).run(one, mutants) if mutants else ():
            trials.append(trial)
            write_lines(kept(frame(trials), out), out)
            progress.advance(task)
            console.print(_line(trial), soft_wrap=True)
    table = kept(frame(trials), out)
    console.print(summary(table if resume else frame(trials)))
    if len(table) == len(MUTANTS):
        write(table, expected, out)
        console.print(f"written to {out}", soft_wrap=True)
    good = all(verdict.outcome in GOOD for verdict in expected.values())
    return 0 if good and all(trial.result != "survived" for trial in trials) else 1


def _line(trial: Trial) -> str:
    best = trial.best
    by = f" by {best.study}: {best.variable} ({best.outcome})" if best else ""
    change = "" if best else f", errors change by {100 * trial.change:.2g} % ({trial.where})"
    return f"{trial.result:10} {trial.mutant.name}{by}{change}, {trial.seconds:.1f} s"
