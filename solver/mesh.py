"""Mesh: which nodes belong to which element.

Coordinates travel beside it, for the surface moves and the mesh does not.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from esfem.solver.reference_element import DEGREES, Array, lattice, tabulate

Integers = NDArray[np.int64]

PATCH = 16_000  # elements times nodes of an element; measured: a third or thrice as many are slower

# Reference edges in the order of basix: edge i lies opposite to vertex i and runs from lower to
# higher local vertex.
REFERENCE_EDGES = np.array([[1, 2], [0, 2], [0, 1]])


@dataclass(frozen=True)
class SparsePattern:
    """One CSR pattern for all matrices of a mesh.

    Attributes
    ----------
    indptr, indices : (N + 1,), (nnz,) int32, sorted within a row; every row has its diagonal entry.
    scatter : (n n E,) where the local entry (i, j, e) is added in the data.
    upper : positions of the entries on and above the diagonal, with their own (upper_indptr,
        upper_indices).
    """

    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]
    scatter: Integers
    upper: Integers
    upper_indptr: NDArray[np.int32]
    upper_indices: NDArray[np.int32]


@dataclass(frozen=True)
class Patch:
    """A stretch of the elements of a mesh, with all its nodes; formulas take it for a mesh.

    Attributes
    ----------
    degree : of the mesh.
    elements : which they are.
    cells : (e, n) their nodes.
    """

    degree: int
    elements: slice
    cells: Integers


@dataclass(frozen=True)
class Mesh:
    """Topology of a closed, oriented triangulation with P_k nodes.

    Attributes
    ----------
    degree : polynomial degree k.
    triangles : (E, 3) vertices of each element, counter-clockwise seen from outside.
    cells : (E, n) nodes of each element in the order of the reference element; ``cells[:, :3]`` are
        the triangles.
    node_count : N.

    Raises
    ------
    ValueError
        If the triangulation is not closed and consistently oriented, or a node belongs to no
        element.
    """

    degree: int
    triangles: Integers
    cells: Integers
    node_count: int

    def __post_init__(self) -> None:
        if self.triangles.ndim != 2 or self.triangles.shape[1] != 3:
            raise ValueError(f"triangles: must have shape (E, 3), has {self.triangles.shape}")
        directed = self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        key = directed[:, 0] * (directed.max() + 1) + directed[:, 1]
        reverse = directed[:, 1] * (directed.max() + 1) + directed[:, 0]
        if len(np.unique(key)) != len(key):
            raise ValueError(
                "triangles: not consistently oriented: a directed edge belongs to two triangles"
            )
        if not np.array_equal(np.sort(key), np.sort(reverse)):
            raise ValueError("triangles: not closed: an edge has a triangle on one side only")
        if not np.array_equal(np.unique(self.cells), np.arange(self.node_count)):
            raise ValueError(
                f"cells: must use each node 0..{self.node_count - 1}, or some belong to no element"
            )

    @property
    def vertex_count(self) -> int:
        """Number V of vertices of the triangulation."""
        return int(self.triangles.max()) + 1

    @property
    def euler_characteristic(self) -> int:
        """V - edges + E; 2 for a sphere, 0 for a torus."""
        return self.vertex_count - len(self.triangles) // 2

    @cached_property
    def patches(self) -> tuple[Patch, ...]:
        """The elements in stretches of about `PATCH` nodes of cells."""
        E, n = self.cells.shape
        parts = max(1, round(E * n / PATCH))
        bounds = [E * i // parts for i in range(parts + 1)]
        stretches = [slice(start, stop) for start, stop in pairwise(bounds)]
        return tuple(Patch(self.degree, e, self.cells[e]) for e in stretches)

    @cached_property
    def pattern(self) -> SparsePattern:
        """The CSR pattern of all matrices on this mesh."""
        n, N = self.cells.shape[1], self.node_count
        rows = np.repeat(self.cells.T, n, axis=0).ravel()
        columns = np.tile(self.cells.T, (n, 1)).ravel()
        entries, scatter = np.unique(rows * N + columns, return_inverse=True)
        row, column = entries // N, entries % N
        upper = np.flatnonzero(column >= row)

        def pointers(row_of_entry: Integers) -> NDArray[np.int32]:
            return np.concatenate([[0], np.cumsum(np.bincount(row_of_entry, minlength=N))]).astype(
                np.int32
            )

        return SparsePattern(
            indptr=pointers(row),
            indices=column.astype(np.int32),
            scatter=scatter,
            upper=upper,
            upper_indptr=pointers(row[upper]),
            upper_indices=column[upper].astype(np.int32),
        )


def triangulation(triangles: Integers, degree: int = 1) -> Mesh:
    """The P_k mesh on given triangles (E, 3), its nodes numbered vertices, edges, interiors.

    Raises
    ------
    ValueError
        If ``degree`` is not in 1..4 or the triangles are not closed and oriented.
    """
    if degree not in DEGREES:
        raise ValueError(f"degree = {degree!r}: must be one of {DEGREES}")
    triangles = np.ascontiguousarray(triangles, dtype=np.int64)
    vertex_count = int(triangles.max()) + 1
    ends = triangles[:, REFERENCE_EDGES]
    lowest_first = np.sort(ends, axis=2).reshape(-1, 2)
    edges, edge_of = np.unique(
        lowest_first[:, 0] * vertex_count + lowest_first[:, 1], return_inverse=True
    )

    # Nodes of an edge are numbered from its lower to its higher global vertex; elements may see
    # them reversed.
    along = np.arange(degree - 1)
    reversed_ = (ends[..., 0] > ends[..., 1])[..., None]
    position = np.where(reversed_, along[::-1], along)
    edge_nodes = vertex_count + edge_of.reshape(-1, 3, 1) * (degree - 1) + position

    interior = (degree - 1) * (degree - 2) // 2
    first = vertex_count + len(edges) * (degree - 1)
    interior_nodes = first + np.arange(len(triangles) * interior).reshape(len(triangles), interior)
    cells = np.hstack([triangles, edge_nodes.reshape(len(triangles), -1), interior_nodes])
    return Mesh(degree, triangles, cells, first + len(triangles) * interior)


def elevate(
    triangles: Integers, vertices: Array, degree: int, project: Callable[[Array], Array]
) -> tuple[Mesh, Array]:
    """The P_k mesh that interpolates a surface in its nodes, raised one degree at a time.

    The lattice of degree j + 1 is evaluated on the P_j element and projected: projecting the flat
    lattice of degree 3 or 4 directly inverts elements on coarse tori.

    Parameters
    ----------
    triangles, vertices : (E, 3), (V, 3) a triangulation.
    degree : k.
    project : takes points (N, 3) near the surface onto it.

    Returns
    -------
    The mesh and its nodes (N, 3), all on the surface.
    """
    mesh, x = triangulation(triangles), project(vertices)
    for k in range(2, degree + 1):
        phi, _ = tabulate(k - 1, lattice(k))
        raised = triangulation(triangles, k)
        nodes = np.empty((raised.node_count, 3))
        nodes[raised.cells] = phi @ x[mesh.cells]
        mesh, x = raised, project(nodes)
    return mesh, x
