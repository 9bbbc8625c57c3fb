"""Time series of a flow in one VTKHDF file: moving points, nodal fields, connectivity once.

References
----------
VTKHDF format specification, version 2, temporal UnstructuredGrid: docs.vtk.org, "VTKHDF File
Format". All time steps share one part with its cells; the offsets of points and fields grow.
"""

import os
from collections.abc import Iterable
from pathlib import Path

import h5py
import numpy as np

from harness.flows.fields import shown
from harness.flows.vtk_cells import LAGRANGE_TRIANGLE, vtk_cells
from solver import Mesh, State

VERSION = (2, 0)
TYPE = b"UnstructuredGrid"


def write_vtkhdf(path: Path, mesh: Mesh, states: Iterable[State]) -> None:
    """Write the States of one mesh, one at a time, into a whole file."""
    unfinished = path.with_name(f".{path.stem}.{os.getpid()}.vtkhdf")
    try:
        with h5py.File(unfinished, "w") as file:
            root = file.create_group("VTKHDF")
            root.attrs["Version"] = VERSION
            root.attrs.create("Type", TYPE, dtype=h5py.string_dtype("ascii", len(TYPE)))
            _write_cells(root, mesh)
            times = [_append_state(root, state) for state in states]
            _write_steps(root, mesh, np.array(times))
        os.replace(unfinished, path)
    finally:
        unfinished.unlink(missing_ok=True)


def _write_cells(root: h5py.Group, mesh: Mesh) -> None:
    """Connectivity, offsets and types, the same for all steps."""
    cells = vtk_cells(mesh)
    E, n = cells.shape
    root["Connectivity"] = cells.ravel()
    root["Offsets"] = n * np.arange(E + 1)
    root["Types"] = np.full(E, LAGRANGE_TRIANGLE, dtype=np.uint8)


def _append_state(root: h5py.Group, state: State) -> float:
    """Add points and fields of a step; return its time."""
    fields = {f"PointData/{name}": array for name, array in shown(state).items()}
    for name, array in {"Points": state.x, **fields}.items():
        if name not in root:
            shape = (0, *array.shape[1:])
            root.create_dataset(
                name, shape, dtype="f8", maxshape=(None, *shape[1:]), chunks=array.shape
            )
        data = root[name]
        data.resize(len(data) + len(array), axis=0)
        data[-len(array) :] = array
    return state.t


def _write_steps(root: h5py.Group, mesh: Mesh, times: np.ndarray) -> None:
    """Sizes of the one part that all steps share, and where the points of each begin."""
    count, same = len(times), np.zeros(len(times), dtype=np.int64)
    begin = mesh.node_count * np.arange(count)
    root["NumberOfPoints"] = [mesh.node_count]
    root["NumberOfCells"] = [len(mesh.cells)]
    root["NumberOfConnectivityIds"] = [mesh.cells.size]
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = count
    steps["Values"] = times
    steps["PartOffsets"] = same
    steps["NumberOfParts"] = same + 1
    steps["PointOffsets"] = begin
    steps["CellOffsets"] = same[:, None]
    steps["ConnectivityIdOffsets"] = same[:, None]
    for name in root["PointData"]:
        steps[f"PointDataOffsets/{name}"] = begin
