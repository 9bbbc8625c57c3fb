"""Two folders of results side by side.

The arithmetic and its tolerances are those of `campaigns.baseline`; here nothing is judged: orders
with their intervals, the fitted error in the middle of the window, the errors and the seconds at
equal (V, tau).
"""

from collections.abc import Callable
from math import isnan
from pathlib import Path

import numpy as np
import pandas as pd
from rich.console import Console
from rich.text import Text

from esfem.campaigns.baseline.baseline import names_below, read_stored
from esfem.campaigns.baseline.change import Change, Stored
from esfem.campaigns.baseline.compare import CELL, comparisons, other_options, said_of
from esfem.common.bad_input import BadInput
from esfem.common.console import print_table
from esfem.common.files import write_text, writing
from esfem.results.error_verdicts import ErrorVerdict

Pair = tuple[Stored, Stored]

LEGEND = (
    "fit: the fitted error in the middle of the judged window of 1; errors: factor 2 / 1 between "
    "the errors at equal (V, tau), geometric mean; largest: the one farthest from 1; effect: "
    "whether the mean leaves the tolerance of `esfem check`"
)
COLUMNS = [
    *("study", "variable", "verdict 1", "verdict 2", "order 1", "order 2"),
    *("fitted error 1", "fitted error 2", "errors", "largest", "effect"),
]
PLACES = {"fitted error 1": "fitted at", "largest": "largest at"}  # columns of where those are
FORMATS: dict[str, Callable[[pd.DataFrame], str]] = {
    ".md": lambda frame: frame.to_markdown(index=False, disable_numparse=True) + "\n",
    ".csv": lambda frame: frame.to_csv(index=False),
    ".html": lambda frame: frame.to_html(index=False, border=0),
}


def compare_folders(first: Path, second: Path, out: Path | None, console: Console) -> None:
    """Print the comparison, and write it to ``out``.

    Raises
    ------
    BadInput
        If a folder holds no results or damaged ones, or ``out`` has another ending than .md, .csv
        or .html, or cannot be written.
    """
    if out is not None and out.suffix.lower() not in FORMATS:
        raise BadInput(f"--out {out}: the ending must be one of {', '.join(FORMATS)}")
    names = [_names(folder) for folder in (first, second)]
    common = [name for name in names[0] if name in names[1]]
    pairs = [(read_stored(first / name), read_stored(second / name)) for name in common]
    table = variables_table(pairs)
    console.print(f"1: {first}\n2: {second}", soft_wrap=True)
    for times in studies_table(pairs):
        narrow = _narrow(table[table["study"] == times["study"]])
        console.print()
        console.print(Text(times["study"], style="bold"), _said(times), sep=": ", soft_wrap=True)
        print_table(narrow.to_numpy(str).tolist(), console, list(narrow.columns))
    if pairs:
        console.print()
        console.print(LEGEND, style="dim", soft_wrap=True)
    alone = [
        f"in {folder} only: {', '.join(name for name in own if name not in common)}"
        for folder, own in zip((first, second), names, strict=True)
        if set(own) - set(common)
    ]
    for line in [*_remarks(pairs), *alone]:
        console.print(line, soft_wrap=True)
    if out is not None:
        with writing(f"--out {out}"):
            write_text(out, FORMATS[out.suffix.lower()](_wide(table)))
        console.print(f"written to {out}", soft_wrap=True)


def _names(folder: Path) -> list[str]:
    """The studies of a folder; BadInput if there are none."""
    found = names_below(folder)
    if not found:
        raise BadInput(f"{folder}: holds no results (no STUDY/verdicts.json there)")
    return found


def variables_table(pairs: list[Pair]) -> pd.DataFrame:
    """A row a study and variable that both have: verdicts, orders, fitted errors, factors.

    Factors are 2 / 1; "errors" is their geometric mean over equal (V, tau), and "largest" the one
    that is farthest from 1; "fitted at" and "largest at" are where.
    """
    rows = []
    for before, now in pairs:
        changes = {(c.variable, c.what): c for c in comparisons(before, now)}
        verdicts = {v.variable: v for v in now.content.verdicts}
        for verdict in before.content.verdicts:
            now_judged = verdicts.get(verdict.variable)
            others = {} if now_judged is None else {p.name: p for p in now_judged.parts}
            for part in verdict.parts:
                name = said_of(verdict, part)
                if part.name in others:
                    found = [changes.get((name, w)) for w in ("constant", "errors", "one error")]
                    row = {"study": before.study, "variable": name}
                    rows.append(row | _verdicts(part, others[part.name]) | _factors(*found))
    return pd.DataFrame(rows, columns=[*COLUMNS, *PLACES.values()])


def _verdicts(before: ErrorVerdict, now: ErrorVerdict) -> dict[str, str]:
    row = {}
    for side, fit in (("1", before), ("2", now)):
        order = f"{fit.observed:.2f} [{fit.lower:.2f}, {fit.upper:.2f}]"
        row[f"verdict {side}"] = fit.outcome.upper()
        row[f"order {side}"] = order if np.isfinite(fit.observed) else "-"
    return row


def _factors(constant: Change | None, errors: Change | None, one: Change | None) -> dict[str, str]:
    return {
        "fitted error 1": constant.baseline if constant else "-",
        "fitted error 2": constant.current if constant else "-",
        "fitted at": constant.place if constant else "",
        "errors": _factor(errors),
        "largest": _factor(one),
        "largest at": one.place if one else "",
        "effect": errors.effect if errors else "-",
    }


def _factor(change: Change | None) -> str:
    return "-" if change is None or isnan(change.by) else f"{change.by:.3g}"


def studies_table(pairs: list[Pair]) -> list[dict[str, str]]:
    """For each study: how many runs are equal in (V, tau), and their seconds."""
    rows = []
    for before, now in pairs:
        equal = before.records.merge(now.records, on=CELL, suffixes=("_1", "_2"))
        first, second = equal["seconds_1"].sum(), equal["seconds_2"].sum()
        row = {"study": before.study, "equal": str(len(equal))}
        row |= {"seconds 1": f"{first:.1f}", "seconds 2": f"{second:.1f}"}
        rows.append({**row, "ratio": f"{second / first:.2f}" if len(equal) else "-"})
    return rows


def _said(times: dict[str, str]) -> str:
    seconds = f"{times['seconds 1']} s -> {times['seconds 2']} s (times {times['ratio']})"
    return f"{times['equal']} runs equal in (V, tau), {seconds}"


def _remarks(pairs: list[Pair]) -> list[str]:
    """Different problems under one name, and runs that end otherwise."""
    lines = []
    for before, now in pairs:
        odd = other_options(before, now).items()
        if odd:
            said = ", ".join(f"{name} = {one} -> {two}" for name, (one, two) in odd)
            lines.append(f"{before.study}: not the same problem, {said}")
        runs = [c for c in comparisons(before, now) if c.what in ("run", "cell")]
        lines += [f"{before.study}: {change.said}" for change in runs]
    return lines


def _narrow(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of one study for a terminal."""
    same = rows["verdict 1"] == rows["verdict 2"]
    verdicts = rows["verdict 1"].where(same, rows["verdict 1"] + " -> " + rows["verdict 2"])
    rows = rows.assign(verdict=verdicts)[["variable", "verdict", *COLUMNS[4:]]]
    return rows.rename(columns=lambda name: name.replace("fitted error", "fit"))


def _wide(table: pd.DataFrame) -> pd.DataFrame:
    """The rows for a file: what belongs to a place with it."""
    for column, place in PLACES.items():
        told = table[column] + " at " + table[place]
        table = table.assign(**{column: told.where(table[place] != "", table[column])})
    return table[COLUMNS]
