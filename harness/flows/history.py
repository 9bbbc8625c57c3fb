"""The numbers of a flow at every time level: the lines of history.csv."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from harness.files import write_text
from solver import Mesh, State
from solver.functionals import area, normal_lengths, volume, willmore_energy
from solver.geometry import geometry
from solver.reference_element import Array

COLUMNS = (
    "t",
    "energy",
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


class History:
    """What was measured so far, a row a level in the order of `COLUMNS`; a class because it grows.

    ``energy`` is W = 1/2 int H^2, ``speed`` max |V|, ``least_area_element`` the least over the mean
    one, 1 on a mesh of equal flat triangles; ``iterations`` of GMRES; ``seconds`` since the start.
    """

    def __init__(self) -> None:
        self.rows: list[Sequence[float]] = []

    def measure(self, mesh: Mesh, state: State, seconds: float) -> None:
        """Add the row of the next level."""
        geo = geometry(mesh, state.x)
        element = geo.dA / geo.element.weights
        self.rows.append(
            (
                state.t,
                willmore_energy(geo, state.H),
                area(geo),
                volume(geo),
                *normal_lengths(state.nu),
                float(state.H.min()),
                float(state.H.max()),
                float(np.abs(state.V).max()),
                float(element.min() / element.mean()),
                float(state.work.iterations),
                seconds,
            )
        )

    def column(self, name: str) -> Array:
        """One column, (levels,)."""
        return np.array([row[COLUMNS.index(name)] for row in self.rows])

    def arrays(self) -> dict[str, Array]:
        """All of it, for a checkpoint."""
        return {"history": np.array(self.rows)}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Take over what `arrays` gave."""
        self.rows = [tuple(row) for row in arrays["history"].tolist()]

    def write(self, path: Path) -> None:
        """Write the table, whole, with numbers that read back to the last bit."""
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows([[repr(float(value)) for value in row] for row in self.rows])
        write_text(path, stream.getvalue())


def read_history(path: Path) -> History:
    """The History in a file that `History.write` wrote.

    Raises
    ------
    ValueError
        If the columns are others.
    """
    with open(path, encoding="utf-8", newline="") as stream:
        head, *rows = list(csv.reader(stream))
    if tuple(head) != COLUMNS:
        raise ValueError(f"{path}: columns must be {', '.join(COLUMNS)}")
    history = History()
    history.rows = [tuple(map(float, row)) for row in rows]
    return history
