"""Two folders of results side by side.

The arithmetic and its tolerances are those of `campaigns.baseline`; here nothing is judged: orders
with their intervals, the fitted error in the middle of the window, the errors and the seconds at
equal (V, tau).
"""

from math import isnan
from pathlib import Path

import numpy as np
import pandas as pd
from rich.console import Console
from rich.text import Text

from esfem.campaigns.baseline.change import Change, Stored
from esfem.campaigns.baseline.compare import CELL, comparisons, other_options
from esfem.campaigns.baseline.stored import names_below, read_stored
from esfem.common.bad_input import BadInput
from esfem.common.console import print_table
from esfem.common.files import write_text, writing
from esfem.results.verdicts import Verdict

LEGEND = (
    "fit: the fitted error in the middle of the judged window of 1; errors: factor 2 / 1 between "
    "the errors at equal (V, tau), geometric mean; largest: the one farthest from 1; effect: "
    "whether the mean leaves the tolerance of `esfem check`"
)
COLUMNS = (
    *("study", "variable", "verdict 1", "verdict 2", "order 1", "order 2"),
    *("fitted error 1", "fitted error 2", "errors", "largest", "effect"),
)
FORMATS = {
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
    by_variable = variables_table(pairs)
    console.print(f"1: {first}\n2: {second}", soft_wrap=True)
    for times in studies_table(pairs):
        rows = by_variable[by_variable["study"] == times["study"]]
        console.print()
        console.print(Text(times["study"], style="bold"), _said(times), sep=": ", soft_wrap=True)
        narrow = _narrow(rows)
        print_table(narrow.to_numpy(str).tolist(), console, list(narrow.columns))
    if pairs:
        console.print()
        console.print(LEGEND, style="dim", soft_wrap=True)
    for line in _remarks(pairs, first, second, names):
        console.print(line, soft_wrap=True)
    if out is not None:
        _write(by_variable, out, console)


def _names(folder: Path) -> list[str]:
    """The studies of a folder; BadInput if there are none."""
    found = names_below(folder)
    if not found:
        raise BadInput(f"{folder}: holds no results (no STUDY/verdicts.json there)")
    return found


def variables_table(pairs: list[tuple[Stored, Stored]]) -> pd.DataFrame:
    """A row a study and variable that both have: verdicts, orders, fitted errors, factors.

    Factors are 2 / 1; "errors" is their geometric mean over equal (V, tau), and "largest" the one
    that is farthest from 1, with its cell.
    """
    rows = []
    for before, now in pairs:
        changes = {(c.variable, c.what): c for c in comparisons(before, now)}
        verdicts = {v.variable: v for v in now.content.verdicts}
        for verdict in before.content.verdicts:
            name = verdict.variable
            if name in verdicts:
                rows.append(_row(before.study, verdict, verdicts[name], changes))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _row(
    study: str, before: Verdict, now: Verdict, changes: dict[tuple[str, str], Change]
) -> dict[str, str]:
    name = before.variable
    found = {what: changes.get((name, what)) for what in ("constant", "errors", "one error")}
    constant, one = found["constant"], found["one error"]
    return {
        "study": study,
        "variable": name,
        "verdict 1": before.verdict.upper(),
        "verdict 2": now.verdict.upper(),
        "order 1": _order(before),
        "order 2": _order(now),
        "fitted error 1": "-" if constant is None else constant.baseline,
        "fitted error 2": "-" if constant is None else constant.current.partition(" at ")[0],
        "errors": _factor(found["errors"]),
        "largest": "-" if one is None else f"{_factor(one)} at {one.baseline.partition(':')[0]}",
        "effect": "-" if found["errors"] is None else found["errors"].effect,
    }


def _order(fit: Verdict) -> str:
    if not np.isfinite(fit.observed):
        return "-"
    return f"{fit.observed:.2f} [{fit.lower:.2f}, {fit.upper:.2f}]"


def _factor(change: Change | None) -> str:
    return "-" if change is None or isnan(change.by) else f"{change.by:.3g}"


def studies_table(pairs: list[tuple[Stored, Stored]]) -> list[dict[str, str]]:
    """For each study: how many runs are equal in (V, tau), and their seconds."""
    rows = []
    for before, now in pairs:
        equal = before.records.merge(now.records, on=CELL, suffixes=("_1", "_2"))
        first, second = equal["seconds_1"].sum(), equal["seconds_2"].sum()
        row = {"study": before.study, "equal": str(len(equal))}
        row |= {"seconds 1": f"{first:.1f}", "seconds 2": f"{second:.1f}"}
        rows.append({**row, "ratio": f"{second / first:.2f}" if len(equal) else "-"})
    return rows


def _remarks(
    pairs: list[tuple[Stored, Stored]], first: Path, second: Path, names: list[list[str]]
) -> list[str]:
    """Different problems under one name, runs that end otherwise, and studies that one lacks."""
    lines = []
    for before, now in pairs:
        odd = other_options(before, now).items()
        said = ", ".join(f"{name} = {one} -> {two}" for name, (one, two) in odd)
        if odd:
            lines.append(f"{before.study}: not the same problem, {said}")
        runs = [c for c in comparisons(before, now) if c.what in ("run", "cell")]
        lines += [f"{before.study}: {c.baseline} -> {c.current}" for c in runs]
    for folder, own, other in ((first, *names), (second, *reversed(names))):
        alone = [name for name in own if name not in other]
        if alone:
            lines.append(f"in {folder} only: {', '.join(alone)}")
    return lines


def _said(times: dict[str, str]) -> str:
    seconds = f"{times['seconds 1']} s -> {times['seconds 2']} s (times {times['ratio']})"
    return f"{times['equal']} runs equal in (V, tau), {seconds}"


def _narrow(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of one study for a terminal."""
    same = rows["verdict 1"] == rows["verdict 2"]
    verdicts = rows["verdict 1"].where(same, rows["verdict 1"] + " -> " + rows["verdict 2"])
    names = ["order 1", "order 2", "fitted error 1", "fitted error 2", "errors", "largest"]
    narrow = rows[names].rename(columns=lambda name: name.replace("fitted error", "fit"))
    narrow["fit 1"] = narrow["fit 1"].str.partition(" at ")[0]
    narrow["largest"] = narrow["largest"].str.partition(" at ")[0]
    return pd.concat([rows["variable"], verdicts.rename("verdict"), narrow, rows["effect"]], axis=1)


def _write(frame: pd.DataFrame, out: Path, console: Console) -> None:
    with writing(f"--out {out}"):
        write_text(out, FORMATS[out.suffix.lower()](frame))
    console.print(f"written to {out}", soft_wrap=True)
