"""`esfem schemes`: the schemes of the paper's section 2.3 beside each other."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.options import Jobs
from harness.cli.stops import stops
from harness.comparison import PARTS
from harness.console import plain_console


def schemes(
    *,
    out: Annotated[Path, typer.Option(help="Tables, figures and the report go there.")] = Path(
        "results/schemes"
    ),
    runs: Annotated[Path, typer.Option(help="Records of the studies go there.")] = Path(
        "results/runs/schemes"
    ),
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="PART", help=f"Among {', '.join(PARTS)}; may be repeated."),
    ] = None,
    scheme: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="A scheme that takes part too; may be repeated."),
    ] = None,
    jobs: Jobs,
) -> None:
    """Compare the schemes: studies, errors, drifts, largest stable tau, mesh quality, seconds.

    Interrupted, studies go on from their records; each other part is repeated as a whole. Exit
    status: that of the studies, as for `esfem run`; dziuk and bgn claim nothing.

    Example: `esfem schemes --only comparison --only orders --scheme my-scheme`
    """
    from harness.comparison.run import run_contest
    from harness.verdict import exit_status, worst

    with stops(runs):
        results = run_contest(only or PARTS, out, runs, jobs, plain_console(), scheme or ())
    raise typer.Exit(exit_status(worst(result.verdicts) for result in results))
