"""The paper's F1, F2, f2, g1, g2 (section 3.3, "Matrix-vector formulation"), in the paper's order.

They enter  M u' - A w = F w + f,  M w + A u = g  with u = (H; nu), w = (V; z).  Each is a formula
at one quadrature point for what is integrated against phi_j (f2 also against grad phi_j); kernels
evaluate all that stand on one side together, and one product with the tables integrates.
"""

from dataclasses import dataclass

import numpy as np

from esfem.solver.assembly import scatter
from esfem.solver.geometry import Geometry, local, reference_gradient, values
from esfem.solver.laws import AnyLaw, with_split
from esfem.solver.pointwise import (
    Matrix,
    Vector,
    apply,
    at,
    dot,
    empty_field,
    flat,
    formula,
    kernel,
    matrix_at,
    matrix_plus,
    matrix_times,
    plus,
    put,
    put_matrix,
    square,
    times,
    transpose,
)
from esfem.solver.reference_element import Array


@formula
def F1(S2: float, V: float) -> float:
    """- int |S|^2 V phi_j; right of the H-equation."""
    return -S2 * V


@formula
def F2(H: float, S: Matrix, z: Vector) -> Vector:
    """int (H S - S^2) z phi_j; right of the nu-equation."""
    Sz = apply(S, z)
    return plus(times(H, Sz), times(-1.0, apply(S, Sz)))


@formula
def g1_slope(q: float, H: float) -> float:
    """int q H phi_j, the part of g1 that is linear in H; right of the V-equation."""
    return q * H


@formula
def f2(H: float, nu: Vector, grad_H: Vector, S: Matrix, Q: float) -> Vector:
    """int (|grad H|^2 nu + S^2 grad H) phi_j - int Q H nu phi_j; right of the nu-equation, with

    `f2_flux`, the integrals against grad phi_j.
    """
    S_grad_H = apply(S, grad_H)
    return plus(times(dot(grad_H, grad_H) - Q * H, nu), apply(S, S_grad_H))


@formula
def f2_flux(nu: Vector, grad_H: Vector, S: Matrix, Q: float, b: Vector) -> Vector:
    """2 int (S grad H) . grad phi_j nu + int Q grad phi_j, for grad phi_j = b d_r phi_j."""
    return plus(times(2.0 * dot(apply(S, grad_H), b), nu), times(Q, b))


@formula
def g1(Q: float) -> float:
    """int Q phi_j; right of the V-equation."""
    return Q


@formula
def g2(S2: float, nu: Vector) -> Vector:
    """int |S|^2 nu phi_j; right of the z-equation."""
    return times(S2, nu)


@formula
def shape_operator(grad_nu: Matrix) -> Matrix:
    """S = 1/2 (grad nu_h + (grad nu_h)^T).  Paper: A_h."""
    return matrix_times(0.5, matrix_plus(grad_nu, transpose(grad_nu)))


@dataclass(frozen=True)
class Curvature:
    """The fields of u = (H; nu) at the quadrature points, with what the forms need of them.

    ``H, S2, Q, q`` (E, Q); ``nu, grad_H`` (E, Q, 3); ``S`` (E, Q, 3, 3) the symmetric part of grad
    nu, the paper's A_h; ``S2`` = |S|^2 (Frobenius).
    """

    H: Array
    nu: Array
    grad_H: Array
    S: Array
    S2: Array
    Q: Array
    q: Array


def curvature(geo: Geometry, u: Array, law: AnyLaw, t: float) -> Curvature:
    """Evaluate u = (H; nu) (N, 4) on Gamma_h."""
    u_at = values(geo.mesh, geo.element, u)
    du = reference_gradient(geo.mesh, geo.element, u).swapaxes(-1, -2)
    grad_H, S, S2 = (empty_field(*geo.dA.shape, *shape) for shape in ((3,), (3, 3), ()))
    _curvature(flat(geo.B), flat(du), flat(grad_H), flat(S), flat(S2))
    H, nu = u_at[..., 0], u_at[..., 1:]
    at, law = (H, S2, geo.points, t), with_split(law)
    return Curvature(H, nu, grad_H, S, S2, law.Q(*at), law.q(*at))


@kernel
def _curvature(
    start: int, stop: int, B: Array, du: Array, grad_H: Array, S: Array, S2: Array
) -> None:
    for p in range(start, stop):
        B0, B1 = at(B[0], p), at(B[1], p)
        nu0, nu1 = at(du[0, 1:], p), at(du[1, 1:], p)
        put(grad_H, p, plus(times(du[0, 0, p], B0), times(du[1, 0, p], B1)))
        grad_nu = (
            plus(times(B0[0], nu0), times(B1[0], nu1)),
            plus(times(B0[1], nu0), times(B1[1], nu1)),
            plus(times(B0[2], nu0), times(B1[2], nu1)),
        )
        S_p = shape_operator(grad_nu)
        S2[p] = square(S_p)
        put_matrix(S, p, S_p)


def F(geo: Geometry, c: Curvature, w: Array) -> Array:
    """F w = (F1 V; F2 z): nodal w (N, 4) -> dual (N, 4)."""
    return scatter(geo.mesh, local_F(geo, c, w))


def local_F(geo: Geometry, c: Curvature, w: Array) -> Array:
    """`F` by element, (4, n, E)."""
    w_at = geo.element.phi @ local(geo.mesh, w)
    _reaction(w_at.reshape(4, -1), flat(geo.dA), flat(c.H), flat(c.S), flat(c.S2))
    return geo.element.phi.T @ w_at


@kernel
def _reaction(start: int, stop: int, w: Array, dA: Array, H: Array, S: Array, S2: Array) -> None:
    for p in range(start, stop):
        w[0, p] = dA[p] * F1(S2[p], w[0, p])
        put(w[1:], p, times(dA[p], F2(H[p], matrix_at(S, p), at(w[1:], p))))


def local_linear(geo: Geometry, c: Curvature, pair: Array) -> Array:
    """F1 V and int q H phi_j by element, (2, n, E), of the nodal pair (H, V) (N, 2)."""
    at = geo.element.phi @ local(geo.mesh, pair)
    _linear(at.reshape(2, -1), flat(geo.dA), flat(c.S2), flat(c.q))
    return geo.element.phi.T @ at


@kernel
def _linear(start: int, stop: int, pair: Array, dA: Array, S2: Array, q: Array) -> None:
    for p in range(start, stop):
        H, V = pair[0, p], pair[1, p]
        pair[0, p], pair[1, p] = dA[p] * F1(S2[p], V), dA[p] * g1_slope(q[p], H)


def loads(geo: Geometry, c: Curvature) -> tuple[Array, Array]:
    """f = (0; f2) and g = (g1; g2), dual (N, 4) each."""
    return loads_of(scatter(geo.mesh, local_loads(geo, c)))


def loads_of(columns: Array) -> tuple[Array, Array]:
    """f = (0; f2) and g = (g1; g2) from the columns f2, g1, g2, (N, 7)."""
    return np.column_stack([np.zeros(len(columns)), columns[:, :3]]), columns[:, 3:]


def local_loads(geo: Geometry, c: Curvature) -> Array:
    """f2, g1 and g2 by element, (7, n, E)."""
    E, Q = geo.dA.shape
    at_phi, at_dphi = np.empty((7, Q, E)), np.empty((2, 3, Q, E))
    fields = (flat(a) for a in (geo.dA, geo.B, c.H, c.nu, c.grad_H, c.S, c.S2, c.Q))
    _loads(at_phi.reshape(7, -1), at_dphi.reshape(2, 3, -1), *fields)
    local = geo.element.phi.T @ at_phi
    for r in range(2):
        local[:3] += geo.element.dphi[:, r].T @ at_dphi[r]
    return local


@kernel
def _loads(
    start: int,
    stop: int,
    at_phi: Array,
    at_dphi: Array,
    dA: Array,
    B: Array,
    H: Array,
    nu: Array,
    grad_H: Array,
    S: Array,
    S2: Array,
    Q: Array,
) -> None:
    for p in range(start, stop):
        n, dH, S_p = at(nu, p), at(grad_H, p), matrix_at(S, p)
        put(at_phi[:3], p, times(dA[p], f2(H[p], n, dH, S_p, Q[p])))
        at_phi[3, p] = dA[p] * g1(Q[p])
        put(at_phi[4:], p, times(dA[p], g2(S2[p], n)))
        for r in range(2):
            put(at_dphi[r], p, times(dA[p], f2_flux(n, dH, S_p, Q[p], at(B[r], p))))
