"""Evolving surface finite elements for Willmore flow, after Kovacs, Li and Lubich (the paper).

Notation (a new symbol enters this table first)::

    paper         code         shape      note
    x, nu, z, v   x, nu, z, v  (N, 3)     nodal vectors; z = grad H, never the coordinate x[:, 2]
    H, V          H, V         (N,)       nodal scalars; V is the normal velocity, v = V nu
    u = (H; nu)   u            (N, 4)     columns H, nu
    w = (V; z)    w            (N, 4)     columns V, z
    M(x), A(x)    M, A         (N, N)     mass and stiffness matrix, CSR
    A, A_h        S            (E,Q,3,3)  the shape operator; A stays the stiffness matrix
    |A|^2         S2           (E,Q)      squared Frobenius norm of S
    Q             Q            (E,Q)      nonlinear part of the velocity law V = Lap H + Q
    F1, F2        F1, F2                  applied to V and z: dual vectors (N,) and (N, 3)
    f2, g1, g2    f2, g1, g2              dual vectors (N, 3), (N,), (N, 3)
    vartheta      theta        (N, 4)     correction of section 3.4, a dual vector
    k, h, tau     degree, h, tau          polynomial degree, mesh width, time step
                  q, n                    order of the BDF method, index of the time level
                  c                       delta_0 / tau
                  J            (E,Q,3,2)  Jacobian of the element map
                  B            (E,Q,3,2)  J (J^T J)^-1: tangential from reference gradients
                  dA           (E,Q)      area element times quadrature weight

The suffix _ext means extrapolated to t_n from the history.  Einsum letters: e element, p quadrature
point, i j basis, r s reference direction, a b c space.

Signs, stated once: nu points outward, H = kappa_1 + kappa_2 = tr(grad nu) > 0 on spheres and
W = 1/2 int H^2.  Gradients: ``grad f[..., a, b]`` = d_a f_b (gradients of components are columns).
Loads (f2, g1, g2, theta) are dual vectors: only a solve with M makes one nodal.
"""

from esfem.solver.bdf import BDF
from esfem.solver.flow import Diverged, SolverFailure, evolve, remembered, resumable
from esfem.solver.laws import LAWS
from esfem.solver.levels import Levels, Memory
from esfem.solver.mesh import Mesh, elevate, triangulation
from esfem.solver.scheme import Scheme, State

__all__ = [
    "BDF",
    "LAWS",
    "Diverged",
    "Levels",
    "Memory",
    "Mesh",
    "Scheme",
    "SolverFailure",
    "State",
    "elevate",
    "evolve",
    "remembered",
    "resumable",
    "triangulation",
]
