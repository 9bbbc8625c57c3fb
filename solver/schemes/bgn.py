"""Barrett, Garcke, Nuernberg: x and H, with nodes that slide.  Paper: eq:BGN alg.

The velocity is tested in normal direction alone, and H nu = -Lap x as a vector: so the tangential
motion is what makes Gamma_h discretely conformal. The laws are V = Lap H + Q: with Q = 0 this is
the scheme for surface diffusion.

References
----------
Barrett, Garcke, Nuernberg, Parametric approximation of Willmore flow and related geometric
evolution equations, SIAM J. Sci. Comput. 31 (2008); for surface diffusion J. Comput. Phys. 222
(2007).
"""

import numpy as np
import scipy.sparse as sp

from esfem.solver.assembly import gradient_load, load, mass_matrix, stiffness_matrix
from esfem.solver.direct import factored
from esfem.solver.functionals import centred, length
from esfem.solver.geometry import Geometry, interpolate
from esfem.solver.laws import AnyLaw
from esfem.solver.reference_element import Array


def weingarten(geo: Geometry, H: Array) -> Array:
    """A (N, 3, 3), symmetric: int A . phi = -int n . div phi + int H n . (phi n), symmetric phi.

    ``H`` (N,) nodal; div phi has the components sum_a d_a phi_ab.
    """
    n, H_at = geo.normal, interpolate(geo, H)
    nn = n[..., :, None] * n[..., None, :]
    loads = load(geo, (H_at[..., None, None] * nn).reshape(*H_at.shape, 9))
    fluxes = np.einsum("ac,epb->epcab", np.eye(3), n).reshape(*H_at.shape, 3, 9)
    A = factored(mass_matrix(geo))(loads - gradient_load(geo, fluxes)).reshape(-1, 3, 3)
    return 0.5 * (A + A.swapaxes(1, 2))


def nonlinear(geo: Geometry, H: Array, law: AnyLaw, t: float) -> Array:
    """int Q(H, |A|^2, x, t) phi_j, dual (N,)."""
    A = interpolate(geo, weingarten(geo, H).reshape(-1, 9))
    return load(geo, law(interpolate(geo, H), np.sum(A**2, axis=-1), geo.points, t))


def step(
    geo: Geometry, x: Array, H: Array, tau: float, law: AnyLaw, t: float
) -> tuple[Array, Array]:
    """x (N, 3), H (N,) at t after a step tau > 0 on Gamma_h[x], geo.

        int (x^n - x) / tau . n phi + int grad H^n . grad phi = int Q phi,
        int H^n n . phi - int grad x^n . grad phi = 0;   Q of H, A on Gamma_h[x].

    Raises
    ------
    ArithmeticError
        If the factorisation fails.
    """
    stiffness = stiffness_matrix(geo)
    normal = [mass_matrix(geo, geo.normal[..., a]) for a in range(3)]
    # The unknowns are (x^n - x) / L, component after component, and L H^n: so no unit of length is
    # left in the matrix.
    L = length(geo)
    rows: list[list[sp.sparray]] = [
        [sp.block_array([[L**2 / tau * N for N in normal]]), stiffness],
        [sp.kron(sp.eye_array(3), stiffness), -sp.block_array([[N] for N in normal]) / L**2],
    ]
    K = sp.block_array(rows, format="csr")
    right = np.concatenate([L * nonlinear(geo, H, law, t), -(stiffness @ centred(x)).T.ravel() / L])
    solution = factored(K)(right)
    return x + L * solution[: x.size].reshape(3, -1).T, solution[x.size :] / L
