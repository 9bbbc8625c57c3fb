"""What a table must be before it is judged; anything else is bad input."""

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from esfem.common.bad_input import BadInput
from esfem.judging.table_columns import Array, Table, column, column_names, numbers

Direction = Literal["h", "tau"]
DISTINCT = 1e-3  # relative distance below which two levels are one level given twice
IDENTICAL = 1e-9  # relative spread below which errors are one and the same number
NO_ERROR = "no error"  # why a run that ended is not judged, if it has none
ALIGNED = 1e-6  # of a step, by which the final time may miss a whole number of steps


@dataclass(frozen=True)
class Runs:
    """Runs, coarse before fine, all columns of one length.

    ``error`` is NaN where a run has none, ``tau`` NaN in a table without tau, ``row`` the place of
    a run in the table; ``reason`` says why it is not judged, "" if it is, and ``floor`` which floor
    its error is near.
    """

    h: Array
    tau: Array
    error: Array
    seconds: Array
    status: NDArray[Any]
    row: NDArray[np.int_]
    reason: NDArray[Any]
    floor: NDArray[Any]

    def __len__(self) -> int:
        return len(self.h)

    def at(self, chosen: NDArray[Any]) -> "Runs":
        """Those at these places, or where a mask is true."""
        return Runs(**{name: values[chosen] for name, values in vars(self).items()})

    def parameter(self, name: Direction) -> Array:
        """h or tau."""
        return self.h if name == "h" else self.tau

    @property
    def clear(self) -> NDArray[np.bool_]:
        """Where nothing speaks against a run."""
        return np.asarray(self.reason == "")

    def masking(self, where: NDArray[np.bool_], reason: str, floor: str = "") -> "Runs":
        """The same, with a reason where there was none."""
        new = where & self.clear
        return replace(
            self,
            reason=np.where(new, reason, self.reason).astype(object),
            floor=np.where(new, floor, self.floor).astype(object),
        )


def validated(table: Table, direction: Direction) -> Runs:
    """The runs of a table; one whose ``status`` is not "ok", or without a finite error, is masked.

    Raises
    ------
    BadInput
        If a column is missing or not numeric, columns differ in length, h or tau are not positive
        and finite, an error is negative, two rows are one level, final times differ, or steps do
        not end on them.
    """
    names = column_names(table)
    needed = ("h", "error") if direction == "h" else ("h", "tau", "error")
    known = {name: numbers(table, name) for name in needed}
    n = len(known["error"])
    if n == 0:
        raise BadInput("table: has no rows")
    for name in ("tau", "seconds"):
        known[name] = numbers(table, name) if name in names else np.full(n, np.nan)
    status = column(table, "status") if "status" in names else np.full(n, "ok")
    for name, values in (*known.items(), ("status", status)):
        if len(values) != n:
            raise BadInput(f"column {name}: has {len(values)} rows, column error {n}")
    for name in ("h", "tau")[: 1 + ("tau" in names)]:
        _check_positive(known[name], name)
    if (known["error"] < 0).any():
        lowest = np.nanmin(known["error"])
        raise BadInput(f"column error: {lowest:g} is negative; errors are norms")
    _check_times(table, names)
    status = np.array([s if isinstance(s, str) and s else "ok" for s in status], dtype=object)
    usable = (status == "ok") & np.isfinite(known["error"])
    why = np.where(status != "ok", status, NO_ERROR)
    runs = Runs(
        h=known["h"],
        tau=known["tau"],
        error=np.where(usable, known["error"], np.nan),
        seconds=known["seconds"],
        status=status,
        row=np.arange(n),
        reason=np.where(usable, "", why).astype(object),
        floor=np.full(n, "", dtype=object),
    )
    runs = runs.at(np.lexsort((-runs.tau, -runs.h)))
    _check_levels(runs)
    return runs


def identical(errors: Array) -> bool:
    """Whether three or more errors are one number: then no refinement reached the computation."""
    errors = errors[np.isfinite(errors)]
    return bool(len(errors) >= 3 and np.ptp(errors) <= IDENTICAL * errors.max())


def _check_positive(values: Array, name: str) -> None:
    bad = values[~(np.isfinite(values) & (values > 0))]
    if len(bad):
        raise BadInput(f"column {name}: {bad[0]:g} is not positive and finite")


def _check_times(table: Table, names: list[str]) -> None:
    if "final_time" not in names:
        return
    times = numbers(table, "final_time")
    if np.ptp(times) > ALIGNED * np.abs(times).max() or not np.isfinite(times).all():
        raise BadInput(f"column final_time: {times.min():g} and {times.max():g} differ")
    if "tau" in names:
        steps = times / numbers(table, "tau")
        worst = int(np.argmax(np.abs(steps - np.rint(steps))))
        if abs(steps[worst] - np.rint(steps[worst])) > ALIGNED:
            raise BadInput(
                f"column tau: final_time = {times[worst]:g} is {steps[worst]:g} steps of tau, "
                "not a whole number"
            )


def _check_levels(runs: Runs) -> None:
    """Strictly decreasing h at each tau (and tau at each h): no level twice."""
    for tau in np.unique(runs.tau):
        h = runs.h[runs.tau == tau] if np.isfinite(tau) else runs.h
        close = h[1:] > (1 - DISTINCT) * h[:-1]
        if close.any():
            where = "" if np.isnan(tau) else f" at tau = {tau:g}"
            raise BadInput(
                f"column h: {h[1:][close][0]:g} is given twice{where}; levels must differ"
            )
