"""Osculating jets of a triangulation: at each vertex a polynomial graph through it, fitted.

In a frame (e1, e2, n) at the vertex, n the mean normal of its faces, the surface is the graph of

    f(a, b) = sum_{1 <= i + j <= d} c_ij a^i b^j,

fitted by weighted least squares to the vertices of as many rings as give `SURPLUS` times as many
points as coefficients. On a smooth surface sampled with edges of length h its error is O(h^(d+1)),
that of a derivative of order m O(h^(d+1-m)): with d = 5 the normal is of order 5, H of order 4,
grad H of order 3 and Lap H of order 2. Where fewer points are seen from above, d is smaller.

References
----------
Cazals, Pouget, Estimating differential quantities using polynomial fitting of osculating jets,
Comput. Aided Geom. Design 22 (2005).
"""

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from esfem.measuring.location import tangents
from esfem.meshes.soundness import point
from esfem.solver.mesh import Integers
from esfem.solver.reference_element import Array

DEGREE = 5
LEAST_DEGREE = 2
SURPLUS = 1.6  # points per coefficient
MOST_RINGS = 6
SEEN = 0.5  # least cosine between n and the normals of the points that are fitted

POWERS = [(i, m - i) for m in range(1, DEGREE + 1) for i in range(m, -1, -1)]


@dataclass(frozen=True)
class Jets:
    """One jet a vertex: ``origin`` (V, 3), ``frame`` (V, 3, 3) with rows e1, e2, n, the length
    ``scale`` (V,) of its coordinates, ``coefficients`` (V, len(POWERS)), ``degree`` (V,)."""

    origin: Array
    frame: Array
    scale: Array
    coefficients: Array
    degree: Integers

    def derivatives(self, at: Integers, a: Array, b: Array, order: int) -> Array:
        """d_a^i d_b^j f of the jets ``at`` (P,) for i + j <= order, (order+1, order+1, P)."""
        s, c = self.scale[at], self.coefficients[at]
        a, b = a / s, b / s
        result = np.zeros((order + 1, order + 1, len(at)))
        for i in range(order + 1):
            for j in range(order + 1 - i):
                for m, (p, q) in enumerate(POWERS):
                    if p >= i and q >= j:
                        factor = factorial(p) // factorial(p - i) * factorial(q) // factorial(q - j)
                        result[i, j] += factor * c[:, m] * a ** (p - i) * b ** (q - j)
                result[i, j] *= s ** (1.0 - i - j)
        return result

    def local(self, at: Integers, x: Array) -> Array:
        """Coordinates (a, b, height) of x (P, 3) in the frames of the jets ``at``, (P, 3)."""
        return np.einsum("pra,pa->pr", self.frame[at], x - self.origin[at])

    def lifted(self, at: Integers, x: Array) -> Array:
        """The points x (P, 3) moved along n onto the graphs of the jets ``at``."""
        y = self.local(at, x)
        y[:, 2] = self.derivatives(at, y[:, 0], y[:, 1], 0)[0, 0]
        return self.origin[at] + np.einsum("pra,pr->pa", self.frame[at], y)


def fit_jets(vertices: Array, faces: Integers) -> Jets:
    """The jets of all vertices.

    Raises
    ------
    ValueError
        If around a vertex too few others are seen from above: the triangulation is too coarse.
    """
    normals = vertex_normals(vertices, faces)
    frame = np.concatenate([tangents(normals), normals[:, None]], axis=1)
    rings = ring_matrices(faces)
    V = len(vertices)
    scale, coefficients = np.ones(V), np.zeros((V, len(POWERS)))
    degree = np.zeros(V, dtype=np.int64)
    for v in range(V):
        near = neighbours(v, rings, normals)
        y = (vertices[near] - vertices[v]) @ frame[v].T
        fitting = [d for d in range(LEAST_DEGREE, DEGREE + 1) if len(near) >= needed(d)]
        if not fitting:
            raise ValueError(
                f"too coarse to estimate curvature: vertex at {point(vertices[v])} sees {len(near)}"
                f" others within {np.degrees(np.arccos(SEEN)):.0f} degrees of its normal, must be "
                f"at least {needed(LEAST_DEGREE)}"
            )
        degree[v] = fitting[-1]
        scale[v] = np.linalg.norm(y[:, :2], axis=1).max()
        coefficients[v, : coefficient_count(degree[v])] = _fit(y / scale[v], degree[v])
    return Jets(vertices, frame, scale, coefficients, degree)


def coefficient_count(degree: int) -> int:
    """Monomials a^i b^j with 1 <= i + j <= degree."""
    return (degree + 1) * (degree + 2) // 2 - 1


def needed(degree: int) -> int:
    """Points for a fit of that degree."""
    return int(np.ceil(SURPLUS * coefficient_count(degree)))


def vertex_normals(vertices: Array, faces: Integers) -> Array:
    """Unit sums of the normals of the faces around each vertex, weighted by their angles there.

    References
    ----------
    Thuermer, Wuethrich, Computing vertex normals from polygonal facets, J. Graphics Tools 3 (1998).
    """
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    result = np.zeros_like(vertices)
    for i in range(3):
        s, t = (corners[:, (i + j) % 3] - corners[:, i] for j in (1, 2))
        sine = np.linalg.norm(np.cross(s, t), axis=1)
        angle = np.arctan2(sine, np.einsum("ea,ea->e", s, t))
        np.add.at(result, faces[:, i], angle[:, None] * normal)
    return result / np.linalg.norm(result, axis=1, keepdims=True)


def ring_matrices(faces: Integers) -> list[csr_array]:
    """Which vertices lie within 1, 2, ... rings of each other, (V, V) each."""
    V = int(faces.max()) + 1
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    one = csr_array((np.ones(len(start)), (start, end)), shape=(V, V)) + eye_array(V, format="csr")
    rings = [one]
    for _ in range(MOST_RINGS - 1):
        wider = rings[-1] @ one
        wider.data[:] = 1.0
        rings.append(wider.tocsr())
        if rings[-1].nnz >= needed(DEGREE) * 2 * V:
            break
    return rings


def neighbours(v: int, rings: list[csr_array], normals: Array) -> NDArray[np.int32]:
    """The other vertices of the first rings that hold enough of those seen from above v."""
    for ring in rings:
        near = ring.indices[ring.indptr[v] : ring.indptr[v + 1]]
        near = near[(near != v) & (normals[near] @ normals[v] > SEEN)]
        if len(near) >= needed(DEGREE):
            break
    return near


def _fit(y: Array, degree: int) -> Array:
    """Coefficients of the graph through 0 with least squares at points y (n, 3), near ones more."""
    monomials = np.stack([y[:, 0] ** i * y[:, 1] ** j for i, j in POWERS], axis=1)
    monomials = monomials[:, : coefficient_count(degree)]
    weight = 1.0 / np.linalg.norm(y, axis=1)
    return np.linalg.lstsq(monomials * weight[:, None], y[:, 2] * weight, rcond=1e-12)[0]
