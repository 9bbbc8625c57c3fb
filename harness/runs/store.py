"""The cells of a sweep, each a run, and their records on disk.

A record is a file, written atomically, named by content hash, checked on reading.
"""

import hashlib
import io
import json
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from esfem.common.bad_input import BadInput
from esfem.common.files import write_bytes, write_text
from esfem.common.provenance import numerics_digest, stepping_digest
from esfem.judging.floors import FloorName
from esfem.meshes import SurfaceMesh
from esfem.reference_solutions import SurfaceFlow
from esfem.reference_solutions.surfaces import surface_digest
from esfem.runs.run_case import Record
from esfem.schemes import scheme_file
from esfem.solver.reference_element import Array
from esfem.studies.case import Case
from esfem.studies.study import Study
from esfem.studies.variations import floor_cases

RECORDED = {field.name for field in fields(Record)}


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
        """Its record, read and verified (`read_record`); None if there is none."""
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


def content(case: Case, mesh_digest: str) -> dict[str, Any]:
    """What determines the numbers of a run, program and libraries aside, as plain data."""
    found = {"case": case.model_dump(mode="json"), "mesh": mesh_digest}
    solution = case.initial
    if isinstance(solution, SurfaceFlow):
        found["surface"] = surface_digest(solution.surface)
    if case.plugin.run is None:
        found["scheme"] = stepping_digest(scheme_file(case.scheme.name))
    return found


def key(case: Case, mesh_digest: str) -> str:
    """Content hash of case, mesh and the numerics of this program: 16 hexadecimal digits."""
    return _digest({**content(case, mesh_digest), "numerics": numerics_digest()})[:16]


def case_key(case: Case, mesh_digest: str) -> str:
    """Content hash of case and mesh alone."""
    return _digest(content(case, mesh_digest))[:16]


def record_path(folder: Path, record_key: str) -> Path:
    """Where the record of that key lies in the folder of a study."""
    return folder / "records" / f"{record_key}.json"


def snapshots_path(folder: Path, record_key: str) -> Path:
    """Where the snapshots of that key lie, if it has any."""
    return folder / "records" / f"{record_key}.npz"


def write_record(
    folder: Path, record_key: str, record: Record, snapshots: Array | None = None
) -> None:
    """Store a record, its snapshots before it; a reader sees it whole or not at all."""
    if snapshots is not None:
        buffer = io.BytesIO()
        np.savez(buffer, snapshots=snapshots)
        write_bytes(snapshots_path(folder, record_key), buffer.getvalue())
        digest = hashlib.sha256(buffer.getvalue()).hexdigest()
        record = replace(record, snapshots_digest=digest)
    plain = asdict(record)
    write_text(
        record_path(folder, record_key),
        json.dumps({"digest": _digest(plain), "record": plain}, indent=1),
    )


def read_record(folder: Path, record_key: str, complain: Callable[[str], None]) -> Record | None:
    """The stored record, or None if there is none.

    A file that is truncated or was edited by hand is reported through ``complain``, set aside as
    ``*.damaged`` and counts as absent; that of another version is reported and left alone.
    """
    path = record_path(folder, record_key)
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        if stored["digest"] != _digest(stored["record"]):
            raise ValueError("its content does not match its digest")
        if stored["record"].keys() != RECORDED:
            complain(f"{path}: record of another version of this program, is not read")
            return None
        record = Record(**stored["record"])
        if record.snapshots_digest:
            snapshots = snapshots_path(folder, record_key).read_bytes()
            if hashlib.sha256(snapshots).hexdigest() != record.snapshots_digest:
                raise ValueError("its snapshots do not match their digest")
        return record
    except FileNotFoundError:
        return None
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        aside = path.with_suffix(".json.damaged")
        os.replace(path, aside)
        complain(
            f"{path}: damaged record ({error}); set aside as {aside.name}, will be computed again"
        )
        return None


def read_snapshots(folder: Path, record_key: str) -> Array:
    """The stacked unknowns (times, N, 14) that were stored with a record."""
    with np.load(snapshots_path(folder, record_key), allow_pickle=False) as stored:
        return stored["snapshots"]


def _digest(plain: Any) -> str:
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()
