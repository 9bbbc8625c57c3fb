"""Our P_k elements as VTK's Lagrange triangles: the same lattice, its nodes in another order."""

import numpy as np

from solver import Mesh
from solver.mesh import Integers

LAGRANGE_TRIANGLE = 69  # VTK_LAGRANGE_TRIANGLE


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


def vtk_cells(mesh: Mesh) -> Integers:
    """The nodes of each element in VTK's order, (E, n)."""
    return mesh.cells[:, vtk_order(mesh.degree)]
