"""What the command line prints: rate tables, verdicts, lists; all of it plain text to rich."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd
from rich.console import Console
from rich.table import Table
from rich.text import Text

from harness.case import ALL_LAWS, law_statement
from harness.claims import Direction, claims
from harness.meshing import MESH_SURFACES, committed_sizes
from harness.quantities import NODAL, QUANTITIES
from harness.remarks import remarks
from harness.schemes import named_scheme, scheme_names
from harness.study import load_study
from harness.study_result import StudyResult
from harness.tables import verdict_table
from reference_solutions import STARTS
from reference_solutions.surfaces import surface_names, surface_title

STYLES = {
    **dict.fromkeys(("PASS", "SUPER"), "green"),
    **dict.fromkeys(("FAIL", "SUSPECT"), "bold red"),
    "INCONCLUSIVE": "yellow",
}


def plain_console(stderr: bool = False) -> Console:
    """A console that shows titles and paths as they are: "[b]" and ":x:" mean nothing to it."""
    return Console(stderr=stderr, markup=False, emoji=False, highlight=False)


def show(result: StudyResult, console: Console) -> None:
    """Print the rate table at the judged tau, the verdicts, and what was not judged."""
    study, label = result.study, result.shown
    errors, nodal = result.tables[label]
    console.print()
    console.rule(Text(study.title, style="bold"), align="left")
    console.print(result.words.case)
    console.print(f"errors and EOC in {study.direction} at {label}; {result.words.errors}")
    console.print(_as_rich(_transposed(errors, study.direction, result.headings)))
    if nodal is not None:
        console.print(f"the same against the interpolation: {NODAL}")
        console.print(_as_rich(_transposed(nodal, study.direction, result.headings)))
    console.print(_as_rich(verdict_table(result.verdicts)))
    for line in remarks(result):
        console.print(line, style="dim", soft_wrap=True)
    console.print(f"files: {result.folder}", soft_wrap=True)


def summary(results: list[StudyResult], console: Console) -> None:
    """Print one line a study: the verdict that decides the exit status, and which runs it judges.

    For example "PASS  sphere: 3 pass, 3 no claim (judged at tau = 0.0125, V = 120..960)".
    """
    console.rule(Text("verdicts", style="bold"), align="left")
    for result in results:
        outcome = result.outcome.upper()
        counts = pd.Series([v.verdict for v in result.verdicts]).value_counts()
        detail = ", ".join(f"{count} {name}" for name, count in counts.items())
        line = Text.assemble(
            (f"{outcome:13}", STYLES.get(outcome, "")),
            f" {result.study.name}: {detail} ({_judged(result)})",
        )
        console.print(line, soft_wrap=True)


def overview(studies: Mapping[str, Sequence[Path]], console: Console) -> None:
    """Print the studies, by a title of their set, solutions, laws, claims and meshes there are."""
    meshes = {
        name: "V = " + ", ".join(map(str, committed_sizes(name)))
        for name in (*MESH_SURFACES, *surface_names())
        if committed_sizes(name)
    }
    lists = {
        **{
            title: {path.stem: load_study(path).title for path in paths}
            for title, paths in studies.items()
        },
        "solutions": {name: s.title for name, s in STARTS.items()},
        "surfaces (of solution surface)": {name: surface_title(name) for name in surface_names()},
        "laws": {name: law_statement(name) for name in ALL_LAWS},
        "schemes": {name: named_scheme(name).title for name in scheme_names()},
        "claims": {name: claim.statement for name, claim in claims().items()},
        "meshes": meshes,
    }
    for title, entries in lists.items():
        console.print(title, style="bold")
        width = max([20, *map(len, entries)])
        for name, text in entries.items():
            console.print(f"  {name:{width}} {text}", soft_wrap=True)


def _judged(result: StudyResult) -> str:
    """The time steps and meshes over which any variable was judged."""
    taus = sorted({tau for v in result.verdicts for tau in v.tau}, reverse=True)
    sizes = sorted({vertices for v in result.verdicts for vertices in v.vertices})
    if not taus:
        return "no run judged"
    ends = [
        "..".join(f"{value:g}" for value in dict.fromkeys((values[0], values[-1])))
        for values in (taus, sizes)
    ]
    return f"judged at tau = {ends[0]}, V = {ends[1]}"


def _transposed(table: pd.DataFrame, parameter: Direction, names: dict[str, str]) -> pd.DataFrame:
    """Variables down, levels across, "error EOC" in each entry: fits a terminal of 80 columns."""
    variables = [name for name in names if name in table]
    measured = [value for name in variables if (value := QUANTITIES[name].value) in table]
    heading = {"h": "V={vertices}", "tau": "n={steps}"}[parameter]
    columns = {"": [parameter, *measured, *(names[name] for name in variables)]}
    for level in table.to_dict("records"):
        entries = [f"{_short(level[name])} {level[f'EOC {name}']}".strip() for name in variables]
        values = [level[name] for name in measured]
        columns[heading.format(**level)] = [level[parameter], *values, *entries]
    return pd.DataFrame(columns)


def _short(number: str) -> str:
    return (
        number
        if number == "-"
        else f"{float(number):.1e}".replace("e-0", "e-").replace("e+0", "e+")
    )


def _as_rich(frame: pd.DataFrame) -> Table:
    grid = Table(box=None, padding=(0, 1), pad_edge=False)
    for column in frame.columns:
        text = column in ("verdict", "claim", "expected")
        grid.add_column(column, justify="left" if text else "right", no_wrap=True)
    for row in frame.to_numpy(str):
        grid.add_row(*(Text(entry, style=STYLES.get(entry, "")) for entry in row))
    return grid
