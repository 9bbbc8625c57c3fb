"""Tables of a study: rates.csv for programs, .md and the console for eyes, .tex for papers."""

from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console
from rich.text import Text

from esfem.common.console import STYLES, print_table
from esfem.common.provenance import provenance_line
from esfem.common.tex_text import escaped, one_line
from esfem.judging.eoc import fit_order, rates
from esfem.results.remarks import remarks
from esfem.results.selection import LEVELS
from esfem.results.study_result import StudyResult, series
from esfem.results.verdicts import Verdict
from esfem.studies.claims import Direction
from esfem.studies.quantities import NODAL, QUANTITIES

TAU = r"\tau"
RATES = (
    *("variable", "direction", "tau"),
    *("vertices_coarse", "h_coarse", "tau_coarse", "vertices_fine", "h_fine", "tau_fine"),
    *("error_coarse", "error_fine", "eoc"),
    *("fitted_order", "fitted_uncertainty", "fitted_levels"),
)
SYMBOLS = {"error": "u_h - u", "interpolation": "u_h - I_h u"}
AGAINST = {"u_h - u": "u", "u_h - I_h u": "I_h u"}
OF_VARIABLE = ("study", "variable", "direction", "claim", "expected", "tolerance", "limit")
OF_ERROR = (
    *("outcome", "observed", "lower", "upper", "probability", "constant", "scatter"),
    *("error", "model", "reason", "next_run", "norm"),
)
NODAL_TEX = r"$u_h - I_h u$ in $L^\infty(0,T; H^1(\Gamma_h^*))$"
TEX_HEADS = {"N": "$N$", "h": "$h$", "tau": f"${TAU}$"}


def rates_table(result: StudyResult) -> pd.DataFrame:
    """rates.csv: a line a variable, direction and pair of levels, with signed EOC and fitted order.

    Direction "h": consecutive meshes at one tau; direction "tau": consecutive time steps on one
    mesh.  ``fitted_order`` is the slope over the finest completed levels (at most `LEVELS`).
    """
    lines: list[dict[str, Any]] = []
    for parameter in ("h", "tau"):
        for _, runs in series(result.records, parameter):
            for name in result.study.variables:
                lines += _pairs(runs, parameter, name)
    return pd.DataFrame(lines, columns=list(RATES))


def _pairs(runs: pd.DataFrame, parameter: Direction, name: str) -> list[dict[str, Any]]:
    s, e = runs[parameter].to_numpy(), runs[f"err_{name}"].to_numpy(float)
    usable = np.isfinite(e) & (e > 0)
    fit = fit_order(s[usable][-LEVELS:], e[usable][-LEVELS:]) if usable.sum() >= 2 else None
    coarse, fine = runs.iloc[:-1].to_dict("records"), runs.iloc[1:].to_dict("records")
    return [
        {
            "variable": name,
            "direction": parameter,
            "tau": b["tau"],
            **{f"{key}_coarse": a[key] for key in ("vertices", "h", "tau")},
            **{f"{key}_fine": b[key] for key in ("vertices", "h", "tau")},
            "error_coarse": a[f"err_{name}"],
            "error_fine": b[f"err_{name}"],
            "eoc": rate,
            "fitted_order": np.nan if fit is None else fit.order,
            "fitted_uncertainty": np.nan if fit is None else fit.uncertainty,
            "fitted_levels": 0 if fit is None else fit.levels,
        }
        for a, b, rate in zip(coarse, fine, rates(s, e), strict=True)
    ]


def verdict_table(verdicts: list[Verdict]) -> pd.DataFrame:
    """The verdicts of a study as a readable table, a row a judged error, all entries strings.

    Where variables have two, it says which error a row is of, and which one decides. P is the
    probability of an order of at least the claimed one less the tolerance.
    """
    rows = [(v, part) for v in verdicts for part in v.parts]
    orders = [
        (f"{p.observed:.2f}", f"[{p.lower:.2f}, {p.upper:.2f}]")
        if np.isfinite(p.observed)
        else ("-", "-")
        for _, p in rows
    ]
    table = pd.DataFrame(
        {
            "variable": [v.variable for v, _ in rows],
            "error": [SYMBOLS[part.name] for _, part in rows],
            "in": [v.direction for v, _ in rows],
            "claim": [v.claim or "-" for v, _ in rows],
            "expected": [_expected(v) for v, _ in rows],
            "order": [order for order, _ in orders],
            "95 % interval": [interval for _, interval in orders],
            "P": [_probability(p.probability) for _, p in rows],
            "verdict": [part.outcome.upper() for _, part in rows],
            "decides": ["yes" if part == v.deciding else "" for v, part in rows],
        }
    )
    return table if len(rows) > len(verdicts) else table.drop(columns=["error", "decides"])


def _probability(p: float) -> str:
    """Three digits, and never certain."""
    if not np.isfinite(p):
        return "-"
    return f"{p:.3f}" if 0.0005 <= p < 0.9995 else "<.001" if p < 0.5 else ">.999"


def verdicts_frame(verdicts: list[Verdict]) -> pd.DataFrame:
    """verdicts.csv: a row a judged error, with the verdict on it, on its variable, and whether it
    is the one that decides."""
    rows = [
        {
            **{name: getattr(v, name) for name in OF_VARIABLE},
            "error_of": part.name,
            "decides": part == v.deciding,
            "verdict_on_variable": v.verdict,
            **{name: getattr(part, name) for name in OF_ERROR},
            "vertices": " ".join(map(str, part.vertices)),
            "tau": " ".join(f"{tau:.17g}" for tau in part.tau),
        }
        for v in verdicts
        for part in v.parts
    ]
    return pd.DataFrame(rows)


def _expected(verdict: Verdict) -> str:
    claimed = bool(verdict.claim) and np.isfinite(verdict.expected)
    said = [f"order {verdict.expected:g}"] if claimed else []
    said += [f"error <= {verdict.limit:g}"] if np.isfinite(verdict.limit) else []
    return ", ".join(said) or "-"


def markdown(result: StudyResult) -> str:
    """table.md: what was run, the verdicts, and a table of errors and rates for each tau."""
    tables, names, words = result.tables, headed(result.headings), result.words
    title, told = result.study.title, remarks(result)
    parts = [
        f"<!-- {one_line(provenance_line()).replace('-->', '-- >')} -->",
        f"# {one_line(title)}",
        f"{words.case}. Errors: {words.errors}. EOC are signed.",
        _markdown(verdict_table(result.verdicts)),
        "\n".join(f"- {line}" for line in told),
    ]
    for label, (errors, nodal) in tables.items():
        parts.append(f"## {label}")
        parts.append(_markdown(errors.rename(columns=names)))
        if nodal is not None:
            parts.append(f"Against the interpolation, {NODAL}:")
            parts.append(_markdown(nodal.rename(columns=names)))
    return "\n\n".join(parts) + "\n"


def latex(result: StudyResult) -> str:
    """table.tex: a booktabs table for each tau; needs only the package booktabs."""
    names = headed(_in_tex(result.headings))
    told = f"% {one_line(result.study.title)}: {result.words.case}"
    parts = [f"% {one_line(provenance_line())}", told]
    for label, (errors, nodal) in result.tables.items():
        of = f"errors ({escaped(result.words.errors)})"
        parts.append(_latex_table(result, errors.rename(columns=names), label, of, ""))
        if nodal is not None:
            of = rf"errors against the interpolation, {NODAL_TEX},"
            parts.append(_latex_table(result, nodal.rename(columns=names), label, of, "-nodal"))
    return "\n".join(parts)


def headed(names: dict[str, str]) -> dict[str, str]:
    """From the columns of a table by variables to these headings."""
    return names | {f"EOC {name}": f"EOC {shown}" for name, shown in names.items()}


def _markdown(table: pd.DataFrame) -> str:
    return table.to_markdown(index=False, disable_numparse=True)


def _in_tex(names: dict[str, str]) -> dict[str, str]:
    """Headings with the symbols of the variables."""
    return {
        name: shown.replace(name, f"${QUANTITIES[name].tex}$", 1) for name, shown in names.items()
    }


def _latex_table(result: StudyResult, table: pd.DataFrame, label: str, of: str, suffix: str) -> str:
    """One table with its caption; ``label`` names the series, ``of`` says what its errors are."""
    table.columns = [
        "EOC" if c.startswith("EOC") else TEX_HEADS.get(c, c if c[0] == "$" else escaped(c))
        for c in table.columns
    ]
    caption = (
        f"{escaped(one_line(result.study.title))}: {of} and "
        f"experimental orders of convergence, ${label.replace('tau', TAU)}$, "
        f"{result.words.scheme}."
    )
    tex = table.style.hide(axis="index").to_latex(
        hrules=True,
        column_format="r" * len(table.columns),
        position="htbp",
        position_float="centering",
        caption=caption,
        label=f"tab:{result.study.name}-{label.replace(' = ', '-')}{suffix}",
    )
    # Fifteen columns fit the width of a page in this size.
    return tex.replace(r"\centering", r"\centering\scriptsize\setlength{\tabcolsep}{3pt}")


def print_result(result: StudyResult, console: Console) -> None:
    """Print the rate table at the judged tau, the verdicts, and what was not judged."""
    study, label = result.study, result.shown
    errors, nodal = result.tables[label]
    console.print()
    console.rule(Text(study.title, style="bold"), align="left")
    console.print(result.words.case)
    console.print(f"errors and EOC in {study.direction} at {label}; {result.words.errors}")
    _print_table(_transposed(errors, study.direction, result.headings), console)
    if nodal is not None:
        console.print(f"the same against the interpolation: {NODAL}")
        _print_table(_transposed(nodal, study.direction, result.headings), console)
    _print_verdicts(result, console)
    for line in remarks(result):
        console.print(line, style="dim", soft_wrap=True)
    console.print(f"files: {result.folder}", soft_wrap=True)


def _print_verdicts(result: StudyResult, console: Console) -> None:
    """The verdicts; where rows are of two errors, what all have in common stands above them, so
    that the table fits a terminal of 80 columns."""
    table, claim = verdict_table(result.verdicts), result.study.claimed
    if "error" in table:
        if claim is not None:
            console.print(f"claim {claim.name}, in {claim.direction}, on the errors against:")
        table.insert(1, "against", table.pop("error").map(AGAINST))
        table = table.drop(columns=["claim", "in"])
    _print_table(table, console)
    least = {v.expected - v.tolerance for v in result.verdicts if np.isfinite(v.expected)}
    if least:
        console.print(f"P: of an order of at least {', '.join(f'{k:g}' for k in sorted(least))}")


def print_results(results: list[StudyResult], console: Console) -> None:
    """Print each study, and the verdicts on all."""
    for result in results:
        print_result(result, console)
    print_summary(results, console)


def print_summary(results: list[StudyResult], console: Console) -> None:
    """Print one line a study: the verdict that decides the exit status, and which runs it judges.

    For example "PASS  sphere: 3 pass, 3 no claim (judged at tau = 0.0125, V = 120..960)".
    """
    console.rule(Text("verdicts", style="bold"), align="left")
    for result in results:
        outcome = result.outcome.upper()
        counts = pd.Series([v.verdict for v in result.verdicts]).value_counts()
        nothing = ["nothing exercised"] if result.outcome == "not exercised" else []
        detail = ", ".join([*nothing, *(f"{count} {name}" for name, count in counts.items())])
        line = Text.assemble(
            (f"{outcome:13}", STYLES.get(outcome, "")),
            f" {result.study.name}: {detail} ({_judged(result)})",
        )
        console.print(line, soft_wrap=True)


def _judged(result: StudyResult) -> str:
    """The time steps and meshes over which any variable was judged."""
    parts = [part for v in result.verdicts for part in v.parts]
    taus = sorted({tau for part in parts for tau in part.tau}, reverse=True)
    sizes = sorted({vertices for part in parts for vertices in part.vertices})
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


def _print_table(frame: pd.DataFrame, console: Console) -> None:
    texts = ("error", "against", "verdict", "claim", "expected", "decides")
    right = [i for i, name in enumerate(frame.columns) if name not in texts]
    print_table(frame.to_numpy(str).tolist(), console, list(frame.columns), right)
