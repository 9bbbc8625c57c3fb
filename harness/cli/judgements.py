"""A CSV file of errors, judged, printed and written: what `esfem judge` does."""

from pathlib import Path

import numpy as np
import pandas as pd
from rich.console import Console

from esfem.common.bad_input import BadInput
from esfem.common.console import print_table
from esfem.common.files import reading, write_json, writing
from esfem.judging.judge import judge_table
from esfem.judging.judgement import EXIT, Judgement, worst
from esfem.judging.validate import Direction

DIRECTIONS = ("h", "tau")
HEADINGS = ("", "verdict", "order", "95 % interval", "window", "scatter", "model")


def judge_file(
    path: Path,
    order: float,
    direction: str,
    variable: str | None,
    tolerance: float,
    out: Path | None,
    console: Console,
) -> int:
    """Judge each variable of the file, print the verdicts, write them to ``out``: exit status.

    Raises
    ------
    BadInput
        If an argument or the file is not what it must be.
    """
    for name, value in (("--order", order), ("--tolerance", tolerance)):
        if not (np.isfinite(value) and value > 0):
            raise BadInput(f"{name} {value:g}: must be positive and finite")
    if direction not in DIRECTIONS:
        raise BadInput(f"--direction {direction}: must be one of {', '.join(DIRECTIONS)}")
    judgements = {}
    for name, table in _tables(path, variable).items():
        try:
            judgements[name] = judge_table(table, order, direction=direction, tolerance=tolerance)
        except BadInput as error:
            of = f", variable {name}" if name else ""
            raise BadInput(f"{path}{of}: {error}") from error
    show_judgements(str(path), judgements, order, direction, tolerance, console)
    if out is not None:
        _write(path, judgements, order, direction, tolerance, out)
    return EXIT[worst(list(judgements.values()))]


def _tables(path: Path, variable: str | None) -> dict[str, pd.DataFrame]:
    """The table of each variable; of "" if the file has no such column."""
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
    judgements: dict[str, Judgement],
    order: float,
    direction: Direction,
    tolerance: float,
    console: Console,
) -> None:
    """Print the judge's table of each variable, with cause, next run and masked runs."""
    console.print(f"{title}: order {order:g} - {tolerance:g} in {direction}", soft_wrap=True)
    rows = [(name, j.outcome.upper(), *_numbers(j)) for name, j in judgements.items()]
    print_table(rows, console, HEADINGS)
    for name, j in judgements.items():
        for line in _remarks(j):
            console.print(f"{name}: {line}" if name else line, soft_wrap=True)


def _numbers(j: Judgement) -> tuple[str, ...]:
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


def _remarks(j: Judgement) -> list[str]:
    """Cause, next run, joint fit and masked runs, a line each."""
    lines = [f"cause: {j.cause}"] if j.cause else []
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
        where = f"h = {masked.h:.3g}" + ("" if np.isnan(masked.tau) else f", tau = {masked.tau:g}")
        lines.append(f"masked: {where}: {masked.reason}")
    return lines


def _write(
    path: Path,
    judgements: dict[str, Judgement],
    order: float,
    direction: Direction,
    tolerance: float,
    out: Path,
) -> None:
    from esfem.common.provenance import command, machine, version

    content = {
        "version": version(),
        "command": command(),
        "machine": machine(),
        "file": str(path),
        "order": order,
        "direction": direction,
        "tolerance": tolerance,
        "outcome": worst(list(judgements.values())),
        "judgements": judgements,
    }
    with writing(f"--json {out}"):
        write_json(out, content)
