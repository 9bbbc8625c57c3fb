"""`esfem mutants`: are seeded bugs seen by the verdicts?"""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.options import Jobs
from harness.console import plain_console


def mutants(
    *,
    only: Annotated[
        list[str] | None, typer.Option(help="A mutant or a group of them; may be repeated.")
    ] = None,
    jobs: Jobs,
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
    from harness.mutation.run import run_mutants

    raise typer.Exit(run_mutants(only or (), jobs, every, resume, out, plain_console()))
