"""The energy of a law in tables: beside W and the area, and whether it falls."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.interpolate import make_interp_spline

from esfem.solver.laws import Energy
from esfem.solver.reference_element import Array

# Every table has W and the area; the energy of a law that has one of these symbols repeats it.
COLUMNS = {"W": "willmore", "A": "area"}
QUANTITIES = {"W": "W", "A": "area"}  # as `COLUMNS`, by the names of `esfem.studies.quantities`
OF_ITS_OWN = "energy"
# The Krylov iteration of a step stops at 1e-10 of w; a relative rise below this is none.
ROUNDING = 1e-9
# Of the spline through the levels by which dissipation is integrated in time: its error is of order
# six, one more than that of BDF5.
SPLINE = 5


def quantity_of(energy: Energy) -> str:
    """The quantity whose error is that of this energy: W, area, or one of its own."""
    return QUANTITIES.get(energy.symbol, OF_ITS_OWN)


def scale_of(energy: Energy, at_start: float, willmore: float) -> float:
    """What changes of an energy are measured by: its value at the start, or W there if that is
    larger and the energy may be zero, as that of Helfrich on its sphere."""
    return max(at_start, willmore) if energy.symbol == "E" else at_start


def largest_rise(energies: Sequence[float], scale: float, first: int = 0) -> tuple[float, int]:
    """The largest increase in a step from level ``first`` on, relative to ``scale``, and the level
    that it leads to; 0.0, 0 if there is none, NaN if an energy is.

    Not relative to the energy before the step, for a Helfrich energy may tend to zero.
    """
    rises = np.diff(energies[first:])
    if np.isnan(rises).any():
        return float("nan"), 0
    if not np.any(rises > 0.0):
        return 0.0, 0
    worst = int(np.argmax(rises))
    return float(rises[worst] / scale), first + worst + 1


def balance_error(
    t: Sequence[float], energies: Sequence[float], dissipation: Sequence[float], scale: float
) -> float:
    """The largest abs(E(t_n) - E(0) + int_0^t_n D dt) over all levels, relative to ``scale``.

    Of an unforced flow with dE/dt = -D (`esfem.solver.laws.Energy`) that is zero, of a discrete one
    O(h^k + tau^q) as far as E_h and D_h are. From one level to another the energy rises by twice as
    much at most, since D >= 0. The integral is that of the spline of degree `SPLINE` through D, or
    of the odd degree that the number of levels allows. NaN with fewer than two levels.
    """
    if len(t) < 2:
        return float("nan")
    odd = 2 * (min(SPLINE + 1, len(t)) // 2) - 1
    lost = make_interp_spline(t, dissipation, k=odd).antiderivative()
    residual = np.subtract(energies, energies[0]) + lost(t) - lost(t[0])
    return float(np.abs(residual).max() / scale)


def drift(values: Sequence[float]) -> float:
    """The largest relative change from the first of the values."""
    return float(np.abs(np.asarray(values) / values[0] - 1.0).max())


def energy_before(energy: Energy, column: Callable[[str], Array]) -> Array:
    """The energies of a table of a version that wrote W into the column "energy": W or the area if
    it is one of them, else they are not known, NaN.

    Parameters
    ----------
    column : gives "willmore" and "area" (levels,).
    """
    known = COLUMNS.get(energy.symbol)
    return np.full(len(column("willmore")), np.nan) if known is None else column(known)
