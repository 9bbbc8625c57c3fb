"""`esfem judge`: anybody's table of errors, judged, printed, and written."""

from math import isfinite, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from esfem.common.bad_input import BadInput
from esfem.common.console import plain_console, print_table
from esfem.common.files import reading, write_json, writing

if TYPE_CHECKING:  # slow to load
    import pandas as pd
    from rich.console import Console

    from esfem.judging import Judgement
    from esfem.judging.validate import Direction

DIRECTIONS: tuple[Literal["h", "tau"], ...] = ("h", "tau")
HEADINGS = ("", "verdict", "order", "95 % interval", "window", "scatter", "model")


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
    from esfem.common.provenance import command, machine, version
    from esfem.judging import judge_table, worst
    from esfem.judging.judgement import EXIT

    for name, value in (("--order", order), ("--tolerance", tolerance)):
        if not (isfinite(value) and value > 0):
            raise BadInput(f"{name} {value:g}: must be positive and finite")
    if direction not in DIRECTIONS:
        raise BadInput(f"--direction {direction}: must be one of {', '.join(DIRECTIONS)}")
    judgements = {}
    for name, table in _tables(file, variable).items():
        try:
            judgements[name] = judge_table(table, order, direction=direction, tolerance=tolerance)
        except BadInput as error:
            of = f", variable {name}" if name else ""
            raise BadInput(f"{file}{of}: {error}") from error
    show_judgements(str(file), judgements, order, direction, tolerance, plain_console())
    outcome = worst(list(judgements.values()))
    if json is not None:
        content = {
            "version": version(),
            "command": command(),
            "machine": machine(),
            "file": str(file),
            "order": order,
            "direction": direction,
            "tolerance": tolerance,
            "outcome": outcome,
            "judgements": judgements,
        }
        with writing(f"--json {json}"):
            write_json(json, content)
    raise typer.Exit(EXIT[outcome])


def _tables(path: Path, variable: str | None) -> dict[str, "pd.DataFrame"]:
    """The table of each variable; of "" if the file has no such column."""
    import pandas as pd

    with reading(path):
        table = pd.read_csv(path, skipinitialspace=True)
    if "variable" not in table:
        if variable is not None:
            raise BadInput(f"--variable {variable}: {path} has no column variable")
        return {"": table}
    if table.empty or table["variable"].isna().any():
        raise BadInput(f"{path}: column variable: has no rows, or rows without a name")
    tables = {str(name): rows for name, rows in table.groupby("variable", sort=False)}
    if variable is not None and variable not in tables:
        raise BadInput(f"--variable {variable}: {path} has {', '.join(tables)}")
    return tables if variable is None else {variable: tables[variable]}


def show_judgements(
    title: str,
    judgements: dict[str, "Judgement"],
    order: float,
    direction: "Direction",
    tolerance: float,
    console: "Console",
) -> None:
    """Print the judge's table of each variable, with cause, next run and masked runs."""
    console.print(f"{title}: order {order:g} - {tolerance:g} in {direction}", soft_wrap=True)
    rows = [(name, j.outcome.upper(), *_numbers(j)) for name, j in judgements.items()]
    print_table(rows, console, HEADINGS)
    for name, j in judgements.items():
        for line in _remarks(j):
            console.print(f"{name}: {line}" if name else line, soft_wrap=True)


def _numbers(j: "Judgement") -> tuple[str, ...]:
    if not j.window:
        return ("-",) * 5
    ends = f"{j.window[0]:.3g}..{j.window[-1]:.3g}"
    return (
        f"{j.order:.2f}",
        f"[{j.lower:.2f}, {j.upper:.2f}]",
        f"{len(j.window)} of {j.levels}, {ends}",
        f"{100 * j.scatter:.1f} %",
        j.model,
    )


def _remarks(j: "Judgement") -> list[str]:
    """Cause, next run, joint fit and masked runs, a line each."""
    lines = [j.certainty] if j.certainty else []
    lines += j.notes
    lines += [f"cause: {j.cause}"] if j.cause else []
    lines += [f"next run: {j.next_run}"] if j.next_run else []
    if j.joint is not None:
        other = "tau" if j.direction == "h" else "h"
        given = " (given)" if j.joint.q_given else ""
        lines.append(
            f"joint fit: {j.joint.A:.3g} {j.direction}^{j.joint.p:.2f} + "
            f"{j.joint.B:.3g} {other}^{j.joint.q:.2f}{given}, "
            f"scatter {100 * j.joint.scatter:.1f} %"
        )
    for masked in j.masked:
        where = f"h = {masked.h:.3g}" + ("" if isnan(masked.tau) else f", tau = {masked.tau:g}")
        lines.append(f"masked: {where}: {masked.reason}")
    return lines
