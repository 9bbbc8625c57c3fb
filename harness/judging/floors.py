"""Floors: what an error cannot fall below for reasons that have nothing to do with its order."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

NEAR = 10.0  # an error within this factor of a floor is masked

FloorName = Literal["tau", "h", "solver", "quadrature", "rounding"]


@dataclass(frozen=True)
class Floor:
    """A measured floor, in units of the error.

    ``value`` is one number for all rows, or a sequence with one entry a row of the judged table in
    its order; "tau" is the floor of the time step when h is judged, "h" that of the mesh when tau
    is.
    """

    name: FloorName
    value: float | Sequence[float]

    def __post_init__(self) -> None:
        values = np.asarray(self.value, dtype=float)
        if not (np.isfinite(values) & (values >= 0)).all():
            raise ValueError(f"floor {self.name} = {self.value}: must be finite and >= 0")


@dataclass(frozen=True)
class Masked:
    """A run that was not judged, and why.

    ``tau`` is NaN in a table without tau, ``floor`` the name of the floor that the error is near,
    "" if that is not the reason.
    """

    h: float
    tau: float
    reason: str
    floor: str


def near_floors(runs: pd.DataFrame, table: pd.DataFrame, floors: Sequence[Floor]) -> pd.DataFrame:
    """Columns floor and reason of the validated ``runs``, "" where no floor is near.

    ``table`` is what they were made of, in the order to which the values of a floor refer.

    Raises
    ------
    ValueError
        If a floor has neither one value nor one a row.
    """
    found = pd.DataFrame({"floor": "", "reason": ""}, index=runs.index)
    e = runs["error"]
    for floor in floors:
        values = _values(floor, table).reindex(runs.index)
        near = (e <= NEAR * values) & (values > 0) & (found["floor"] == "")
        found.loc[near, "floor"] = floor.name
        found.loc[near, "reason"] = [
            f"error {error:.2e} within {NEAR:g} times of the {floor.name} floor {value:.2e}"
            for error, value in zip(e[near], values[near], strict=True)
        ]
    zero = (e == 0) & (found["floor"] == "")
    found.loc[zero, ["floor", "reason"]] = ("rounding", "the error is zero")
    return found


def _values(floor: Floor, table: pd.DataFrame) -> pd.Series:
    if np.size(floor.value) not in (1, len(table)):
        raise ValueError(
            f"floor {floor.name}: needs 1 value or {len(table)}, has {np.size(floor.value)}"
        )
    return pd.Series(np.broadcast_to(np.asarray(floor.value, float), len(table)), table.index)
