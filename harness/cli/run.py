"""`esfem run`, `table` and `list`: studies computed, their tables shown, what there is for them."""

from pathlib import Path
from typing import Annotated

import typer

from esfem.cli.exit_statuses import exit_statuses
from esfem.cli.options import Checkpoint, Executor, Force, Jobs, Out, Scheduler
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
    with exit_statuses(out):
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


def list_() -> None:
    """List the studies, solutions, laws, claims and meshes there are.

    Example: `esfem list`
    """
    console = plain_console()
    for title, entries in overview().items():
        console.print(title, style="bold")
        width = max([20, *map(len, entries)])
        for name, text in entries.items():
            console.print(f"  {name:{width}} {text}", soft_wrap=True)


def overview() -> dict[str, dict[str, str]]:
    """What there is by the title of its list: names, and what they mean."""
    from esfem.meshes import MESH_SURFACES, committed_sizes
    from esfem.reference_solutions import STARTS
    from esfem.reference_solutions.surfaces import surface_names, surface_title
    from esfem.schemes import ALL_LAWS, named_scheme, scheme_names
    from esfem.studies.case import law_statement
    from esfem.studies.catalogue import study_sets
    from esfem.studies.claims import claims
    from esfem.studies.study import load_study

    sizes = {name: committed_sizes(name) for name in (*MESH_SURFACES, *surface_names())}
    return {
        **{
            title: {path.stem: load_study(path).study.title for path in paths}
            for title, paths in study_sets().items()
        },
        "solutions": {name: s.title for name, s in STARTS.items()},
        "surfaces (of solution surface)": {name: surface_title(name) for name in surface_names()},
        "laws": {name: law_statement(name) for name in ALL_LAWS},
        "schemes": {name: named_scheme(name).title for name in scheme_names()},
        "claims": {name: claim.statement for name, claim in claims().items()},
        "meshes": {name: "V = " + ", ".join(map(str, of)) for name, of in sizes.items() if of},
    }
