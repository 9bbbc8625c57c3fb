"""The commands ``esfem check`` and ``esfem baseline``, for `harness.cli`."""

from pathlib import Path
from typing import Annotated

import typer

from harness.api import DEFAULT_OUT
from harness.bad_input import BadInput
from harness.printing import plain_console
from harness.regression.baseline import show_baselines, update
from harness.regression.check import run_check

BASELINE = Path("results/baseline")


def check(
    studies: Annotated[
        list[str] | None,
        typer.Argument(metavar="STUDY ...", help="Names or files; all with a baseline if none."),
    ] = None,
    baseline: Annotated[Path, typer.Option(help="Folder of the baselines.")] = BASELINE,
    out: Annotated[Path, typer.Option(help="Results are in OUT/STUDY.")] = DEFAULT_OUT,
    read: Annotated[bool, typer.Option("--read", help="Run nothing: read what is stored.")] = False,
    junit: Annotated[Path | None, typer.Option(help="Write JUnit XML there.")] = None,
    jobs: Annotated[
        int | None, typer.Option(help="Number of processes; by default all cores.")
    ] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Fail if better, too.")] = False,
) -> None:
    """Run studies and compare verdicts, orders and errors with the committed baseline.

    Exit status: 0 nothing is worse, 1 something is, 3 something cannot be compared.

    Example: `esfem check clifford --junit check.xml`
    """
    where = {"baseline": baseline, "out": out, "junit": junit}
    raise typer.Exit(run_check(studies or [], **where, read=read, jobs=jobs, strict=strict))


def baseline(
    studies: Annotated[
        list[str] | None, typer.Argument(metavar="STUDY ...", help="Studies to move.")
    ] = None,
    move: Annotated[
        bool, typer.Option("--update", help="Make their results in OUT the baseline.")
    ] = False,
    why: Annotated[str, typer.Option(help="The reason, which is recorded.")] = "",
    out: Annotated[Path, typer.Option(help="Results are in OUT/STUDY.")] = DEFAULT_OUT,
    baseline: Annotated[Path, typer.Option(help="Folder of the baselines.")] = BASELINE,
) -> None:
    """List the baselines and why they moved, or move some.

    Example: `esfem baseline --update clifford --why "quadrature exact to two degrees more"`
    """
    if move:
        update(studies or [], why, out, baseline, plain_console())
    elif studies or why:
        raise BadInput("baseline: without --update it lists all, and takes no STUDY and no --why")
    else:
        show_baselines(baseline, plain_console())
