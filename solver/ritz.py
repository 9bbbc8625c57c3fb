"""The velocity as a Ritz projection, in place of its nodal interpolation."""

import scipy.sparse as sp

from esfem.solver.assembly import gradient_load, load
from esfem.solver.direct import factored
from esfem.solver.functionals import length
from esfem.solver.geometry import Geometry, gradient, interpolate
from esfem.solver.reference_element import Array


def ritz_velocity(geo: Geometry, M: sp.csr_array, A: sp.csr_array, V: Array, nu: Array) -> Array:
    """The H^1 Ritz projection v (N, 3) of the product V_h nu_h, which is not in the P_k space:

        int v phi_j / L^2 + int grad v . grad phi_j
            = int V nu phi_j / L^2 + int grad (V nu) . grad phi_j,

    with the length L of the surface, for it shall depend on no unit.

    Parameters
    ----------
    geo, M, A : a surface with its mass and stiffness matrix.
    V, nu : nodal, (N,) and (N, 3).

    References
    ----------
    Kovacs, Li, Lubich, Numer. Math. 143 (2019): the velocity of mean curvature flow.
    """
    V_at, nu_at = interpolate(geo, V), interpolate(geo, nu)
    product = V_at[..., None] * nu_at
    slope = gradient(geo, V)[..., None] * nu_at[..., None, :]
    slope += V_at[..., None, None] * gradient(geo, nu)
    L2 = length(geo) ** 2
    return factored(M / L2 + A)(load(geo, product) / L2 + gradient_load(geo, slope))
