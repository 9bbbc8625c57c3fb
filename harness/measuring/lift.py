"""Errors on the exact surface by the lift (paper, section 3.5), without geometric crimes.

The exact surface is parametrised over the reference triangles by Y = closest_point(X_h*), X_h* the
interpolation of the exact nodes x_j* = X(p_j, t).  Then the lift of u_h is sum_j u_j phi_j as a
function of the reference point, and its tangential gradient on Gamma(t) is
J_Y (J_Y^T J_Y)^-1 d u_h with J_Y = D closest_point(X_h*) J: the norms are those of H^1(Gamma(t)),
exact up to quadrature.

Beside them stand the norms of u_h - I_h u, the error against the interpolation, in H^1(Gamma_h*) on
the surface interpolated in the exact nodes: what is left when interpolation is taken away. In the
paper's matrix-vector form they are the norms of its nodal error e_u = u - u*.

Both are kept as the norm in L^2 and the seminorm, |grad e| in L^2, for these have different units:
they make a norm in H^1 only with a unit of length L, |e|^2 / L^2 + |grad e|^2. That of a surface is
L = sqrt(area(Gamma(0)) / 4 pi), `InitialSurface.length`: 1 on the unit sphere, and errors on
surfaces that differ in size alone differ by a factor alone.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeGuard, TypeVar

import numpy as np
import scipy.sparse as sp

from esfem.reference_solutions import ExactSolution, Fields, InitialSurface
from esfem.solver import Mesh, State
from esfem.solver.assembly import mass_matrix, stiffness_matrix
from esfem.solver.geometry import (
    Geometry,
    from_jacobian,
    geometry,
    interpolate,
    inverse_metric,
    reference_gradient,
    values,
)
from esfem.solver.reference_element import Array, reference_element

# The columns of the stacked unknowns, in the order of the paper's theorem.
VARIABLES: dict[str, slice] = {
    "x": slice(0, 3),
    "nu": slice(3, 6),
    "H": slice(6, 7),
    "V": slice(7, 8),
    "z": slice(8, 11),
    "v": slice(11, 14),
}

# Numbers of order one and their errors are rounding below this: nodal values that are solved for
# carry 1e-14 to 1e-13 of the block solve, those that are exact or normalised a few 1e-16.
ROUNDING = 1e-12

AtTime = TypeVar("AtTime")


class Norms(NamedTuple):
    """|e| and |grad e| in L^2."""

    l2: float
    seminorm: float

    def h1(self, length: float) -> float:
        """The norm sqrt(|e|^2 / L^2 + |grad e|^2) with the unit of length L."""
        return float(np.hypot(self.l2 / length, self.seminorm))


def in_h1(
    l2: Mapping[str, Sequence[float]], seminorm: Mapping[str, Sequence[float]], length: float
) -> dict[str, list[float]]:
    """Norms in H^1 from series of both, by variable."""
    return {
        name: [Norms(*pair).h1(length) for pair in zip(l2[name], seminorm[name], strict=True)]
        for name in l2
    }


ByVariable = dict[str, Norms]


def is_exact(solution: InitialSurface) -> TypeGuard[ExactSolution]:
    """Whether it solves the law exactly at all times."""
    return solution.always_exact


@dataclass(frozen=True)
class LiftedSurface:
    """Gamma(t) over the reference triangles, with the exact unknowns in the columns of `VARIABLES`.

    ``exact`` (E, Q, 14) are the values at Y, ``d_exact`` (E, Q, 2, 14) the reference derivatives
    J_Y^T grad of them; ``metric`` (3, E, Q) are the entries 00, 01, 11 of (J_Y^T J_Y)^-1 times the
    area element and weight: |grad e|^2 = de^T (J_Y^T J_Y)^-1 de, for the gradient is tangential.
    """

    geometry: Geometry
    exact: Array
    d_exact: Array
    metric: Array


def error_quadrature(degree: int) -> int:
    """Exactness of the quadrature of the norms: 2k + 4, two more than that of assembly."""
    return 2 * degree + 4


def lifted_surface(mesh: Mesh, solution: ExactSolution, x_star: Array, t: float) -> LiftedSurface:
    """Parametrise Gamma(t) from the exact nodes x_star (N, 3) at time t."""
    element = reference_element(mesh.degree, error_quadrature(mesh.degree))
    points = values(mesh, element, x_star)
    J = np.swapaxes(reference_gradient(mesh, element, x_star), -1, -2)
    Y = solution.closest_point(points, t)
    J_Y = solution.closest_point_derivative(points, t) @ J
    geo = from_jacobian(mesh, element, Y, J_Y)
    exact, gradient = _stack_exact(Y, solution.fields(Y, t))
    d_exact = np.swapaxes(J_Y, -1, -2) @ gradient
    return LiftedSurface(geo, exact, d_exact, weighted_metric(geo))


def errors(surface: LiftedSurface, state: State) -> ByVariable:
    """The norms on Gamma(t) of the error of each variable, at the time of the surface.

    Those of vectors by the Euclidean and the Frobenius norm; the position is compared with the
    identity, whose gradient is the tangential projection.
    """
    u = unknowns(state)
    geo = surface.geometry
    e = interpolate(geo, u) - surface.exact
    de = reference_gradient(geo.mesh, geo.element, u) - surface.d_exact
    return norms_by_variable(*squared_norms(geo, surface.metric, e, de))


@dataclass(frozen=True)
class Interpolation:
    """The exact State in the nodes, and M and A of the surface interpolated there."""

    nodes: State
    mass: sp.csr_array
    stiffness: sp.csr_array


def interpolation(
    mesh: Mesh, solution: ExactSolution, x_star: Array, t: float, quadrature: int | None = None
) -> Interpolation:
    """The interpolation in the exact nodes x_star (N, 3); quadrature as in `geometry`."""
    geo = geometry(mesh, x_star, quadrature)
    return Interpolation(exact_state(solution, x_star, t), mass_matrix(geo), stiffness_matrix(geo))


def nodal_errors(exact: Interpolation, state: State) -> ByVariable:
    """The norms of u_h - I_h u for each variable, at the time of the interpolation."""
    e = unknowns(state) - unknowns(exact.nodes)
    return nodal_norms(exact.mass, exact.stiffness, e)


def nodal_norms(mass: sp.csr_array, stiffness: sp.csr_array, e: Array) -> ByVariable:
    """The norms of the function with nodal values e (N, 14), by M and A of a surface."""
    l2, seminorm = (np.einsum("jc,jc->c", e, matrix @ e) for matrix in (mass, stiffness))
    return norms_by_variable(np.maximum(l2, 0.0), np.maximum(seminorm, 0.0))


def at_time(solution: ExactSolution, make: Callable[[float], AtTime]) -> Callable[[float], AtTime]:
    """t -> what ``make`` gives there; of a surface at rest it is made once."""
    if not solution.stationary:
        return make
    at_rest = make(0.0)
    return lambda t: at_rest


def exact_surfaces(
    mesh: Mesh, p: Array, solution: ExactSolution
) -> Callable[[float], tuple[LiftedSurface, Interpolation]]:
    """t -> Gamma(t) for `errors` and for `nodal_errors`, with nodes that start at p (N, 3)."""
    X, quadrature = solution.trajectories(p), error_quadrature(mesh.degree)

    def exact(t: float) -> tuple[LiftedSurface, Interpolation]:
        x = X(t)
        lifted = lifted_surface(mesh, solution, x, t)
        return lifted, interpolation(mesh, solution, x, t, quadrature)

    return at_time(solution, exact)


def unknowns(state: State) -> Array:
    """The nodal unknowns (N, 14) in the columns of `VARIABLES`."""
    return np.column_stack([state.x, state.nu, state.H, state.V, state.z, state.v])


def weighted_metric(geo: Geometry) -> Array:
    """The entries 00, 01, 11 of (J^T J)^-1 times dA, (3, E, Q)."""
    return geo.dA * np.stack(inverse_metric(geo))


def squared_norms(geo: Geometry, metric: Array, e: Array, de: Array) -> tuple[Array, Array]:
    """int e_c^2 and int |grad e_c|^2 = int de_c^T (J^T J)^-1 de_c, (C,) each.

    From values e (E, Q, C), reference derivatives de (E, Q, 2, C) and `weighted_metric`.
    """
    d0, d1 = de[..., 0, :], de[..., 1, :]
    m00, m01, m11 = metric
    seminorm = _sum(m00, d0 * d0) + 2.0 * _sum(m01, d0 * d1) + _sum(m11, d1 * d1)
    return _sum(geo.dA, e * e), seminorm


def norms_by_variable(l2: Array, seminorm: Array) -> ByVariable:
    """The norms of each variable from the `squared_norms` (14,) of its columns."""
    return {
        name: Norms(float(np.sqrt(l2[c].sum())), float(np.sqrt(seminorm[c].sum())))
        for name, c in VARIABLES.items()
    }


def _sum(weight: Array, integrand: Array) -> Array:
    """sum_ep weight_ep integrand_epc: (E, Q), (E, Q, C) -> (C,)."""
    return weight.ravel() @ integrand.reshape(weight.size, -1)


def _stack_exact(Y: Array, f: Fields) -> tuple[Array, Array]:
    """Exact values (E, Q, 14) and gradients (E, Q, 3, 14) in the columns of `VARIABLES`."""
    tangential = np.eye(3) - f.nu[..., :, None] * f.nu[..., None, :]
    exact = np.concatenate([Y, f.nu, f.H[..., None], f.V[..., None], f.z, f.v], axis=-1)
    gradients = [tangential, f.S, f.z[..., None], f.grad_V[..., None], f.grad_z, f.grad_v]
    return exact, np.concatenate(gradients, axis=-1)


def exact_state(solution: ExactSolution, x: Array, t: float) -> State:
    """The exact nodal values at time t in the exact nodes x (N, 3) on Gamma(t)."""
    f = solution.fields(x, t)
    return State(t, x, f.nu, f.H, f.V, f.z)
