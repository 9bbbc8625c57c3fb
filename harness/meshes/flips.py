"""Delaunay flips on a curved surface, in independent sets, that fold no triangle.

Letters: x and nu (V, 3) vertices and exact normals there, c and d the corners opposite to an edge
a b.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from esfem.solver.mesh import Integers
from esfem.solver.reference_element import Array

DEGREES_ALLOWED = (4, 9)
LEAST_COSINE = 0.3  # fold guard


@dataclass(frozen=True)
class Edges:
    """The F edges a b of a closed triangulation and what lies beside them, each (F,).

    ``left`` is the triangle (c, a, b), ``right`` the triangle (d, b, a), up to rotation.
    """

    a: Integers
    b: Integers
    c: Integers
    d: Integers
    left: Integers
    right: Integers


def edges_of(triangles: Integers) -> Edges:
    """Pair the sides of triangles (E, 3), which must be closed and without double edges."""
    following, previous = triangles[:, [1, 2, 0]].ravel(), triangles[:, [2, 0, 1]].ravel()
    key = np.minimum(following, previous) * (triangles.max() + 1) + np.maximum(following, previous)
    left, right = np.argsort(key, kind="stable").reshape(-1, 2).T
    corner = triangles.ravel()
    return Edges(
        following[left], previous[left], corner[left], corner[right], left // 3, right // 3
    )


def fold_cosines(x: Array, nu: Array, triangles: Integers) -> Array:
    """Least cosine between the normal of a triangle and the exact ones at its corners, (E,)."""
    corners = x[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.maximum(np.linalg.norm(cross, axis=1), np.finfo(float).tiny)
    return np.einsum("ea,eia->ei", cross, nu[triangles]).min(axis=1) / length


def cotangent(x: Array, apex: Integers, a: Integers, b: Integers) -> Array:
    """Cotangent of the angle at ``apex`` over the edge a b, (F,)."""
    s, t = x[a] - x[apex], x[b] - x[apex]
    return np.einsum("fa,fa->f", s, t) / np.linalg.norm(np.cross(s, t), axis=1)


def flippable(x: Array, nu: Array, triangles: Integers, edges: Edges) -> tuple[Integers, Array]:
    """Indices of edges that are not Delaunay and may be flipped, with their cot + cot < 0.

    Refused: an edge c d that exists already, degrees out of 4..9, and folds.
    """
    sums = cotangent(x, edges.c, edges.a, edges.b) + cotangent(x, edges.d, edges.a, edges.b)
    degree = np.bincount(triangles.ravel())
    V = len(x)
    i = np.flatnonzero(sums < -1e-12)  # round-off would flip a square for ever
    a, b, c, d = (corner[i] for corner in (edges.a, edges.b, edges.c, edges.d))
    existing = np.minimum(edges.a, edges.b) * V + np.maximum(edges.a, edges.b)
    is_new = ~np.isin(np.minimum(c, d) * V + np.maximum(c, d), existing)
    fewest, most = DEGREES_ALLOWED
    fits = (np.minimum(degree[a], degree[b]) > fewest) & (np.maximum(degree[c], degree[d]) < most)
    old = fold_cosines(x, nu, triangles)
    old = np.minimum(old[edges.left[i]], old[edges.right[i]])
    new = np.minimum(*(fold_cosines(x, nu, np.stack(t, axis=1)) for t in ((c, a, d), (d, b, c))))
    i = i[is_new & fits & (new >= np.minimum(LEAST_COSINE, old))]
    return i, sums[i]


def independent(corners: Integers, badness: Array, vertices: int) -> NDArray[np.bool_]:
    """Mask of the edges that are worse than all others at each of their four corners (n, 4)."""
    rank = np.empty(len(badness), dtype=np.int64)
    rank[np.argsort(badness, kind="stable")] = np.arange(len(badness))
    best = np.full(vertices, len(badness))
    np.minimum.at(best, corners.ravel(), np.repeat(rank, 4))
    return (best[corners] == rank[:, None]).all(axis=1)


def flip_to_delaunay(x: Array, nu: Array, triangles: Integers, sweeps: int = 100) -> Integers:
    """Flip edges, in sets that share no corner, until all are Delaunay or refused."""
    triangles = triangles.copy()
    for _ in range(sweeps):
        edges = edges_of(triangles)
        i, sums = flippable(x, nu, triangles, edges)
        if len(i) == 0:
            break
        corners = np.stack([edges.a[i], edges.b[i], edges.c[i], edges.d[i]], axis=1)
        chosen = independent(corners, sums, len(x))
        a, b, c, d = corners[chosen].T
        triangles[edges.left[i[chosen]]] = np.stack([c, a, d], axis=1)
        triangles[edges.right[i[chosen]]] = np.stack([d, b, c], axis=1)
    return triangles
