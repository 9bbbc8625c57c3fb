"""Dziuk's algorithm for Willmore flow: x and w = Lap x = -H nu, no normal.  Paper: eq:Dziuk alg.

The discrete energy W_h = 1/2 int |w_h|^2 with int w . phi = -int grad x . grad phi has the
derivative -(1/2 int |w|^2 div phi + B(w, phi)) in the direction phi, and v = -dW_h: a gradient
flow.

References
----------
Dziuk, Computational parametric Willmore flow, Numer. Math. 111 (2008).
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from esfem.solver.assembly import load, mass_matrix, matrix, stiffness_matrix
from esfem.solver.direct import factored
from esfem.solver.functionals import centred, length
from esfem.solver.geometry import Geometry, interpolate
from esfem.solver.reference_element import Array

Blocks = Sequence[Sequence[sp.csr_array | sp.csc_array]]


def curvature_vector(geo: Geometry, x: Array) -> Array:
    """w (N, 3): int w . phi = -int grad x . grad phi; the discrete -H nu."""
    return factored(mass_matrix(geo))(-(stiffness_matrix(geo) @ centred(x)))


def gradients(geo: Geometry) -> Array:
    """grad phi_i at the quadrature points, (E, Q, n, 3)."""
    return np.einsum("epar,pri->epia", geo.B, geo.element.dphi, optimize=True)


def bending(geo: Geometry) -> Blocks:
    """The blocks B[b][c] (N, N) of B(w, phi) for phi = phi_i e_b and w = phi_j e_c.

    B(w, phi) = int grad w . grad phi + (div w)(div phi) - D(phi) grad x . grad w. As grad x is the
    tangential projection I - n n^T, the entries are, with g = grad phi_i and h = grad phi_j,

        int (g . h) n_b n_c + g_b h_c - g_c h_b.
    """
    E, Q, n, _ = (g := gradients(geo)).shape
    flat = g.transpose(0, 2, 1, 3).reshape(E, n, 3 * Q)
    part = [np.ascontiguousarray(g[..., a].swapaxes(1, 2)) for a in range(3)]

    def entry(b: int, c: int) -> sp.csr_array:
        """The block (b, c) for b <= c."""
        nn = np.repeat(geo.dA * geo.normal[..., b] * geo.normal[..., c], 3, axis=1)
        local = (flat * nn[:, None, :]) @ flat.swapaxes(1, 2)
        if b != c:
            mixed = (part[b] * geo.dA[:, None, :]) @ part[c].swapaxes(1, 2)
            local += mixed - mixed.swapaxes(1, 2)
        return matrix(geo.mesh, local.reshape(E, n * n).T)

    upper = {(b, c): entry(b, c) for b in range(3) for c in range(b, 3)}
    return [[upper[b, c] if b <= c else upper[c, b].T for c in range(3)] for b in range(3)]


def stretching(geo: Geometry, w: Array) -> Blocks:
    """The blocks C[b][c] (N, N) of int (w . y) div phi for phi = phi_i e_b and y = phi_j e_c."""
    E, _, n, _ = (g := gradients(geo)).shape
    weight = geo.dA[..., None] * interpolate(geo, w)

    def entry(b: int, c: int) -> sp.csr_array:
        local = (g[..., b] * weight[..., c, None]).swapaxes(1, 2) @ geo.element.phi
        return matrix(geo.mesh, local.reshape(E, n * n).T)

    return [[entry(b, c) for c in range(3)] for b in range(3)]


def applied(blocks: Blocks, y: Array) -> Array:
    """The dual vector (N, 3) of blocks applied to nodal y (N, 3)."""
    return np.column_stack([sum(block @ y[:, c] for c, block in enumerate(row)) for row in blocks])


def step(geo: Geometry, x: Array, w: Array, tau: float, f: Array | None) -> tuple[Array, Array]:
    """x, w (N, 3) after a step tau > 0 on Gamma_h[x], geo.

        M (x^n - x) / tau = int (w . w^n - |w|^2 / 2) div phi + B(w^n, phi) + int f n . phi,
        M w^n = -A x^n.

    differs: |w^n|^2 / 2 is linearised at w; with |w|^2 / 2 the largest stable step is smaller, for
    this term and the lower terms of B(w^n, phi) cancel on spheres at the same time only.

    Parameters
    ----------
    f : forcing of the normal velocity at the quadrature points (E, Q), or None.

    Raises
    ------
    ArithmeticError
        If the factorisation fails.
    """
    M, A = mass_matrix(geo), stiffness_matrix(geo)
    B, C = bending(geo), stretching(geo, w)
    given = -0.5 * applied(C, w)
    if f is not None:
        given += load(geo, f[..., None] * geo.normal)
    # The unknowns are (x^n - x) / L and L w^n, component after component: so no unit of length is
    # left in the matrix.
    L, identity = length(geo), sp.eye_array(3)
    K = sp.block_array(
        [
            [sp.kron(identity, L**2 / tau * M), -sp.block_array(B) - sp.block_array(C)],
            [sp.kron(identity, A), sp.kron(identity, M / L**2)],
        ],
        format="csr",
    )
    right = np.concatenate([L * given.T.ravel(), -(A @ centred(x)).T.ravel() / L])
    d, w_new = factored(K)(right).reshape(2, 3, -1)
    return x + L * d.T, np.ascontiguousarray(w_new.T / L)
