"""Runs or reads studies, compares them with their baselines, prints what moved."""

from pathlib import Path

import numpy as np
from rich.console import Console
from rich.text import Text

from esfem.campaigns.baseline.change import Change, Stored, exit_status
from esfem.campaigns.baseline.compare import compare, marked
from esfem.campaigns.baseline.junit import write_junit
from esfem.campaigns.baseline.stored import names_below, read_stored
from esfem.common.bad_input import BadInput
from esfem.common.console import print_table
from esfem.common.provenance import numerics_digest
from esfem.results.result_files import not_a_baseline, read_verdicts
from esfem.results.run_studies import run_studies
from esfem.studies.catalogue import default_studies, full_studies, study_path
from esfem.studies.study import Study, load_study

EFFECTS = ("worse", "better", "unknown")


def run_check(
    names: list[str],
    console: Console,
    *,
    baseline: Path,
    out: Path,
    junit: Path | None = None,
    read: bool = False,
    jobs: int | None = None,
    strict: bool = False,
) -> int:
    """Compare studies with their baseline, all that have one if no names: the exit status.

    Raises
    ------
    BadInput
        If a study has no baseline, or a baseline is damaged.
    """
    studies = chosen(names, baseline)
    before = {study.name: read_stored(baseline / study.name) for study in studies}
    if not read:
        not_a_baseline(out)
        run_studies(studies, out, console, jobs=jobs)
    changes, same = {}, set()
    for name, stored in before.items():
        current = _current(out / name, read)
        changes[name] = _compared(stored, current, out)
        if current is not None and unchanged(stored, current):
            same.add(name)
    show(changes, before, same, console)
    if junit is not None:
        write_junit(junit, changes, strict)
        console.print(f"JUnit: {junit}", soft_wrap=True)
    return exit_status([change for found in changes.values() for change in found], strict)


def chosen(names: list[str], baseline: Path) -> list[Study]:
    """The studies of these names or files, or all that have a baseline.

    A baseline without a committed study of its name stands for itself.
    """
    having = names_below(baseline)
    if not having:
        raise BadInput(f"--baseline {baseline}: holds no baseline (no STUDY/verdicts.json there)")
    committed = {path.stem: path for path in default_studies() + full_studies()}
    studies = []
    for name in dict.fromkeys(names or having):
        if name in having and name not in committed:
            studies.append(read_verdicts(baseline / name).parameters)
            continue
        studies.append(load_study(study_path(name)))
        if studies[-1].name not in having:
            raise BadInput(f"{name}: has no baseline below {baseline}; there are {having}")
    return studies


def unchanged(baseline: Stored, current: Stored) -> bool:
    """Whether statuses and errors of all runs are bit for bit those of the baseline."""
    columns = [c for c in baseline.records if c.startswith("err_")]
    if not set(columns) <= set(current.records) or len(baseline.records) != len(current.records):
        return False
    tables = [
        stored.records.set_index(["vertices", "tau"]).sort_index()[["status", *columns]]
        for stored in (baseline, current)
    ]
    return tables[0].equals(tables[1])


def show(
    changes: dict[str, list[Change]],
    before: dict[str, Stored],
    same: set[str],
    console: Console,
) -> None:
    """Print what moved, by how much and since when, and a line a study."""
    moved = [change for found in changes.values() for change in found if change.moved]
    rows = [
        (c.effect, c.study, c.variable, c.what, c.amount, f"{c.baseline} -> {c.current}")
        for c in moved
    ]
    print_table(rows, console)
    console.rule(Text("against the baseline", style="bold"), align="left")
    for name, found in changes.items():
        line = Text.assemble((f"{name}: ", "bold"), _line(found, name in same))
        console.print(line, f"; since {before[name].since}", sep="", soft_wrap=True)


def _line(found: list[Change], same: bool) -> str:
    """What is said of one study."""
    moved = [change for change in found if change.moved]
    counts = {effect: sum(c.effect == effect for c in moved) for effect in EFFECTS}
    if moved:
        said = ", ".join(f"{count} {effect}" for effect, count in counts.items() if count)
        return f"{said}, of {len(found)} comparisons"
    if same:
        return "unchanged"
    return f"within the tolerances, {_largest(found)}"


def _largest(found: list[Change]) -> str:
    """The comparison that used most of its tolerance."""

    def used(change: Change) -> float:
        if change.what == "order":
            return abs(change.by) / change.tolerance
        return float(abs(np.log(change.by)) / np.log(change.tolerance))

    sized = [change for change in found if change.amount]
    if not sized:
        return "which are on verdicts alone"
    change = max(sized, key=used)
    return f"most of all {change.what} of {change.variable}: {change.amount}"


def _current(folder: Path, read: bool) -> Stored | None:
    """The results to compare; None if there are none to read."""
    if read and not (folder / "verdicts.json").exists():
        return None
    return read_stored(folder)


def _compared(baseline: Stored, current: Stored | None, out: Path) -> list[Change]:
    """The comparisons, and what speaks against them."""
    if current is None:
        lacking = Change("results", "stored", f"none below {out}; run without --read")
        return marked([lacking], baseline)
    changes = compare(baseline, current)
    numerics = current.content.numerics
    if numerics == numerics_digest():
        return changes
    stale = f"computed by numerics {numerics}; run without --read"
    return [*marked([Change("code", f"numerics {numerics_digest()}", stale)], baseline), *changes]
