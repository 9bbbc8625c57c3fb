"""`esfem schemes`: the schemes of the paper's section 2.3 beside each other."""

import os
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from harness.api import run_studies
from harness.bad_input import BadInput
from harness.catalogue import scheme_studies
from harness.comparison.contest import PRINCIPAL, Options, principal
from harness.light import copy_studies
from harness.printing import plain_console, show, summary
from harness.stops import stops
from harness.store import writable_folder
from harness.study_result import StudyResult
from harness.verdict import exit_status

OUT, RUNS = Path("results/schemes"), Path("results/runs/schemes")
STUDIES = "studies"
PARTS = (STUDIES, "cost", "comparison", "orders", "course")


def schemes(
    out: Annotated[Path, typer.Option(help="Tables, figures and the report go there.")] = OUT,
    runs: Annotated[Path, typer.Option(help="Records of the studies go there.")] = RUNS,
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="PART", help=f"Among {', '.join(PARTS)}; may be repeated."),
    ] = None,
    scheme: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="A scheme that takes part too; may be repeated."),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="Number of processes; by default all cores.")
    ] = None,
) -> None:
    """Compare the schemes: studies, errors, drifts, largest stable tau, mesh quality, seconds.

    Interrupted, studies go on from their records; each other part is repeated as a whole. Exit
    status: that of the studies, as for `esfem run`; dziuk and bgn claim nothing.

    Example: `esfem schemes --only comparison --only orders --scheme my-scheme`
    """
    check(only or PARTS, out, runs, jobs)
    entrants = principal(scheme or ())
    with stops(runs):
        results = run_schemes(only or PARTS, out, runs, jobs, plain_console(), entrants)
    raise typer.Exit(exit_status(result.outcome for result in results))


def check(parts: Collection[str], out: Path, runs: Path, jobs: int | None) -> None:
    """BadInput unless these arguments can be used."""
    for part in parts:
        if part not in PARTS:
            raise BadInput(f"--only {part}: must be one of {', '.join(PARTS)}")
    if jobs is not None and jobs < 1:
        raise BadInput(f"--jobs {jobs}: must be at least 1")
    if out.resolve() == runs.resolve():
        raise BadInput(f"--out {out}: must be another folder than --runs")


def run_schemes(
    parts: Collection[str],
    out: Path,
    runs: Path,
    jobs: int | None,
    console: Console,
    entrants: Mapping[str, Options] = PRINCIPAL,
) -> list[StudyResult]:
    """Run these `PARTS`, and make the report of all that is in ``out``; the results of studies.

    Parameters
    ----------
    out, runs : the folders of the light part of the results, and of all results of studies.
    jobs : number of processes, by default all cores.
    console : is told.
    entrants : who is compared in the other parts, with the variants of kll.

    Raises
    ------
    BadInput
        If a folder cannot be written.
    """
    from harness.comparison.extras import compare_schemes  # matplotlib is slow to load
    from harness.reporting.write import write_report

    writable_folder(out)
    results = []
    if STUDIES in parts:
        results = run_studies(scheme_studies(), runs, console, jobs=jobs)
        for result in results:
            show(result, console)
        summary(results, console)
        copy_studies(runs, out, [result.study.name for result in results])
    compare_schemes(out, console, parts, jobs or os.cpu_count() or 1, entrants)
    console.print(f"report: {write_report(out, out / 'report', console.print)}", soft_wrap=True)
    return results
