"""Geometry of a parametrised surface at quadrature points: area element and tangential gradient."""

from dataclasses import dataclass

import numpy as np

from solver.mesh import Mesh
from solver.reference_element import Array, ReferenceElement, reference_element


@dataclass(frozen=True)
class Geometry:
    """Gamma_h[x], or any surface over the reference triangles, seen at the quadrature points.

    Attributes
    ----------
    mesh, element : the topology, and the tables at the Q quadrature points.
    points : (E, Q, 3) positions.
    dA : (E, Q) area element times quadrature weight.
    normal : (E, Q, 3) unit normal of the surface itself (not nu_h), by the orientation of the
        elements.
    B : (E, Q, 3, 2) with J the Jacobian of the element map, B = J (J^T J)^-1: grad u = B du.
    """

    mesh: Mesh
    element: ReferenceElement
    points: Array
    dA: Array
    normal: Array
    B: Array


def from_jacobian(mesh: Mesh, element: ReferenceElement, points: Array, J: Array) -> Geometry:
    """Geometry from positions (E, Q, 3) and Jacobians J[e, p, a, r] = d_r X_a, (E, Q, 3, 2).

    A degenerate element has dA = 0 and non-finite B there; the flow looks for that (`solver.flow`).
    """
    J0, J1 = J[..., 0], J[..., 1]
    N = np.cross(J0, J1)
    det = np.einsum("epa,epa->ep", N, N)  # det J^T J = |J0 x J1|^2
    root = np.sqrt(det)
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = N / root[..., None]
        # The columns of B are the dual basis of J: B0 . J0 = 1, B0 . J1 = 0, tangential.
        B = np.stack([np.cross(J1, N), np.cross(N, J0)], axis=-1) / det[..., None, None]
    return Geometry(mesh, element, points, root * element.weights, normal, B)


def inverse_metric(geo: Geometry) -> tuple[Array, Array, Array]:
    """The entries 00, 01, 11 of (J^T J)^-1 = B^T B, (E, Q) each."""
    B0, B1 = geo.B[..., 0], geo.B[..., 1]
    dot = "epa,epa->ep"
    return np.einsum(dot, B0, B0), np.einsum(dot, B0, B1), np.einsum(dot, B1, B1)


def geometry(mesh: Mesh, x: Array, quadrature_degree: int | None = None) -> Geometry:
    """Geometry of the discrete surface Gamma_h[x] with nodes x (N, 3)."""
    element = reference_element(mesh.degree, quadrature_degree)
    J = np.swapaxes(reference_gradient(mesh, element, x), -1, -2)
    return from_jacobian(mesh, element, values(mesh, element, x), J)


def values(mesh: Mesh, element: ReferenceElement, u: Array) -> Array:
    """Nodal u (N,) or (N, C) -> values at the quadrature points (E, Q) or (E, Q, C)."""
    u_local = u[mesh.cells]
    return u_local @ element.phi.T if u.ndim == 1 else element.phi @ u_local


def reference_gradient(mesh: Mesh, element: ReferenceElement, u: Array) -> Array:
    """Nodal u (N, C) -> reference derivatives d_r u_c at the quadrature points (E, Q, 2, C)."""
    points, directions, n = element.dphi.shape
    du = element.dphi.reshape(-1, n) @ u[mesh.cells]
    return du.reshape(len(mesh.cells), points, directions, -1)


def interpolate(geo: Geometry, u: Array) -> Array:
    """Nodal u (N,) or (N, C) -> values at the quadrature points (E, Q) or (E, Q, C)."""
    return values(geo.mesh, geo.element, u)


def gradient(geo: Geometry, u: Array) -> Array:
    """Tangential gradient of nodal u: (N,) -> (E, Q, 3), (N, C) -> (E, Q, 3, C) as d_a u_c."""
    du = reference_gradient(geo.mesh, geo.element, u.reshape(len(u), -1))
    grad = geo.B[..., 0, None] * du[..., 0, None, :] + geo.B[..., 1, None] * du[..., 1, None, :]
    return grad[..., 0] if u.ndim == 1 else grad
