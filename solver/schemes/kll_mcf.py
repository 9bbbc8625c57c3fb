"""Kovacs, Li, Lubich: mean curvature flow by evolution equations for nu and H.

References
----------
Kovacs, Li, Lubich, A convergent evolving finite element algorithm for mean curvature flow of closed
surfaces, Numer. Math. 143 (2019).
"""

from collections.abc import Sequence

import numpy as np

from esfem.solver.assembly import load, mass_matrix, stiffness_matrix
from esfem.solver.bdf import BDF, combine, extrapolation_weights
from esfem.solver.direct import factored
from esfem.solver.forms import curvature
from esfem.solver.geometry import Geometry, geometry, interpolate
from esfem.solver.laws import surface_diffusion
from esfem.solver.mesh import Mesh
from esfem.solver.reference_element import Array
from esfem.solver.ritz import ritz_velocity


def reaction(geo: Geometry, u: Array) -> Array:
    """f = int |S|^2 u phi_j, dual (N, 4), of nodal u = (H; nu) with S that of nu."""
    S2 = curvature(geo, u, surface_diffusion, 0.0).S2  # that law has no Q: only S is used
    return load(geo, S2[..., None] * interpolate(geo, u))


def step(
    mesh: Mesh,
    x: Sequence[Array],
    u: Sequence[Array],
    tau: float,
    bdf: BDF,
    ritz: bool,
    quadrature_degree: int | None = None,
) -> tuple[Array, Array, Array]:
    """x, v (N, 3) and u = (H; nu) (N, 4) at t from those at t - tau, t - 2 tau, ..., q of each.

    On Gamma_h[x_ext], with f of u_ext:

        (delta_0 / tau M + A) u^n = f - M (1/tau) sum_{j>=1} delta_j u^{n-j},
        x^n = (tau v^n - sum_{j>=1} delta_j x^{n-j}) / delta_0,

    and v^n the Ritz projection of -H^n nu^n, or -H^n nu^n in the nodes.

    Raises
    ------
    ArithmeticError
        If the factorisation fails.
    """
    delta, gamma = [float(d) for d in bdf.delta], [float(g) for g in bdf.gamma]
    geo = geometry(mesh, combine(gamma, x), quadrature_degree)
    M, A = mass_matrix(geo), stiffness_matrix(geo)
    right = reaction(geo, combine(gamma, u)) - M @ combine(delta[1:], u) / tau
    u_new = factored(delta[0] / tau * M + A)(right)
    V, nu = -u_new[:, 0], u_new[:, 1:]
    v = ritz_velocity(geo, M, A, V, nu) if ritz else V[:, None] * nu
    return (tau * v - combine(delta[1:], x)) / delta[0], v, np.ascontiguousarray(u_new)


def start_step(
    mesh: Mesh, x: Array, u: Array, tau: float, q: int, ritz: bool, quadrature: int | None = None
) -> tuple[Array, Array, Array]:
    """x, v and u = (H; nu) at t from x and u at t - tau alone, with a local error of order tau^q.

    As start values of BDF q, q > 1, need it: BDF1 with 1..q-1 substeps, extrapolated (see
    `esfem.solver.bdf.extrapolation_weights`).

    Raises
    ------
    ArithmeticError
        If the factorisation fails.
    """
    euler, results = BDF.of_order(1), []
    for m in range(1, q):
        x_m, u_m = x, u
        for _ in range(m):
            x_m, v_m, u_m = step(mesh, [x_m], [u_m], tau / m, euler, ritz, quadrature)
        results.append((x_m, v_m, u_m))
    weights = extrapolation_weights(q - 1)
    x_new, v_new, u_new = (combine(weights, column) for column in zip(*results, strict=True))
    return x_new, v_new, u_new
