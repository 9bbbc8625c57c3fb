"""The runs of a study in series along a parameter, and the table of each series."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from esfem.judging.eoc import rates
from esfem.studies.claims import Direction
from esfem.studies.quantities import QUANTITIES

Series = list[tuple[str, pd.DataFrame]]


def series(records: pd.DataFrame, parameter: Direction) -> Series:
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


def level_table(
    runs: pd.DataFrame, variables: Sequence[str], parameter: Direction = "h", error: str = "err"
) -> pd.DataFrame:
    """The readable table of one series: levels down, error and EOC of each variable across.

    All entries are strings; the columns are named by variables, "x" and "EOC x". With ``error``
    "nodal" it shows the errors against the interpolation. A column "status" appears if a run
    stopped early.
    """
    columns: dict[str, list[str]] = {
        "h": {
            "vertices": [str(v) for v in runs["vertices"]],
            "N": [str(n) for n in runs["nodes"]],
            "h": [f"{h:.3f}" for h in runs["h"]],
        },
        "tau": {"steps": [str(n) for n in runs["steps"]], "tau": [f"{t:.3g}" for t in runs["tau"]]},
    }[parameter]
    for name in variables:
        value = QUANTITIES[name].value
        if value is not None and error == "err":
            columns[value] = [f"{v:.6g}" if np.isfinite(v) else "-" for v in runs[value]]
        e = runs[f"{error}_{name}"].to_numpy(float)
        columns[name] = [f"{value:.2e}" if np.isfinite(value) else "-" for value in e]
        eoc = rates(runs[parameter], e)
        columns[f"EOC {name}"] = ["", *(f"{r:.2f}" if np.isfinite(r) else "-" for r in eoc)]
    if (runs["status"] != "ok").any():
        columns["status"] = [
            f"{run.status} at t = {run.stopped_at:g}" if np.isfinite(run.stopped_at) else run.status
            for run in runs.itertuples()
        ]
    return pd.DataFrame(columns)
