"""Refusals: what cannot be meshed as a smooth closed surface, and what is no good mesh of it.

All errors are MeshQualityError and say what is wrong and where; the caller adds name and V. A mesh
that crosses itself is found by its edges against its triangles, all pairs that come close.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from esfem.meshes.flips import edges_of, fold_cosines
from esfem.meshes.parameters import connect, parameter_cloud, parameter_cross
from esfem.meshes.surfaces import MeshSurface
from esfem.meshes.triangulation import MeshQualityError
from esfem.solver.mesh import Integers
from esfem.solver.reference_element import Array

SAMPLES = 4000
LEAST_TANGENCY = 0.99  # cosine between the exact normal and that of the embedding
FLATTEST = 1e-6  # least area element over its mean
ON_SURFACE = 1e-9  # of the extent
LARGEST_RISE = 0.5  # of an edge's middle above the surface, in edge lengths


def check_embedding(surface: MeshSurface) -> None:
    """Raise MeshQualityError unless a sample of the embedding is a closed surface, seen outside.

    For genus 0 the sample holds the points on the axes, where formulas have their poles.
    """
    p = parameter_cloud(surface, SAMPLES, np.random.default_rng(0))
    if surface.genus == 0:
        p = np.vstack([np.eye(3), -np.eye(3), p])
    try:
        y, cross = surface.embed(p), parameter_cross(surface, p)
        check_immersion(surface, p, y, np.linalg.norm(cross, axis=1))
        nu = surface.normal(y)
    except ValueError as error:
        raise MeshQualityError(str(error)) from error
    cosine = np.einsum("na,na->n", cross, nu) / np.linalg.norm(cross, axis=1)
    if (cosine < -LEAST_TANGENCY).all():
        raise MeshQualityError("normals point inward: a level set must be negative inside")
    refuse(
        ~(cosine >= LEAST_TANGENCY), "normal and embedding disagree (open, folded or very thin)", y
    )
    check_solid(y, connect(surface, p))


def check_immersion(surface: MeshSurface, p: Array, y: Array, area: Array) -> None:
    """Raise MeshQualityError unless y = embed(p) is finite, closes up and has area elements > 0."""
    refuse(~np.isfinite(y).all(axis=1) | ~np.isfinite(area), "not finite", y)
    for period in np.diag(surface.periods or ()):
        gap = np.abs(surface.embed(p + period) - y).max(axis=1)
        refuse(gap > ON_SURFACE * extent(y), "not closed: the embedding is not periodic", y)
    refuse(area < FLATTEST * area.mean(), "not regular: the embedding has no tangent plane", y)


def refuse(bad: NDArray[np.bool_], fault: str, y: Array) -> None:
    """Raise MeshQualityError naming the first of the points y (n, 3) that is bad (n,)."""
    if bad.any():
        raise MeshQualityError(f"{fault} at {point(y[bad.argmax()])}")


def check_solid(vertices: Array, triangles: Integers) -> None:
    """Raise MeshQualityError unless the mesh is outward and does not cross itself."""
    if enclosed_volume(vertices, triangles) <= 0:
        raise MeshQualityError("normals point inward: the embedding must preserve orientation")
    pairs = crossing_pairs(vertices, triangles)
    if len(pairs) > 0:
        where = point(vertices[triangles[pairs[0, 0]]].mean(axis=0))
        raise MeshQualityError(f"crosses itself: {len(pairs)} pairs of triangles, one at {where}")


def check_mesh(surface: MeshSurface, vertices: Array, triangles: Integers) -> None:
    """Raise MeshQualityError unless the mesh is on the surface, outward, without fold or crossing.

    Every edge must follow the surface: one across the mouth of an open surface does not.
    """
    check_on_surface(surface, vertices)
    check_solid(vertices, triangles)
    edges = edges_of(triangles)
    a, b = vertices[edges.a], vertices[edges.b]
    middle = (a + b) / 2
    rise = np.linalg.norm(surface.project(middle) - middle, axis=1)
    rise /= np.linalg.norm(a - b, axis=1)
    if rise.max() > LARGEST_RISE:
        where = point(middle[rise.argmax()])
        raise MeshQualityError(f"not closed, or too coarse: no surface near the edge at {where}")
    cosines = fold_cosines(vertices, surface.normal(vertices), triangles)
    if cosines.min() <= 0:
        where = point(vertices[triangles[cosines.argmin()]].mean(axis=0))
        raise MeshQualityError(f"{np.sum(cosines <= 0)} inverted elements, one at {where}")


def check_on_surface(surface: MeshSurface, vertices: Array) -> None:
    """Raise MeshQualityError unless the vertices (V, 3) are their own closest points."""
    distance = np.linalg.norm(surface.project(vertices) - vertices, axis=1)
    if not distance.max() <= ON_SURFACE * extent(vertices):
        where = point(vertices[distance.argmax()])
        raise MeshQualityError(f"vertex at {where} is {distance.max():.1e} off the surface")


def extent(y: Array) -> float:
    """The largest distance of points (n, 3) from their mean."""
    return float(np.linalg.norm(y - y.mean(axis=0), axis=1).max())


def enclosed_volume(vertices: Array, triangles: Integers) -> float:
    """Sum of a.(b x c)/6 over the triangles, positive if they are outward; about the mean of the
    vertices, for far from the origin the terms would cancel."""
    x = vertices - vertices.mean(axis=0)
    a, b, c = (x[triangles[:, i]] for i in range(3))
    return float(np.einsum("ea,ea->", a, np.cross(b, c)) / 6.0)


def point(x: Array) -> str:
    """A point (3,) for a message."""
    return "(" + ", ".join(f"{coordinate:.3g}" for coordinate in x) + ")"


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
