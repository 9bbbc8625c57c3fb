"""The distance of points to Gamma_h[x], by projection onto its curved elements.

The nearest point of an element lies inside, on an edge or in a corner: Gauss and Newton's method
looks for it inside, and where it finds none in any element near, on their edges. It leaves out
second derivatives, times the distance: a step gains a factor of distance times curvature. All that
it finds are points of the surface, so that no distance comes out too small.
"""

from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from esfem.measuring.location import BOX, CONVERGED, evaluate, least_barycentric, solve
from esfem.solver import Mesh
from esfem.solver.mesh import REFERENCE_EDGES, Integers
from esfem.solver.reference_element import Array, tabulate

SUBDIVISIONS = 6  # of each side of an element, in the lattice of points from which it starts
NEAREST = 12  # points of the lattice: in a corner several elements meet in one
ITERATIONS = 8
CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def distance_to_surface(mesh: Mesh, x: Array, y: Array) -> Array:
    """The distance (M,) of points y (M, 3) to the surface with nodes x (N, 3)."""
    lattice = lattice_points(SUBDIVISIONS)
    points = lattice_surface(mesh, x)
    found, near = cKDTree(points).query(y, k=min(NEAREST, len(points)))
    cell, start = np.divmod(np.asarray(near), len(lattice))
    least, open_ = np.array(np.asarray(found)[:, 0]), np.arange(len(y))
    for close in (_inside, _on_edges):
        met = np.zeros(len(y), dtype=bool)
        for j in range(cell.shape[1]):
            tried = (cell[open_, j, None] == cell[open_, :j]).any(axis=1)
            i = open_[~tried]
            distance = close(mesh, x, y[i], cell[i, j], lattice[start[i, j]])
            least[i] = np.minimum(least[i], distance)
            met[i] |= np.isfinite(distance)
        open_ = np.flatnonzero(~met)
    return least


def lattice_surface(mesh: Mesh, x: Array) -> Array:
    """Points (E P, 3) of all elements on the lattice, an element's together."""
    phi, _ = tabulate(mesh.degree, lattice_points(SUBDIVISIONS))
    return (phi @ x[mesh.cells]).reshape(-1, 3)


@lru_cache
def lattice_points(m: int) -> Array:
    """The points (P, 2) of the reference triangle at distances 1/m."""
    return np.array([(i, j) for j in range(m + 1) for i in range(m + 1 - j)], float) / m


def _inside(mesh: Mesh, x: Array, y: Array, cell: Integers, xi: Array) -> Array:
    """Distances (P,) of y (P, 3) to points inside one cell (P,) each; inf where there is none."""
    for _ in range(ITERATIONS):
        X, dX = evaluate(mesh, x, cell, xi)
        metric = dX @ np.swapaxes(dX, 1, 2)
        along = np.einsum("pra,pa->pr", dX, y - X)
        step = solve(metric, along)[0]
        xi = np.clip(xi + step, *BOX)
        if not np.any(np.abs(step) > CONVERGED):
            break
    X, _ = evaluate(mesh, x, cell, xi)
    return np.where(least_barycentric(xi) >= 0.0, np.linalg.norm(y - X, axis=1), np.inf)


def _on_edges(mesh: Mesh, x: Array, y: Array, cell: Integers, xi: Array) -> Array:
    """Distances (P,) to the nearest points found on the edges of the cells, ends included."""
    least = np.full(len(y), np.inf)
    for a, b in CORNERS[REFERENCE_EDGES]:
        side = b - a
        s = np.clip((xi - a) @ side / (side @ side), 0.0, 1.0)
        for _ in range(ITERATIONS):
            X, dX = evaluate(mesh, x, cell, a + s[:, None] * side)
            X_s = np.einsum("r,pra->pa", side, dX)
            step = np.einsum("pa,pa->p", X_s, y - X) / np.einsum("pa,pa->p", X_s, X_s)
            s = np.clip(s + step, 0.0, 1.0)
            if not np.any(np.abs(step) > CONVERGED):
                break
        X, _ = evaluate(mesh, x, cell, a + s[:, None] * side)
        least = np.minimum(least, np.linalg.norm(y - X, axis=1))
    return least
