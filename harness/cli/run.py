"""`esfem run` and `esfem table`: studies computed, their tables shown."""

from pathlib import Path
from typing import Annotated

import typer

from esfem.cli.options import Checkpoint, Executor, Force, Jobs, Out, Scheduler
from esfem.cli.stops import stops
from esfem.common.bad_input import BadInput
from esfem.common.console import plain_console
from esfem.common.defaults import DEFAULT_OUT, EVERY_SECONDS


def run(
    studies: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="STUDY.toml ...",
            help="Study files, or names of committed studies; the default ones if none.",
        ),
    ] = None,
    *,
    out: Out = DEFAULT_OUT,
    jobs: Jobs,
    force: Force = False,
    every: Annotated[
        bool, typer.Option("--all", help="Run also the studies below harness/studies/full.")
    ] = False,
    executor: Executor = "local",
    scheduler: Scheduler = None,
    checkpoint: Checkpoint = EVERY_SECONDS,
) -> None:
    """Run studies, print rate tables and verdicts; what is stored below OUT is not repeated.

    Example: `esfem run harness/studies/sphere.toml my-study.toml --out results/runs --jobs 2`
    """
    from esfem.judging.outcome import exit_status
    from esfem.results.result_files import not_a_baseline
    from esfem.results.run_studies import run_studies
    from esfem.results.tables import print_results
    from esfem.studies.catalogue import default_studies, full_studies

    if every and studies:
        raise BadInput(f"--all {studies[0]}: --all runs all committed studies and takes no name")
    chosen: list[Path | str] = [*(studies or default_studies()), *(full_studies() if every else ())]
    console = plain_console()
    not_a_baseline(out)
    with stops(out):
        results = run_studies(
            chosen,
            out,
            console,
            jobs=jobs,
            force=force,
            executor=executor,
            scheduler=scheduler,
            checkpoint=checkpoint,
        )
    print_results(results, console)
    raise typer.Exit(exit_status([result.outcome for result in results]))


def table(
    folder: Annotated[
        Path,
        typer.Argument(metavar="DIR", help="Folder of a study's results, or of several studies."),
    ],
    judge: Annotated[
        bool, typer.Option("--judge", help="Judge the stored records afresh, by today's claims.")
    ] = False,
) -> None:
    """Print rate tables and verdicts of stored results.

    Example: `esfem table results/runs/sphere`
    """
    from esfem.results.result_files import VERDICTS, judged_afresh, load_results
    from esfem.results.tables import print_result

    console = plain_console()
    results = load_results(folder)
    if not results:
        raise BadInput(f"{folder}: holds no results (no {VERDICTS} there or one level below)")
    for result in results:
        print_result(judged_afresh(result) if judge else result, console)
