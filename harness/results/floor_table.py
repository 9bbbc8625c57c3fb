"""floors.csv: what the measured floors are, and what share of the error each is."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from esfem.judging.floors import FloorName
from esfem.studies.study import Study
from esfem.studies.variations import measured_cells

COLUMNS = ("floor", "variable", "vertices", "tau", "error", "varied", "value", "key")


def floors_table(
    study: Study, records: pd.DataFrame, varied: dict[FloorName, dict[str, Any]]
) -> pd.DataFrame:
    """floors.csv: a line a floor and variable.

    Parameters
    ----------
    records, varied : the rows (`results.rows.record_row`) of the sweep, and by floor that of the
        variation.

    With order q, e(tau) - e(tau/2) is the part 1 - 2^-q of the error in time. Runs that stopped
    early tell nothing: NaN.
    """
    lines = []
    for name, cell in measured_cells(study).items():
        at = (records["vertices"] == cell.vertices) & (records["tau"] == cell.tau)
        if name not in varied or not at.any():
            continue
        own, row = records[at].iloc[0], varied[name]
        part = 1.0 - 2.0**-study.scheme.order if name == "tau" else 1.0
        for variable in study.variables:
            e, other = own[f"err_{variable}"], row[f"err_{variable}"]
            value = abs(other - e) / part
            line = (name, variable, cell.vertices, cell.tau, e, other, value, row["key"])
            lines.append(line)
    return pd.DataFrame(lines, columns=list(COLUMNS))


def floor_lines(floors: pd.DataFrame, variables: Sequence[str]) -> list[str]:
    """The floors for eyes: a line a floor, with the share in the error of each variable."""
    lines = []
    for name, own in floors.groupby("floor", sort=False):
        share = own.set_index("variable")["value"] / own.set_index("variable")["error"]
        shares = [f"{v} {_short(share[v])}" for v in variables if v in share.index]
        at = f"V = {own['vertices'].iloc[0]}, tau = {own['tau'].iloc[0]:g}"
        lines.append(f"{name} floor, as a share of the error at {at}: {', '.join(shares)}")
    return lines


def _short(share: float) -> str:
    return f"{share:.1e}" if np.isfinite(share) else "-"
