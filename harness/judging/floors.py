"""Floors: what an error cannot fall below for reasons that have nothing to do with its order."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from esfem.judging.table_columns import Array
from esfem.judging.validate import Runs

NEAR = 10.0  # an error within this factor of a floor is masked
EPS = float(np.finfo(float).eps)
ADDED_UP = 1000.0  # rounding errors of an assembly, a solve and a norm, in units of eps

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


def near_floors(runs: Runs, floors: Sequence[Floor]) -> Runs:
    """The runs, those near a floor masked, and those that the assumed one of rounding swallows.

    Raises
    ------
    ValueError
        If a floor has neither one value nor one a row.
    """
    e = runs.error
    for floor in floors:
        values = _values(floor, len(runs))[runs.row]
        near = (e <= NEAR * values) & (values > 0) & runs.clear
        words = [
            f"error {error:.2e} within {NEAR:g} times of the {floor.name} floor {value:.2e}"
            for error, value in zip(e, values, strict=True)
        ]
        runs = replace(
            runs,
            reason=np.where(near, words, runs.reason).astype(object),
            floor=np.where(near, floor.name, runs.floor).astype(object),
        )
    runs = runs.masking(e == 0, "the error is zero", "rounding")
    if any(floor.name == "rounding" for floor in floors):
        return runs
    least = rounding_floor(e)
    reason = f"at the assumed floor of rounding: below {ADDED_UP:g} x {least:.1e}"
    return runs.masking(e <= ADDED_UP * least, reason, "rounding")


def rounding_floor(errors: Array) -> float:
    """eps times the largest value there is: 1, that of a solution in units of its own, or an error
    above."""
    return EPS * float(np.max(errors, initial=1.0, where=np.isfinite(errors)))


def _values(floor: Floor, rows: int) -> Array:
    if np.size(floor.value) not in (1, rows):
        raise ValueError(f"floor {floor.name}: needs 1 value or {rows}, has {np.size(floor.value)}")
    return np.broadcast_to(np.asarray(floor.value, float), rows)
