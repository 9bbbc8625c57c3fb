"""What both renderers of pictures share: the view, and curved elements cut into flat triangles."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from harness.reference import lattice_of
from solver import Mesh, State
from solver.mesh import Integers
from solver.reference_element import Array, tabulate

SUBDIVISIONS = 4  # of each side of an element: a curved edge looks curved
DIRECTION = np.array([1.0, -1.6, 0.9])  # from the middle to the eye


@dataclass(frozen=True)
class Box:
    """Middle (3,) and radius of a ball that holds all surfaces of a flow."""

    middle: Array
    radius: float


@dataclass(frozen=True)
class View:
    """Box, range and map of the colours of H, and the side of a picture in pixels."""

    box: Box
    low: float
    high: float
    colours: str
    pixels: int


# Mesh, States, View -> one image (height, width, 3) uint8 a State.
Images = Callable[[Mesh, Sequence[State], View], list[np.ndarray]]


def box_of(states: Sequence[State]) -> Box:
    """The ball about the middle of the first surface that holds all."""
    first = states[0].x
    middle = (first.min(axis=0) + first.max(axis=0)) / 2.0
    radius = max(float(np.linalg.norm(state.x - middle, axis=1).max()) for state in states)
    return Box(middle, radius)


def flattened(mesh: Mesh, state: State) -> tuple[Array, Integers, Array, Array]:
    """Points (P, 3), triangles (T, 3), H and nu there: each element cut into m^2 flat ones."""
    points, triangles = lattice_of(SUBDIVISIONS)
    phi, _ = tabulate(mesh.degree, points)
    offsets = len(points) * np.arange(len(mesh.cells))[:, None, None]
    x, nu = ((phi @ field[mesh.cells]).reshape(-1, 3) for field in (state.x, state.nu))
    H = (state.H[mesh.cells] @ phi.T).ravel()
    return x, (triangles + offsets).reshape(-1, 3), H, nu


def edge_lines(mesh: Mesh) -> Integers:
    """Pairs (L, 2) of points of `flattened` along the curved edges of all elements."""
    points, _ = lattice_of(SUBDIVISIONS)
    barycentric = np.column_stack([1.0 - points.sum(axis=1), points])
    pairs = []
    for i in range(3):
        on_edge = np.flatnonzero(np.abs(barycentric[:, i]) < 1e-12)
        ordered = on_edge[np.argsort(barycentric[on_edge, (i + 1) % 3])]
        pairs += pairwise(ordered)
    offsets = len(points) * np.arange(len(mesh.cells))[:, None, None]
    return (np.array(pairs) + offsets).reshape(-1, 2)
