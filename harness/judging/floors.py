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
    """A point that was not judged, and why; tau is NaN in a table without tau."""

    h: float
    tau: float
    reason: str


def at_floor(table: pd.DataFrame, errors: pd.Series, floors: Sequence[Floor]) -> pd.Series:
    """Why a point is masked, "" if it is not; indexed as ``errors``.

    ``table`` is the judged table in its own order, to which the values of a floor refer.

    Raises
    ------
    ValueError
        If a floor has neither one value nor one a row.
    """
    reasons = pd.Series("", index=errors.index)
    for floor in floors:
        try:
            values = pd.Series(np.broadcast_to(floor.value, len(table)), index=table.index)
        except ValueError as error:
            raise ValueError(
                f"floor {floor.name}: needs 1 value or {len(table)}, has {np.size(floor.value)}"
            ) from error
        values = values.reindex(errors.index).astype(float)
        for row in errors.index[(errors <= NEAR * values) & (reasons == "") & (values > 0)]:
            reasons[row] = (
                f"error {errors[row]:.2e} within {NEAR:g} times of the {floor.name} floor "
                f"{values[row]:.2e}"
            )
    reasons[(errors == 0) & (reasons == "")] = "error is zero"
    return reasons
