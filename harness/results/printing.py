"""Results of studies, printed: rate tables, verdicts, remarks; all of it plain text to rich."""

import pandas as pd
from rich.console import Console
from rich.text import Text

from esfem.common.console import STYLES, print_table
from esfem.results.remarks import remarks
from esfem.results.study_result import StudyResult
from esfem.results.tables import verdict_table
from esfem.studies.claims import Direction
from esfem.studies.quantities import NODAL, QUANTITIES


def show(result: StudyResult, console: Console) -> None:
    """Print the rate table at the judged tau, the verdicts, and what was not judged."""
    study, label = result.study, result.shown
    errors, nodal = result.tables[label]
    console.print()
    console.rule(Text(study.title, style="bold"), align="left")
    console.print(result.words.case)
    console.print(f"errors and EOC in {study.direction} at {label}; {result.words.errors}")
    _print(_transposed(errors, study.direction, result.headings), console)
    if nodal is not None:
        console.print(f"the same against the interpolation: {NODAL}")
        _print(_transposed(nodal, study.direction, result.headings), console)
    _print(verdict_table(result.verdicts), console)
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


def _print(frame: pd.DataFrame, console: Console) -> None:
    texts = ("verdict", "claim", "expected")
    right = [i for i, name in enumerate(frame.columns) if name not in texts]
    print_table(frame.to_numpy(str).tolist(), console, list(frame.columns), right)
