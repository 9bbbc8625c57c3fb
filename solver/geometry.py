"""Geometry of a parametrised surface at quadrature points: area element and tangential gradient."""

from dataclasses import dataclass

import numpy as np

from esfem.solver.mesh import Mesh
from esfem.solver.pointwise import (
    Vector,
    at,
    cross,
    dot,
    empty_field,
    flat,
    formula,
    kernel,
    put,
    times,
)
from esfem.solver.reference_element import Array, ReferenceElement, reference_element


@dataclass(frozen=True)
class Geometry:
    """Gamma_h[x], or any surface over the reference triangles, seen at the quadrature points.

    In memory elements run fastest: the fields are Fortran arrays, see `esfem.solver.pointwise`.

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
    root, normal, B = (empty_field(*J.shape[:2], *shape) for shape in ((), (3,), (3, 2)))
    _frames(flat(J), flat(root), flat(normal), flat(B))
    return Geometry(mesh, element, points, root * element.weights, normal, B)


@kernel
def _frames(start: int, stop: int, J: Array, root: Array, normal: Array, B: Array) -> None:
    for p in range(start, stop):
        root[p], n, B0, B1 = frame(at(J[0], p), at(J[1], p))
        put(normal, p, n)
        put(B[0], p, B0)
        put(B[1], p, B1)


@formula
def frame(J0: Vector, J1: Vector) -> tuple[float, Vector, Vector, Vector]:
    """Area element |J0 x J1|, unit normal, and the dual basis B of the columns of J.

    B0 . J0 = 1, B0 . J1 = 0 and so on, tangential.
    """
    N = cross(J0, J1)
    det = dot(N, N)  # det J^T J = |J0 x J1|^2
    root = np.sqrt(det)
    B0, B1 = cross(J1, N), cross(N, J0)
    return root, times(1.0 / root, N), times(1.0 / det, B0), times(1.0 / det, B1)


def inverse_metric(geo: Geometry) -> tuple[Array, Array, Array]:
    """The entries 00, 01, 11 of (J^T J)^-1 = B^T B, (E, Q) each."""
    G00, G01, G11 = (empty_field(*geo.dA.shape) for _ in range(3))
    _inverse_metric(flat(geo.B), flat(G00), flat(G01), flat(G11))
    return G00, G01, G11


@kernel
def _inverse_metric(start: int, stop: int, B: Array, G00: Array, G01: Array, G11: Array) -> None:
    for p in range(start, stop):
        B0, B1 = at(B[0], p), at(B[1], p)
        G00[p], G01[p], G11[p] = dot(B0, B0), dot(B0, B1), dot(B1, B1)


def geometry(mesh: Mesh, x: Array, quadrature_degree: int | None = None) -> Geometry:
    """Geometry of the discrete surface Gamma_h[x] with nodes x (N, 3)."""
    element = reference_element(mesh.degree, quadrature_degree)
    at = local(mesh, x)
    # Seen from the first node of the element: far from the origin nothing cancels.
    dX = element.dphi.swapaxes(0, 1)[:, None] @ (at - at[:, :1])
    return from_jacobian(mesh, element, (element.phi @ at).T, dX.transpose(3, 2, 1, 0))


def values(mesh: Mesh, element: ReferenceElement, u: Array) -> Array:
    """Nodal u (N,) or (N, C) -> values at the quadrature points (E, Q) or (E, Q, C)."""
    u_at = (element.phi @ local(mesh, u)).T
    return u_at[..., 0] if u.ndim == 1 else u_at


def reference_gradient(mesh: Mesh, element: ReferenceElement, u: Array) -> Array:
    """Nodal u (N, C) -> reference derivatives d_r u_c at the quadrature points (E, Q, 2, C)."""
    du = element.dphi.swapaxes(0, 1)[:, None] @ local(mesh, u)
    return du.transpose(3, 2, 0, 1)


def local(mesh: Mesh, u: Array) -> Array:
    """Nodal u (N,) or (N, C) -> its values in the nodes of each element, (C, n, E)."""
    columns = np.ascontiguousarray(u.reshape(len(u), -1).T)
    return np.take(columns, mesh.cells.T, axis=1)


def interpolate(geo: Geometry, u: Array) -> Array:
    """Nodal u (N,) or (N, C) -> values at the quadrature points (E, Q) or (E, Q, C)."""
    return values(geo.mesh, geo.element, u)


def gradient(geo: Geometry, u: Array) -> Array:
    """Tangential gradient of nodal u: (N,) -> (E, Q, 3), (N, C) -> (E, Q, 3, C) as d_a u_c."""
    du = reference_gradient(geo.mesh, geo.element, u.reshape(len(u), -1))
    grad = geo.B[..., 0, None] * du[..., 0, None, :] + geo.B[..., 1, None] * du[..., 1, None, :]
    return grad[..., 0] if u.ndim == 1 else grad
