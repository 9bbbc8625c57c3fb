"""The numbers of a flow at every time level: the lines of history.csv."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from esfem.common.files import write_text
from esfem.measuring.energies import energy_before
from esfem.runs.recorder import level_numbers
from esfem.solver import Mesh, State
from esfem.solver.laws import Energy
from esfem.solver.reference_element import Array

WILLMORE = "willmore"
COLUMNS = (
    "t",
    "energy",
    WILLMORE,
    "area",
    "volume",
    "least_normal",
    "greatest_normal",
    "least_H",
    "greatest_H",
    "speed",
    "least_area_element",
    "iterations",
    "seconds",
)
# Those of versions that had W in the column "energy".
BEFORE = tuple(name for name in COLUMNS if name != WILLMORE)


class History:
    """What was measured so far, a row a level in the order of `COLUMNS`; a class because it grows.

    The column ``energy`` is that of the law, ``willmore`` W = 1/2 int H^2, ``speed`` max |V|,
    ``least_area_element`` the least over the mean one, 1 on a mesh of equal flat triangles;
    ``iterations`` of GMRES; ``seconds`` since the start.
    """

    def __init__(self, energy: Energy) -> None:
        self.energy = energy
        self.rows: list[Sequence[float]] = []

    def measure(self, mesh: Mesh, state: State, seconds: float) -> None:
        """Add the row of the next level."""
        numbers = level_numbers(COLUMNS[:-1], mesh, state, self.energy)
        self.rows.append((*numbers.values(), seconds))

    def column(self, name: str) -> Array:
        """One column, (levels,)."""
        return np.array([row[COLUMNS.index(name)] for row in self.rows])

    def last(self, name: str) -> float:
        """The entry of a column at the last level."""
        return self.rows[-1][COLUMNS.index(name)]

    def arrays(self) -> dict[str, Array]:
        """All of it, for a checkpoint."""
        return {"history": np.array(self.rows)}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Take over what `arrays` gave."""
        self.rows = [tuple(row) for row in arrays["history"].tolist()]

    def write(self, path: Path) -> None:
        """Write the table, whole, with numbers that read back to the last bit."""
        table = pd.DataFrame(self.rows, columns=COLUMNS, dtype=float)
        write_text(path, table.to_csv(index=False, na_rep="nan", lineterminator="\n"))


def read_history(path: Path, energy: Energy) -> History:
    """The History in a file that `History.write` wrote, of a law with that energy.

    A file of a version that had W in the column of the energy is read, too: the energy is then NaN
    unless it is W or the area.

    Raises
    ------
    ValueError
        If the columns are others, or a line is not one number a column.
    """
    with open(path, encoding="utf-8", newline="") as stream:
        head, *rows = list(csv.reader(stream))
    if tuple(head) not in (COLUMNS, BEFORE):
        raise ValueError(f"{path}: columns must be {', '.join(COLUMNS)}")
    if any(len(row) != len(head) for row in rows):
        raise ValueError(f"{path}: a line has not {len(head)} entries")
    table = pd.DataFrame(rows, columns=head).astype(float)
    if WILLMORE not in table:
        table[WILLMORE] = table["energy"]
        table["energy"] = energy_before(energy, table.__getitem__)
    history = History(energy)
    history.rows = list(table[list(COLUMNS)].itertuples(index=False, name=None))
    return history
