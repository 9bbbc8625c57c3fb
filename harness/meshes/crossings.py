"""Does a triangulation cross itself?  Edges against triangles, all pairs that come close."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from esfem.solver.mesh import Integers
from esfem.solver.reference_element import Array


def crossing_pairs(vertices: Array, triangles: Integers) -> Integers:
    """Pairs of triangles (m, 2) that meet without sharing a vertex, each pair once.

    Of two triangles that meet, not in one plane, an edge of one meets the other.

    Parameters
    ----------
    vertices : (V, 3).
    triangles : (E, 3).
    """
    pairs = close_pairs(vertices, triangles)
    corners = vertices[triangles]
    first, second = corners[pairs[:, 0]], corners[pairs[:, 1]]
    meet = np.zeros(len(pairs), dtype=bool)
    for edges, faces in ((first, second), (second, first)):
        for i in range(3):
            meet |= segments_meet(edges[:, i], edges[:, (i + 1) % 3], faces)
    return pairs[meet]


def close_pairs(vertices: Array, triangles: Integers) -> Integers:
    """Pairs (m, 2) of triangles without a common vertex whose bounding boxes overlap."""
    corners = vertices[triangles]
    centre = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    pairs = cKDTree(centre).query_pairs(2.0 * radius.max(), output_type="ndarray")
    i, j = pairs.T
    low, high = corners.min(axis=1), corners.max(axis=1)
    close = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
    pairs = pairs[close]
    i, j = pairs.T
    common = (triangles[i][:, :, None] == triangles[j][:, None, :]).any(axis=(1, 2))
    return pairs[~common]


def segments_meet(p: Array, q: Array, faces: Array) -> NDArray[np.bool_]:
    """Whether each segment p q, both (m, 3), meets its triangle of ``faces`` (m, 3, 3).

    Its ends lie on different sides of the plane of the triangle, and the triangle's sides are all
    to the left or all to the right of its line; touching counts, lying in the plane does not.
    """
    a, b, c = (faces[:, i] for i in range(3))
    above, below = (volume(b - a, c - a, end - a) for end in (p, q))
    sides = np.stack([volume(q - p, s - p, t - p) for s, t in ((a, b), (b, c), (c, a))])
    one_sided = (sides >= 0).all(axis=0) | (sides <= 0).all(axis=0)
    return (above * below <= 0) & (above != below) & one_sided


def volume(a: Array, b: Array, c: Array) -> Array:
    """The triple product (a x b).c, (m,)."""
    return np.einsum("ma,ma->m", np.cross(a, b), c)
