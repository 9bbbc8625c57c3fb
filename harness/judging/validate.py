"""What a table must be before it is judged; anything else is bad input."""

from typing import Literal

import numpy as np
import pandas as pd

from esfem.common.bad_input import BadInput

Direction = Literal["h", "tau"]
DISTINCT = 1e-3  # relative distance below which two levels are one level given twice
IDENTICAL = 1e-9  # relative spread below which errors are one and the same number
ALIGNED = 1e-6  # of a step, by which the final time may miss a whole number of steps


def validated(table: pd.DataFrame, direction: Direction) -> pd.DataFrame:
    """The table with float columns h, tau and error, coarse before fine.

    A run whose ``status`` is not "ok", or whose error is not finite, keeps its row with error NaN;
    a table without tau gets NaN there, one without status "ok".

    Raises
    ------
    BadInput
        If a column is missing or not numeric, h or tau are not positive and finite, an error is
        negative, two rows are one level, final times differ, or steps do not end on them.
    """
    needed = ("h", "error") if direction == "h" else ("h", "tau", "error")
    for name in needed:
        if name not in table:
            raise BadInput(f"column {name}: missing; there are {', '.join(map(str, table))}")
    if table.empty:
        raise BadInput("table: has no rows")
    result = pd.DataFrame({name: _numbers(table, name) for name in ("h", "error")})
    result["tau"] = _numbers(table, "tau") if "tau" in table else np.nan
    status = table["status"].to_numpy() if "status" in table else np.full(len(table), "ok")
    result["status"] = np.where(pd.isna(status), "ok", status)
    result["seconds"] = _numbers(table, "seconds") if "seconds" in table else np.nan
    for name in ("h", "tau")[: 1 + ("tau" in table)]:
        _check_positive(result[name].to_numpy(), name)
    if (result["error"] < 0).any():
        raise BadInput(f"column error: {result['error'].min():g} is negative; errors are norms")
    usable = (result["status"] == "ok") & np.isfinite(result["error"])
    result["error"] = result["error"].where(usable)
    _check_times(table)
    result = result.set_index(table.index).sort_values(["h", "tau"], ascending=False)
    _check_levels(result)
    return result


def identical(errors: np.ndarray) -> bool:
    """Whether three or more errors are one number: then no refinement reached the computation."""
    errors = errors[np.isfinite(errors)]
    return bool(len(errors) >= 3 and np.ptp(errors) <= IDENTICAL * errors.max())


def _numbers(table: pd.DataFrame, name: str) -> np.ndarray:
    try:
        return pd.to_numeric(table[name]).to_numpy(float)
    except (ValueError, TypeError) as error:
        raise BadInput(f"column {name}: {error}") from error


def _check_positive(values: np.ndarray, name: str) -> None:
    bad = values[~(np.isfinite(values) & (values > 0))]
    if len(bad):
        raise BadInput(f"column {name}: {bad[0]:g} is not positive and finite")


def _check_times(table: pd.DataFrame) -> None:
    if "final_time" not in table:
        return
    times = _numbers(table, "final_time")
    if np.ptp(times) > ALIGNED * np.abs(times).max() or not np.isfinite(times).all():
        raise BadInput(f"column final_time: {times.min():g} and {times.max():g} differ")
    if "tau" in table:
        steps = times / _numbers(table, "tau")
        worst = int(np.argmax(np.abs(steps - np.rint(steps))))
        if abs(steps[worst] - np.rint(steps[worst])) > ALIGNED:
            raise BadInput(
                f"column tau: final_time = {times[worst]:g} is {steps[worst]:g} steps of tau, "
                "not a whole number"
            )


def _check_levels(table: pd.DataFrame) -> None:
    """Strictly decreasing h at each tau (and tau at each h): no level twice."""
    for tau, runs in table.groupby("tau", dropna=False):
        h = runs["h"].to_numpy()
        close = h[1:] > (1 - DISTINCT) * h[:-1]
        if close.any():
            where = "" if np.isnan(tau) else f" at tau = {tau:g}"
            raise BadInput(
                f"column h: {h[1:][close][0]:g} is given twice{where}; levels must differ"
            )
