"""A cell of a sweep: one run, and the files that belong to it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from esfem.judging.floors import FloorName
from esfem.meshes import SurfaceMesh
from esfem.runs.run_case import Record
from esfem.runs.store import case_key, key, read_record
from esfem.studies.case import Case
from esfem.studies.study import Study
from esfem.studies.variations import floor_cases


@dataclass(frozen=True, eq=False)
class Cell:
    """One run of one study: where its record goes, and on which triangulation it is computed.

    ``floor`` names the floor that it measures; None for a cell of the sweep itself. No two cells
    are equal, so that dictionaries may have them as keys.
    """

    study: str
    folder: Path
    case: Case
    surface: SurfaceMesh
    floor: FloorName | None = None

    @cached_property
    def key(self) -> str:
        """The key of its record."""
        return key(self.case, self.surface.digest)

    @property
    def weight(self) -> float:
        """What it costs, in no unit: nodes^1.1 steps."""
        return (self.case.scheme.degree**2 * self.case.vertices) ** 1.1 * self.case.steps

    @property
    def label(self) -> str:
        """For a line of progress."""
        return self.case.label + (f", {self.floor} floor" if self.floor else "")

    @property
    def progress_path(self) -> Path:
        """The file in which a running cell tells the fraction it has done."""
        return self.folder / "progress" / self.key

    @property
    def lease_path(self) -> Path:
        """The file that says who computes it."""
        return self.folder / "progress" / f"{self.key}.lease"

    @property
    def checkpoint_path(self) -> Path:
        """Where a long run keeps how far it is; one of another version is found there too."""
        return self.folder / "checkpoints" / f"{case_key(self.case, self.surface.digest)}.npz"

    def stored(self, complain: Callable[[str], None]) -> Record | None:
        """Its record, read and verified (`esfem.runs.store.read_record`); None if there is none."""
        return read_record(self.folder, self.key, complain)


def cells_of(study: Study, folder: Path, surfaces: dict[int, SurfaceMesh]) -> list[Cell]:
    """The cells of a study with results in ``folder`` and triangulations by number of vertices,
    those that measure its floors last."""
    sweep = [Cell(study.name, folder, case, surfaces[case.vertices]) for case in study.cases()]
    return sweep + [
        Cell(study.name, folder, case, surfaces[case.vertices], floor)
        for floor, case in floor_cases(study).items()
    ]


def progress(cell: Cell) -> float | None:
    """The fraction that a running cell last told, or None if it is not running."""
    try:
        return float(cell.progress_path.read_text())
    except (OSError, ValueError):
        return None


def stored_records(cells: Sequence[Cell]) -> dict[Cell, Record]:
    """The records of those cells that have one; what is damaged counts as absent."""
    found = {cell: cell.stored(lambda line: None) for cell in cells}
    return {cell: record for cell, record in found.items() if record is not None}
