"""`esfem paper`: all experiments of the paper, their figures, and its sentences, checked."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.options import Jobs
from harness.cli.stops import stops
from harness.console import plain_console


def paper(
    *,
    out: Annotated[Path, typer.Option(help="Tables, figures and sentences go there.")] = Path(
        "results/paper"
    ),
    runs: Annotated[Path, typer.Option(help="Records and checkpoints go there.")] = Path(
        "results/runs/paper"
    ),
    jobs: Jobs,
    only: Annotated[
        list[str] | None,
        typer.Option(
            help="Run this study, long ones too, this flow or the ablation alone; may be repeated."
        ),
    ] = None,
    studies: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Other study files, flow files in its flows/, long studies in its long/.",
        ),
    ] = None,
    long: Annotated[
        bool, typer.Option("--long", help="Also the studies with runs of more than five minutes.")
    ] = False,
) -> None:
    """Reproduce section 7 of the paper: figures, tables, and each quantitative sentence checked.

    Exit status: 0 every sentence that was checked holds, 1 one does not, 3 inconclusive. With
    `--only`, sentences about other studies do not count.

    Example: `esfem paper --only paper-sphere --only ellipsoid --jobs 2`
    """
    from harness.paper.plan import committed_plan, plan_in
    from harness.paper.run import run_paper

    every = long or bool(only)  # who names a long study has asked for it
    whole = committed_plan(every) if studies is None else plan_in(studies, every)
    plan = whole.only(only) if only else whole
    with stops(runs):
        status = run_paper(plan, out, runs, jobs, plain_console())
    raise typer.Exit(status)
