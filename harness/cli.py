"""The command line ``esfem``.

Exit status: 0 every claim holds, 1 a claim failed, 3 inconclusive, 2 bad input,
4 a worker process was killed, 130 interrupted.
"""

import sys
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated

import typer

from harness.api import DEFAULT_OUT, run_studies
from harness.bad_input import BadInput
from harness.catalogue import (
    default_studies,
    full_studies,
    study_path,
    study_sets,
)
from harness.checkpoint import EVERY_SECONDS
from harness.comparison.command import schemes
from harness.flows.command import flow
from harness.loading import load_results
from harness.meshing.command import mesh
from harness.paper.command import paper
from harness.printing import overview, plain_console, show, summary
from harness.regression.commands import baseline, check
from harness.regression.stored import not_a_baseline
from harness.reporting.command import compare, report
from harness.stops import stops
from harness.verdict import exit_status

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    help="Convergence verification for evolving surface finite elements.  \n"
    "Example: `esfem run sphere clifford --jobs 2`",
)


@app.command()
def run(
    studies: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="STUDY.toml ...",
            help="Study files, or names of committed studies; the default ones if none.",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Results go to OUT/STUDY.")] = DEFAULT_OUT,
    jobs: Annotated[
        int | None, typer.Option(help="Number of processes; by default all cores.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Compute again what is stored.")] = False,
    every: Annotated[
        bool, typer.Option("--all", help="Run also the studies below harness/studies/full.")
    ] = False,
    executor: Annotated[
        str, typer.Option(help="local: processes of this machine; dask: workers of a cluster.")
    ] = "local",
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Of dask, e.g. tls://login-node:8786.")
    ] = None,
    checkpoint: Annotated[
        float, typer.Option(metavar="SECONDS", help="From checkpoint to checkpoint of a long run.")
    ] = EVERY_SECONDS,
) -> None:
    """Run studies, print rate tables and verdicts; what is stored below OUT is not repeated.

    Example: `esfem run harness/studies/sphere.toml my-study.toml --out results/runs --jobs 2`
    """
    console = plain_console()
    if every and studies:
        raise BadInput(f"--all {studies[0]}: --all runs all committed studies and takes no name")
    not_a_baseline(out)
    paths = [study_path(name) for name in studies or ()] or default_studies()
    with stops(out):
        paths += full_studies() if every else []
        how = {"executor": executor, "scheduler": scheduler, "checkpoint": checkpoint}
        results = run_studies(paths, out, console, jobs=jobs, force=force, **how)
    for result in results:
        show(result, console)
    summary(results, console)
    raise typer.Exit(exit_status(result.outcome for result in results))


@app.command(name="list")
def list_() -> None:
    """List the studies, solutions, laws, claims and meshes there are.

    Example: `esfem list`
    """
    overview(study_sets(), plain_console())


@app.command()
def table(
    folder: Annotated[
        Path,
        typer.Argument(metavar="DIR", help="Folder of a study's results, or of several studies."),
    ],
) -> None:
    """Print rate tables and verdicts of stored results.

    Example: `esfem table results/runs/sphere`
    """
    console = plain_console()
    for result in load_results(folder):
        show(result, console)


@app.command(name="judge")
def judge_(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE.csv", help="Columns h and error, optionally tau, variable, status."
        ),
    ],
    order: Annotated[float, typer.Option(help="The claimed order.")],
    direction: Annotated[str, typer.Option(help="The swept parameter: h or tau.")] = "h",
    variable: Annotated[str | None, typer.Option(help="Judge this variable alone.")] = None,
    tolerance: Annotated[float, typer.Option(help="Of the order.")] = 0.2,
    json: Annotated[Path | None, typer.Option(help="Write the judgements there.")] = None,
) -> None:
    """Judge the order of convergence of anybody's table of errors.

    Example: `esfem judge errors.csv --order 2`
    """
    from harness.judging.command import judge_file  # scipy.optimize is slow to load

    status = judge_file(file, order, direction, variable, tolerance, json, plain_console())
    raise typer.Exit(status)


@app.command()
def mutants(
    only: Annotated[
        list[str] | None, typer.Option(help="A mutant or a group of them; may be repeated.")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="Number of processes; by default all cores.")
    ] = None,
    every: Annotated[
        bool, typer.Option("--all", help="Run all studies, also after one has failed.")
    ] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Leave out mutants that have a current result.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Where the report is written.")] = Path(
        "results/mutants"
    ),
) -> None:
    """Make the program wrong, line by line, and see whether the verdicts notice.

    Exit status 0 if they notice all that matters, 1 if a mutant survives.

    Example: `esfem mutants --only theta --jobs 2`
    """
    from harness.mutation.command import run_mutants  # imports what nothing else needs

    raise typer.Exit(run_mutants(only or (), jobs, every, resume, out, plain_console()))


app.command()(mesh)
app.command()(flow)
app.command()(check)
app.command()(baseline)
app.command()(paper)
app.command()(report)
app.command()(compare)
app.command()(schemes)


def main() -> None:
    """Entry point: bad input is one line on standard error and exit status 2."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal may not know all our characters
    try:
        app()
    except (BadInput, OSError) as error:  # standard output may be a full disk too
        line = " ".join(str(error).splitlines())
        plain_console(stderr=True).print(f"esfem: {line}", soft_wrap=True)
        sys.exit(2)
