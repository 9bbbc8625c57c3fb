"""How good triangles are: radius ratios, angles, and the Jacobians of curved elements."""

import numpy as np

from esfem.meshes.surfaces import MeshSurface
from esfem.solver.mesh import Integers, elevate
from esfem.solver.reference_element import Array, reference_element


def edge_lengths(vertices: Array, triangles: Integers) -> Array:
    """Lengths of the sides of each triangle, side i opposite to corner i, (E, 3)."""
    corners = vertices[triangles]
    return np.linalg.norm(corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]], axis=2)


def radius_ratios(vertices: Array, triangles: Integers) -> Array:
    """q = 2 r_in / r_circ = 8 (s - a)(s - b)(s - c) / (a b c), s = (a + b + c)/2, (E,)."""
    a, b, c = edge_lengths(vertices, triangles).T
    s = (a + b + c) / 2
    return 8.0 * (s - a) * (s - b) * (s - c) / (a * b * c)


def angles(vertices: Array, triangles: Integers) -> Array:
    """Angles of each triangle in degrees, (E, 3), by the law of cosines."""
    a, b, c = edge_lengths(vertices, triangles).T
    cosines = [(v**2 + w**2 - u**2) / (2 * v * w) for u, v, w in ((a, b, c), (b, c, a), (c, a, b))]
    return np.degrees(np.arccos(np.clip(np.stack(cosines, axis=1), -1.0, 1.0)))


def curved_qualities(surface: MeshSurface, vertices: Array, triangles: Integers, k: int) -> Array:
    """Scaled Jacobian of each P_k element on the surface, (E,), in [-1, 1]; 1 is best.

    min_p (d_r X x d_s X) . nu  /  max_p |d_r X x d_s X|  over the points p of the rule of degree
    2k + 2, with nu the exact outward normal at the closest point of X(p). It sees a varying area
    element and tilt, and is not positive if the element is inverted somewhere.
    """
    element = reference_element(k)
    mesh, nodes = elevate(triangles, vertices, k, surface.project)
    X = element.phi @ nodes[mesh.cells]
    tangents = np.einsum("pri,eia->repa", element.dphi, nodes[mesh.cells])
    cross = np.cross(tangents[0], tangents[1])
    nu = surface.normal(surface.project(X.reshape(-1, 3))).reshape(X.shape)
    signed = np.einsum("epa,epa->ep", cross, nu)
    return signed.min(axis=1) / np.linalg.norm(cross, axis=2).max(axis=1)
