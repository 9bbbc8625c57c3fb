"""`esfem report` and `esfem compare`: folders of results, as a page or side by side."""

from pathlib import Path
from typing import Annotated

import typer

from esfem.common.console import plain_console


def report(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of results, as results/runs.")
    ],
    out: Annotated[
        Path | None, typer.Option(help="Where it is written; DIR/report if not given.")
    ] = None,
) -> None:
    """Write the report of a folder of results: HTML, LaTeX, data for pgfplots.

    Example: `esfem report results/runs`
    """
    from esfem.report.write import write_report

    console = plain_console()
    written = write_report(folder, folder / "report" if out is None else out, console.print)
    console.print(f"report: {written}", soft_wrap=True)


def compare(
    first: Annotated[Path, typer.Argument(metavar="DIR1", help="Folder of results.")],
    second: Annotated[Path, typer.Argument(metavar="DIR2", help="Folder of other results.")],
    out: Annotated[
        Path | None, typer.Option(help="Write the tables there: .md, .csv or .html.")
    ] = None,
) -> None:
    """Compare two folders of results: orders, fitted errors, errors at equal (V, tau), seconds.

    Example: `esfem compare results/baseline results/runs --out comparison.md`
    """
    from esfem.campaigns.baseline.folders import compare_folders

    compare_folders(first, second, out, plain_console())
