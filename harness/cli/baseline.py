"""`esfem check` and `esfem baseline`: results against what is committed."""

from pathlib import Path
from typing import Annotated

import typer

from esfem.cli.exit_statuses import exit_statuses
from esfem.cli.options import Jobs, Out
from esfem.common.bad_input import BadInput
from esfem.common.console import plain_console
from esfem.common.defaults import DEFAULT_OUT

Baseline = Annotated[Path, typer.Option(help="Folder of the baselines.")]
BASELINE = Path("results/baseline")


def check(
    studies: Annotated[
        list[str] | None,
        typer.Argument(metavar="STUDY ...", help="Names or files; all with a baseline if none."),
    ] = None,
    *,
    baseline: Baseline = BASELINE,
    out: Out = DEFAULT_OUT,
    read: Annotated[bool, typer.Option("--read", help="Run nothing: read what is stored.")] = False,
    junit: Annotated[Path | None, typer.Option(help="Write JUnit XML there.")] = None,
    jobs: Jobs,
    strict: Annotated[bool, typer.Option("--strict", help="Fail if better, too.")] = False,
) -> None:
    """Run studies and compare verdicts, orders and errors with the committed baseline.

    Exit status: 0 nothing is worse, 1 something is, 3 something cannot be compared.

    Example: `esfem check clifford --junit check.xml`
    """
    from esfem.campaigns.baseline.check import run_check

    with exit_statuses(out):
        status = run_check(
            studies or [],
            plain_console(),
            baseline=baseline,
            out=out,
            junit=junit,
            read=read,
            jobs=jobs,
            strict=strict,
        )
    raise typer.Exit(status)


def baseline(
    studies: Annotated[
        list[str] | None, typer.Argument(metavar="STUDY ...", help="Studies to move.")
    ] = None,
    move: Annotated[
        bool, typer.Option("--update", help="Make their results in OUT the baseline.")
    ] = False,
    why: Annotated[str, typer.Option(help="The reason, which is recorded.")] = "",
    out: Out = DEFAULT_OUT,
    baseline: Baseline = BASELINE,
) -> None:
    """List the baselines and why they moved, or move some.

    Example: `esfem baseline --update clifford --why "quadrature exact to two degrees more"`
    """
    from esfem.campaigns.baseline.baseline import show_baselines, update

    if move:
        update(studies or [], why, out, baseline, plain_console())
    elif studies or why:
        raise BadInput("baseline: without --update it lists all, and takes no STUDY and no --why")
    else:
        show_baselines(baseline, plain_console())
