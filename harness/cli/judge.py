"""`esfem judge`: anybody's table of errors."""

from pathlib import Path
from typing import Annotated

import typer

from esfem.common.console import plain_console


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
    from esfem.cli.judgements import judge_file

    status = judge_file(file, order, direction, variable, tolerance, json, plain_console())
    raise typer.Exit(status)
