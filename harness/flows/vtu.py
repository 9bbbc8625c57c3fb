"""A flow as a .vtu file a frame and the .pvd file that gives them their times, by vtk."""

import os
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

from harness.files import write_text
from harness.flows.fields import shown
from harness.flows.vtk_cells import LAGRANGE_TRIANGLE, vtk_cells
from solver import Mesh, State


def grid(mesh: Mesh, state: State) -> vtkUnstructuredGrid:
    """The curved surface with its nodal fields as Lagrange triangles."""
    cells = np.ascontiguousarray(vtk_cells(mesh), dtype=np.int64)
    array = vtkCellArray()
    array.SetData(cells.shape[1], numpy_to_vtk(cells.ravel(), deep=True))
    points = vtkPoints()
    points.SetData(numpy_to_vtk(state.x, deep=True))
    result = vtkUnstructuredGrid()
    result.SetPoints(points)
    result.SetCells(LAGRANGE_TRIANGLE, array)
    for name, field in shown(state).items():
        data = numpy_to_vtk(np.ascontiguousarray(field), deep=True)
        data.SetName(name)
        result.GetPointData().AddArray(data)
    return result


def write_vtu(path: Path, mesh: Mesh, state: State) -> None:
    """Write one frame, compressed binary XML, whole or not at all.

    Raises
    ------
    OSError
        If vtk could not write the file.
    """
    unfinished = path.with_name(f".{path.stem}.{os.getpid()}.vtu")
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(unfinished))
    writer.SetInputData(grid(mesh, state))
    try:
        if not writer.Write():
            raise OSError(f"{path}: cannot be written by vtk")
        os.replace(unfinished, path)
    finally:
        unfinished.unlink(missing_ok=True)


def write_pvd(path: Path, mesh: Mesh, states: Iterable[State]) -> None:
    """Write the frames into the folder ``vtu`` beside the .pvd file, and that last."""
    folder = path.parent / "vtu"
    folder.mkdir(exist_ok=True)
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    for i, state in enumerate(states):
        name = f"{path.stem}-{i:04d}.vtu"
        write_vtu(folder / name, mesh, state)
        ElementTree.SubElement(
            collection, "DataSet", timestep=repr(state.t), part="0", file=f"vtu/{name}"
        )
    for left in set(folder.glob(f"{path.stem}-*.vtu")) - {
        folder / f"{path.stem}-{i:04d}.vtu" for i in range(len(collection))
    }:
        left.unlink()  # of an earlier flow of that name with more frames
    ElementTree.indent(root)
    write_text(path, ElementTree.tostring(root, encoding="unicode", xml_declaration=True))
