"""Numbers of a discrete surface: area, volume, energies, mesh widths, normal lengths."""

import numpy as np

from esfem.solver.geometry import Geometry, interpolate
from esfem.solver.mesh import Mesh
from esfem.solver.reference_element import Array


def area(geo: Geometry) -> float:
    """Area of Gamma_h."""
    return float(geo.dA.sum())


def length(geo: Geometry) -> float:
    """L = sqrt(area / 4 pi): the radius of the sphere of that area."""
    return float(np.sqrt(area(geo) / (4.0 * np.pi)))


def centroid(geo: Geometry) -> Array:
    """int x / area, (3,)."""
    moment: Array = np.einsum("ep,epa->a", geo.dA, geo.points)
    return moment / area(geo)


def centred(x: Array) -> Array:
    """Points (N, 3) less their mean: derivatives are the same, and far from the origin nothing
    cancels."""
    return x - x.mean(axis=0)


def volume(geo: Geometry) -> float:
    """Enclosed volume 1/3 int (x - c) . n with the normal n of Gamma_h itself.

    It is the same about any point c; about the centroid nothing cancels.
    """
    return float(np.einsum("ep,epa,epa->", geo.dA, geo.points - centroid(geo), geo.normal)) / 3.0


def willmore_energy(geo: Geometry, H: Array) -> float:
    """W_h = 1/2 int H_h^2 of nodal H (N,)."""
    return 0.5 * float(np.sum(geo.dA * interpolate(geo, H) ** 2))


def helfrich_energy(geo: Geometry, H: Array, spontaneous_curvature: float) -> float:
    """1/2 int (H_h - H0)^2 of nodal H (N,), H0 the spontaneous curvature."""
    excess = interpolate(geo, H) - spontaneous_curvature
    return 0.5 * float(np.sum(geo.dA * excess**2))


def squared_norm(geo: Geometry, u: Array) -> float:
    """int |u_h|^2 of nodal u, (N,) or (N, C)."""
    at = interpolate(geo, u.reshape(len(u), -1))
    return float(np.einsum("ep,epc,epc->", geo.dA, at, at))


def mesh_width(geo: Geometry) -> float:
    """h = sqrt(4 area / (sqrt(3) E)): the edge of the equilateral triangle of mean area."""
    return float(np.sqrt(4.0 * area(geo) / (np.sqrt(3.0) * len(geo.dA))))


def largest_diameter(mesh: Mesh, x: Array) -> float:
    """The longest distance of two vertices of one element, for nodes x (N, 3)."""
    corners = x[mesh.triangles]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())


def normal_lengths(nu: Array) -> tuple[float, float]:
    """Least and greatest length of the nodal normals (N, 3)."""
    lengths = np.linalg.norm(nu, axis=1)
    return float(lengths.min()), float(lengths.max())
