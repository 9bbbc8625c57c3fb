"""The parameter domain of a surface: the unit sphere, or a periodic rectangle; p are parameters."""

import numpy as np
from scipy.spatial import ConvexHull, Delaunay

from esfem.meshes.surfaces import MeshSurface
from esfem.solver.mesh import Integers
from esfem.solver.reference_element import Array


def parameter_cloud(surface: MeshSurface, count: int, rng: np.random.Generator) -> Array:
    """Uniform random parameters, (count, 3) on S^2 or (count, 2) in the rectangle."""
    if surface.genus == 0:
        p = rng.standard_normal((count, 3))
        return p / np.linalg.norm(p, axis=1, keepdims=True)
    return rng.random((count, 2)) * np.array(surface.periods)


def parameter_cross(surface: MeshSurface, p: Array) -> Array:
    """d_1 embed x d_2 embed in orthonormal parameter directions, (N, 3), by central differences.

    The directions are right-handed from outside, so that it points outward.
    """
    if surface.genus == 0:
        helper = np.eye(3)[np.abs(p).argmin(axis=1)]
        first = np.cross(p, helper)
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        directions = (first, np.cross(p, first))
    else:
        directions = (np.array([1.0, 0.0]), np.array([0.0, 1.0]))
    eps = 1e-5  # leaving S^2 by eps^2/2 only: the cosine of the step

    def derivative(s: Array) -> Array:
        return (surface.embed(p + eps * s) - surface.embed(p - eps * s)) / (2.0 * eps)

    first, second = map(derivative, directions)
    return np.cross(first, second)


def area_elements(surface: MeshSurface, p: Array) -> Array:
    """|d_1 embed x d_2 embed| in orthonormal parameter directions, (N,)."""
    return np.linalg.norm(parameter_cross(surface, p), axis=1)


def connect(surface: MeshSurface, p: Array) -> Integers:
    """Delaunay triangles (E, 3) in the parameter domain, counter-clockwise seen from outside."""
    if surface.genus == 0:
        triangles = ConvexHull(p).simplices.astype(np.int64)
        flipped = np.linalg.det(p[triangles]) < 0
    else:
        shifts = np.array([(i, j) for i in (0, 1, -1) for j in (0, 1, -1)]) * surface.periods
        copies = (p + shifts[:, None]).reshape(-1, 2)
        simplices = Delaunay(copies).simplices.astype(np.int64)
        # Of the translates of a triangle, that with its vertex of least index in the middle copy,
        # which comes first.
        least = np.take_along_axis(simplices, (simplices % len(p)).argmin(axis=1)[:, None], axis=1)
        simplices = simplices[least[:, 0] < len(p)]
        s, t = (copies[simplices[:, i]] - copies[simplices[:, 0]] for i in (1, 2))
        flipped = s[:, 0] * t[:, 1] < s[:, 1] * t[:, 0]
        triangles = simplices % len(p)
    triangles[flipped] = triangles[flipped][:, ::-1]
    return triangles
