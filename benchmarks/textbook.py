"""The same step the textbook way: one real 8N x 8N matrix, analysed, factored and solved afresh.

The terms are assembled by the solver itself; so the ratio speaks of the linear algebra, and of what
it costs to build F and the whole matrix with SciPy.
"""

import numpy as np
import pypardiso
import scipy.sparse as sp

from benchmarks.cases import Flow
from esfem.solver import forms
from esfem.solver.assembly import mass_matrix, stiffness_matrix
from esfem.solver.geometry import geometry
from esfem.solver.reference_element import Array
from esfem.solver.scheme import combine, unit


def textbook_step(flow: Flow) -> tuple[Array, Array]:
    """u, w (N, 4) of the next State, before the projection."""
    mesh, tau, scheme = flow.mesh, flow.tau, flow.scheme
    delta, gamma = [float(d) for d in scheme.bdf.delta], [float(g) for g in scheme.bdf.gamma]
    past = flow.history[: scheme.bdf.order]
    x_ext, u_ext = (combine(gamma, [getattr(s, name) for s in past]) for name in ("x", "u"))
    u_ext[:, 1:] = unit(u_ext[:, 1:])
    geo = geometry(mesh, x_ext)
    c = forms.curvature(geo, u_ext, scheme.law, flow.t)
    M, A = mass_matrix(geo), stiffness_matrix(geo)
    f, g = forms.loads(geo, c)
    M4, A4 = sp.block_diag([M] * 4), sp.block_diag([A] * 4)
    whole = sp.block_array(
        [[delta[0] / tau * M4, -(A4 + reaction_matrix(geo, c))], [A4, M4]], format="csr"
    )
    a = f - M @ combine(delta[1:], [s.u for s in past]) / tau
    right = np.concatenate([a.T.ravel(), (g + flow.theta).T.ravel()])
    # The step that is timed is always the same; without this the factors of the last call would do.
    pypardiso.ps.free_memory(everything=True)
    u, w = pypardiso.spsolve(whole, right).reshape(2, 4, -1)
    return u.T, w.T


def reaction_matrix(geo, c: forms.Curvature) -> sp.spmatrix:
    """F on (V; z) by components, (4N, 4N): ten weighted mass matrices."""
    tensor = c.H[..., None, None] * c.S - c.S @ c.S
    F2 = [[mass_matrix(geo, tensor[..., i, j]) for j in range(3)] for i in range(3)]
    return sp.block_diag([mass_matrix(geo, -c.S2), sp.block_array(F2)])
