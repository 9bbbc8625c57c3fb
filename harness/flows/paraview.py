"""A flow for ParaView: a .vtu file a frame, of curved elements, and the .pvd file of their times.

Our P_k elements are the Lagrange triangles of VTK: the same lattice, its nodes in another order.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from esfem.common.files import write_text
from esfem.flows.flow_file import FlowFile
from esfem.flows.flow_results import read_frame
from esfem.solver import Mesh, State
from esfem.solver.mesh import Integers

if TYPE_CHECKING:
    import pyvista as pv

FIELDS = ("nu", "H", "V", "z", "v")  # by the paper's letters


def vtk_order(degree: int) -> Integers:
    """Local node of ours at each place of VTK's Lagrange triangle, (n,).

    Both begin with the corners. Then VTK runs around, along the edges 0-1, 1-2 and 2-0; basix has
    1-2, 0-2 and 0-1. The nodes inside, of degree 3 and 4, have the same order: of degree 4 they
    are the corners of a smaller triangle.
    """
    inside = 3 * degree
    edge_12, edge_02, edge_01 = np.arange(3, inside).reshape(3, degree - 1)
    interior = np.arange(inside, (degree + 1) * (degree + 2) // 2)
    return np.concatenate([np.arange(3), edge_01, edge_12, edge_02[::-1], interior])


def grid(mesh: Mesh, state: State) -> "pv.UnstructuredGrid":
    """The curved surface with its nodal fields."""
    import pyvista as pv  # slow to load, and may not be there

    cells = mesh.cells[:, vtk_order(mesh.degree)]
    result = pv.UnstructuredGrid({pv.CellType.LAGRANGE_TRIANGLE: cells}, state.x)
    for name in FIELDS:
        result.point_data[name] = getattr(state, name)
    result.set_active_scalars("H")  # what ParaView shows first
    return result


def write_vtu(path: Path, mesh: Mesh, state: State) -> None:
    """Write one frame, compressed, whole or not at all."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid(mesh, state))
    writer.WriteToOutputStringOn()  # on a full disk, its own writing to a file ends the process
    writer.Write()
    write_text(path, writer.GetOutputString())


def write_series(folder: Path, flow: FlowFile, mesh: Mesh, levels: Iterable[int]) -> None:
    """Write vtu/NAME-LEVEL.vtu of each frame of these levels that has none, then NAME.pvd of all.

    So a flow that goes on, or is resumed, adds to its series; ParaView sees a whole one.
    """
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    (folder / "vtu").mkdir(exist_ok=True)
    for n in levels:
        file = f"vtu/{flow.name}-{n:08d}.vtu"
        if not (folder / file).is_file():
            write_vtu(folder / file, mesh, read_frame(folder, n))
        t = repr(flow.levels.t(n))
        ElementTree.SubElement(collection, "DataSet", timestep=t, part="0", file=file)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode", xml_declaration=True)
    write_text(folder / f"{flow.name}.pvd", text)
