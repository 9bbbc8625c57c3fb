"""A cell of a sweep: one run, and the files that belong to it."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from harness.case import Case
from harness.floors import floor_cases
from harness.judging.floors import FloorName
from harness.meshing import SurfaceMesh
from harness.store import case_key, key
from harness.study import Study


@dataclass(frozen=True)
class Cell:
    """One run of one study: where its record goes, and on which triangulation it is computed.

    ``floor`` names the floor that it measures; None for a cell of the sweep itself.
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
