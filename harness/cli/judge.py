"""`esfem judge`: anybody's table of errors; `esfem judge-report`: the judge itself, judged."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.options import Jobs
from harness.cli.stops import stops
from harness.console import plain_console


def judge(
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
    from harness.cli.judgements import judge_file

    status = judge_file(file, order, direction, variable, tolerance, json, plain_console())
    raise typer.Exit(status)


def judge_report(
    *,
    out: Annotated[Path, typer.Option(help="Where the report is written.")] = Path("results/judge"),
    jobs: Jobs,
) -> None:
    """Judge tables of known order, and count how often the judge and the usual rules err.

    Example: `esfem judge-report --out results/judge`
    """
    from harness.judging.report import run_simulation

    with stops(out, resumes=False):
        run_simulation(out, jobs, plain_console(stderr=True))
