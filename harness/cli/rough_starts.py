"""`esfem rough-starts`: the order in time where the first moments of a flow are fast."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.options import Jobs
from harness.cli.stops import stops
from harness.console import plain_console


def rough_starts(
    *,
    out: Annotated[Path, typer.Option(help="Where the tables are written.")] = Path(
        "results/rough-starts"
    ),
    jobs: Jobs,
) -> None:
    """Measure the order in tau at a rough start, with and without divided first steps.

    Example: `esfem rough-starts --jobs 2`
    """
    from harness.rough_starts.report import run_rough_starts

    with stops(out, resumes=False):
        run_rough_starts(out, jobs, plain_console(stderr=True))
