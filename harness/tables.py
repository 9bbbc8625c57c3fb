"""Tables of a study: records.csv and rates.csv for programs, .md for eyes, .tex for papers."""

from typing import Any

import numpy as np
import pandas as pd

from harness.eoc import fit_order, rates
from harness.provenance import numerics_digest, provenance_line, version
from harness.quantities import NODAL, QUANTITIES
from harness.selection import LEVELS, direction
from harness.study import Study
from harness.tex_text import escaped
from harness.verdict import Direction, Verdict
from harness.words import (
    describe,
    headings,
    nodal_headings,
    norms,
    one_line,
    options,
    remarks,
)

TAU = r"\tau"
RATES = (
    *("variable", "direction", "tau"),
    *("vertices_coarse", "h_coarse", "tau_coarse", "vertices_fine", "h_fine", "tau_fine"),
    *("error_coarse", "error_fine", "eoc"),
    *("fitted_order", "fitted_uncertainty", "fitted_levels", "version", "numerics"),
)
NODAL_TEX = r"$u_h - I_h u$ in $L^\infty(0,T; H^1(\Gamma_h^*))$"
TEX_HEADS = {"N": "$N$", "h": "$h$", "tau": f"${TAU}$"}


def rates_table(study: Study, records: pd.DataFrame) -> pd.DataFrame:
    """rates.csv: a line a variable, direction and pair of levels, with signed EOC and fitted order.

    Direction "h": consecutive meshes at one tau; direction "tau": consecutive time steps on one
    mesh.  ``fitted_order`` is the slope over the finest completed levels (at most `LEVELS`).
    """
    lines = []
    for parameter in ("h", "tau"):
        for _, runs in series(records, parameter):
            for name in study.variables:
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
            "version": version(),
            "numerics": numerics_digest(),
        }
        for a, b, rate in zip(coarse, fine, rates(s, e), strict=True)
    ]


def level_table(
    runs: pd.DataFrame, names: dict[str, str], parameter: Direction = "h", error: str = "err"
) -> pd.DataFrame:
    """The readable table of one series: levels down, error and EOC of each variable across.

    All entries are strings; ``names`` maps variables to headings.  With ``error`` "nodal" it shows
    the errors against the interpolation.  A column "status" appears if a run stopped early.
    """
    columns: dict[str, list[str]] = {
        "h": {
            "vertices": [str(v) for v in runs["vertices"]],
            "N": [str(n) for n in runs["nodes"]],
            "h": [f"{h:.3f}" for h in runs["h"]],
        },
        "tau": {"steps": [str(n) for n in runs["steps"]], "tau": [f"{t:.3g}" for t in runs["tau"]]},
    }[parameter]
    for name, shown in names.items():
        value = QUANTITIES[name].value
        if value is not None and error == "err":
            columns[value] = [f"{v:.6g}" if np.isfinite(v) else "-" for v in runs[value]]
        e = runs[f"{error}_{name}"].to_numpy(float)
        columns[shown] = [f"{value:.2e}" if np.isfinite(value) else "-" for value in e]
        eoc = rates(runs[parameter], e)
        columns[f"EOC {shown}"] = ["", *(f"{r:.2f}" if np.isfinite(r) else "-" for r in eoc)]
    if (runs["status"] != "ok").any():
        columns["status"] = [
            f"{run.status} at t = {run.stopped_at:g}" if np.isfinite(run.stopped_at) else run.status
            for run in runs.itertuples()
        ]
    return pd.DataFrame(columns)


def verdict_table(verdicts: list[Verdict]) -> pd.DataFrame:
    """The verdicts of a study as a readable table, all entries strings."""
    return pd.DataFrame(
        {
            "variable": [v.variable for v in verdicts],
            "in": [v.direction for v in verdicts],
            "claim": [v.claim or "-" for v in verdicts],
            "expected": [_expected(v) for v in verdicts],
            "order": [f"{v.observed:.2f}" if np.isfinite(v.observed) else "-" for v in verdicts],
            "95 % interval": [
                f"[{v.lower:.2f}, {v.upper:.2f}]" if np.isfinite(v.observed) else "-"
                for v in verdicts
            ],
            "verdict": [v.verdict.upper() for v in verdicts],
        }
    )


def _expected(verdict: Verdict) -> str:
    if np.isfinite(verdict.limit):
        return f"error <= {verdict.limit:g}"
    claimed = bool(verdict.claim) and np.isfinite(verdict.expected)
    return f"order {verdict.expected:g}" if claimed else "-"


def markdown(
    study: Study, records: pd.DataFrame, floors: pd.DataFrame, verdicts: list[Verdict]
) -> str:
    """table.md: what was run, the verdicts, and a table of errors and rates for each tau."""
    parts = [
        f"<!-- {one_line(provenance_line()).replace('-->', '-- >')} -->",
        f"# {one_line(study.study.title)}",
        f"{describe(study)}. Errors: {norms(study)}. EOC are signed.",
        verdict_table(verdicts).to_markdown(index=False, disable_numparse=True),
        "\n".join(f"- {line}" for line in remarks(study, records, floors, verdicts)),
    ]
    for label, runs in series(records, direction(study)):
        parts.append(f"## {label}")
        table = level_table(runs, headings(study), direction(study))
        parts.append(table.to_markdown(index=False, disable_numparse=True))
        if names := nodal_headings(study, runs):
            table = level_table(runs, names, direction(study), "nodal")
            parts.append(f"Against the interpolation, {NODAL}:")
            parts.append(table.to_markdown(index=False, disable_numparse=True))
    return "\n\n".join(parts) + "\n"


def latex(study: Study, records: pd.DataFrame) -> str:
    """table.tex: a booktabs table for each tau; needs only the package booktabs."""
    title = one_line(study.study.title)
    parts = [f"% {one_line(provenance_line())}", f"% {title}: {describe(study)}"]
    for label, runs in series(records, direction(study)):
        table = level_table(runs, _in_tex(headings(study)), direction(study))
        parts.append(_latex_table(study, table, label, f"errors ({escaped(norms(study))})", ""))
        if names := nodal_headings(study, runs):
            table = level_table(runs, _in_tex(names), direction(study), "nodal")
            of = rf"errors against the interpolation, {NODAL_TEX},"
            parts.append(_latex_table(study, table, label, of, "-nodal"))
    return "\n".join(parts)


def _in_tex(names: dict[str, str]) -> dict[str, str]:
    """Headings with the symbols of the variables."""
    return {
        name: shown.replace(name, f"${QUANTITIES[name].tex}$", 1) for name, shown in names.items()
    }


def _latex_table(study: Study, table: pd.DataFrame, label: str, of: str, suffix: str) -> str:
    """One table with its caption; ``label`` names the series, ``of`` says what its errors are."""
    table.columns = [
        "EOC" if c.startswith("EOC") else TEX_HEADS.get(c, c if c[0] == "$" else escaped(c))
        for c in table.columns
    ]
    caption = (
        f"{escaped(one_line(study.study.title))}: {of} and "
        f"experimental orders of convergence, ${label.replace('tau', TAU)}$, "
        f"{', '.join(options(study.scheme))}."
    )
    tex = table.style.hide(axis="index").to_latex(
        hrules=True,
        column_format="r" * len(table.columns),
        position="htbp",
        position_float="centering",
        caption=caption,
        label=f"tab:{study.name}-{label.replace(' = ', '-')}{suffix}",
    )
    # Fifteen columns fit the width of a page in this size.
    return tex.replace(r"\centering", r"\centering\scriptsize\setlength{\tabcolsep}{3pt}")


def series(records: pd.DataFrame, parameter: Direction) -> list[tuple[str, pd.DataFrame]]:
    """The runs in series along the parameter, coarse to fine, each with its label.

    For h a series a tau, large steps first; for tau a series a mesh, coarse first.
    """
    if parameter == "h":
        taus = sorted(records["tau"].unique(), reverse=True)
        groups = [(f"tau = {t:g}", records[records["tau"] == t]) for t in taus]
    else:
        meshes = sorted(records["vertices"].unique())
        groups = [(f"V = {v}", records[records["vertices"] == v]) for v in meshes]
    return [(label, runs.sort_values(parameter, ascending=False)) for label, runs in groups]
