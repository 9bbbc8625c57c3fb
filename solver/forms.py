"""The paper's F1, F2, f2, g1, g2 (section 3.3, "Matrix-vector formulation"), in the paper's order.

They enter  M u' - A w = F w + f,  M w + A u = g  with u = (H; nu), w = (V; z).
"""

from dataclasses import dataclass

import numpy as np

from solver.assembly import gradient_load, load
from solver.geometry import Geometry, gradient, interpolate
from solver.laws import VelocityLaw
from solver.reference_element import Array

IDENTITY = np.eye(3)


@dataclass(frozen=True)
class Curvature:
    """The fields of u = (H; nu) at the quadrature points, with what the forms need of them.

    ``H, S2, Q`` (E, Q); ``nu, grad_H`` (E, Q, 3); ``S`` (E, Q, 3, 3) the symmetric part of grad nu,
    the paper's A_h; ``S2`` = |S|^2 (Frobenius).
    """

    H: Array
    nu: Array
    grad_H: Array
    S: Array
    S2: Array
    Q: Array


def curvature(geo: Geometry, u: Array, law: VelocityLaw, t: float) -> Curvature:
    """Evaluate u = (H; nu) (N, 4) on Gamma_h, with S = 1/2 (grad nu_h + (grad nu_h)^T)."""
    u_at, grad_u = interpolate(geo, u), gradient(geo, u)
    H, grad_nu = u_at[..., 0], grad_u[..., 1:]
    S = 0.5 * (grad_nu + np.swapaxes(grad_nu, -1, -2))
    S2 = np.einsum("epab,epab->ep", S, S)
    return Curvature(H, u_at[..., 1:], grad_u[..., 0], S, S2, law(H, S2, geo.points, t))


def F1(geo: Geometry, c: Curvature, V: Array) -> Array:
    """- int |S|^2 V phi_j: nodal V (N,) -> dual (N,); right of the H-equation."""
    return load(geo, -c.S2 * interpolate(geo, V))


def F2(geo: Geometry, c: Curvature, z: Array) -> Array:
    """int (H S - S^2) z phi_j: nodal z (N, 3) -> dual (N, 3); right of the nu-equation."""
    z_at = interpolate(geo, z)
    Sz = apply(c.S, z_at)
    return load(geo, c.H[..., None] * Sz - apply(c.S, Sz))


def f2(geo: Geometry, c: Curvature) -> Array:
    """The explicit part of the nu-equation, dual (N, 3), on its right:

    int (|grad H|^2 nu + S^2 grad H) phi_j + 2 int (S grad H) . grad phi_j nu + int Q grad phi_j -
    int Q H nu phi_j.
    """
    S_grad_H = apply(c.S, c.grad_H)
    grad_H2 = np.einsum("epa,epa->ep", c.grad_H, c.grad_H)
    body = (grad_H2 - c.Q * c.H)[..., None] * c.nu + apply(c.S, S_grad_H)
    flux = 2.0 * S_grad_H[..., :, None] * c.nu[..., None, :] + c.Q[..., None, None] * IDENTITY
    return load(geo, body) + gradient_load(geo, flux)


def g1(geo: Geometry, c: Curvature) -> Array:
    """int Q phi_j: dual (N,), right of the V-equation."""
    return load(geo, c.Q)


def g2(geo: Geometry, c: Curvature) -> Array:
    """int |S|^2 nu phi_j: dual (N, 3), right of the z-equation."""
    return load(geo, c.S2[..., None] * c.nu)


def F(geo: Geometry, c: Curvature, w: Array) -> Array:
    """F w = (F1 V; F2 z): nodal w (N, 4) -> dual (N, 4)."""
    return np.column_stack([F1(geo, c, w[:, 0]), F2(geo, c, w[:, 1:])])


def f(geo: Geometry, c: Curvature) -> Array:
    """f = (0; f2), dual (N, 4)."""
    return np.column_stack([np.zeros(geo.mesh.node_count), f2(geo, c)])


def g(geo: Geometry, c: Curvature) -> Array:
    """g = (g1; g2), dual (N, 4)."""
    return np.column_stack([g1(geo, c), g2(geo, c)])


def apply(S: Array, a: Array) -> Array:
    """S a pointwise: (E, Q, 3, 3), (E, Q, 3) -> (E, Q, 3)."""
    return np.einsum("epab,epb->epa", S, a)
