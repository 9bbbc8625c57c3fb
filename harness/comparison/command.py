"""The command ``esfem schemes``, for `harness.cli`."""

from pathlib import Path
from typing import Annotated

import typer

from harness.api import DEFAULT_OUT, run_studies
from harness.catalogue import scheme_studies
from harness.printing import plain_console, show
from harness.stops import stops


def schemes(
    out: Annotated[Path, typer.Option(help="Where OUT/extra is written.")] = DEFAULT_OUT,
    studies: Annotated[
        bool, typer.Option("--studies", help="Run the studies harness/studies/schemes first.")
    ] = False,
    only: Annotated[
        str | None, typer.Option(help="One part: cost, comparison, orders or course.")
    ] = None,
) -> None:
    """Compare the schemes: errors, drifts, largest stable tau, mesh quality, seconds per step.

    Example: `esfem schemes --out results/runs`
    """
    from harness.comparison.extras import compare_schemes  # matplotlib is slow to load

    console = plain_console()
    if studies:
        with stops(out):
            for result in run_studies(scheme_studies(), out, console=console):
                show(result, console)
    compare_schemes(out, console, only)
