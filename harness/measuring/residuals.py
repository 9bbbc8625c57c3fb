"""What exact nodal values leave in the semi-discrete equations: the start of w, and the defects.

With x*, u* = (H*; nu*), w* = (V*; z*) the exact values in the nodes, and M, A, F, f, g assembled on
the surface interpolated there,

    M w(0) = g + theta - A u*                                   the start of w, at t = 0,
    M d_u = M du*/dt - A w* - F w* - f,   M d_w = M w* + A u* - g     the defects, at any time.

No scheme in time enters: what is tested are the forms, the laws and their quadrature.

Errors and defects are measured in H^-1_h, the norm of the dual of P_k functions on that surface
(`dual_norms`), each equation by itself, for their units differ. In it they are O(h^k) for nodal
values; in L^2 the paper has O(h^k) for Ritz maps, which are not built here, and of nodal values an
order less is seen. The defect of v = I_h(V nu) is zero for nodal values, and so is not measured.

Paper: section 3.4; defect vectors in section 5.3; eq:initial errors, eq:defect bounds in 6.1.
"""

from collections.abc import Callable, Sequence

import numpy as np
import scipy.sparse as sp

from esfem.measuring.lift import exact_state
from esfem.reference_solutions import ExactSolution
from esfem.solver import Mesh, Scheme, State
from esfem.solver.direct import factored
from esfem.solver.laws import AnyLaw
from esfem.solver.reference_element import Array
from esfem.solver.scheme import correction
from esfem.solver.system import System, assembled

U = {"H": slice(0, 1), "nu": slice(1, 4)}  # columns of u
W = {"V": slice(0, 1), "z": slice(1, 4)}  # columns of w
# Central differences over 2 * REACH + 1 equal steps, exact for polynomials of degree 8.
WEIGHTS = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)
REACH = len(WEIGHTS)


def dual_norms(M: sp.csr_array, A: sp.csr_array, r: Array, length: float) -> Array:
    """sup of r.phi over nodal phi with phi.(M / L^2 + A) phi = 1, by columns of r: (N, C) -> (C,).

    For r = M d this is the norm of H^-1_h of the function with nodal values d; the root of
    r.(M / L^2 + A)^-1 r.

    Parameters
    ----------
    M, A : mass and stiffness matrix of the surface.
    r : dual vectors.
    length : the unit L; the H^1 norm is sqrt(|phi|^2 / L^2 + |grad phi|^2).

    References
    ----------
    Paper, section 5.4: the norm with a star, after Kovacs, Li, Lubich, Power Guerra (2017).
    """
    squares = np.einsum("jc,jc->c", r, factored(M / length**2 + A)(r))
    return np.sqrt(np.maximum(squares, 0.0))


def start_of_w(mesh: Mesh, initial: State, scheme: Scheme, length: float) -> dict[str, float]:
    """The norms of w(0) - I_h w, where w(0) is that of the scheme, M w(0) = g + theta - A u.

    Parameters
    ----------
    mesh, initial : the exact nodal x, u, and w for the interpolation.
    scheme : its law, theta and quadrature count.
    length : the unit L of the norms.

    Returns
    -------
    "start_V" and "start_z" in H^-1_h; with "_l2" in L^2 and with "_h1" in H^1.
    """
    on = assembled(mesh, initial.x, initial.u, scheme.law, initial.t, scheme.quadrature_degree)
    r = on.g + correction(mesh, initial, scheme) - on.A @ initial.u - on.M @ initial.w
    e = factored(on.M)(r)
    dual = dual_norms(on.M, on.A, r, length)
    l2 = np.sqrt(np.maximum(np.einsum("jc,jc->c", e, r), 0.0))
    seminorm = np.sqrt(np.maximum(np.einsum("jc,jc->c", e, on.A @ e), 0.0))
    norms = {"": dual, "_l2": l2, "_h1": np.hypot(l2 / length, seminorm)}
    return {
        f"start_{name}{which}": float(np.linalg.norm(norm[columns]))
        for name, columns in W.items()
        for which, norm in norms.items()
    }


def residuals(on: System, u: Array, du: Array, w: Array) -> Array:
    """M d_u and M d_w, dual (N, 8), of nodal u, du/dt and w (N, 4) in the `System` of u."""
    first = on.M @ du - on.A @ w - on.F(w) - on.f
    return np.hstack([first, on.M @ w + on.A @ u - on.g])


def derivative(values: Sequence[Array], step: float) -> Array:
    """d/dt in the middle of 2 `REACH` + 1 values at distances ``step``, to the order 8."""
    return sum(
        (
            weight / step * (values[REACH + j] - values[REACH - j])
            for j, weight in enumerate(WEIGHTS, start=1)
        ),
        np.zeros(()),
    )


def defects(
    mesh: Mesh,
    p: Array,
    solution: ExactSolution,
    law: AnyLaw,
    tau: float,
    length: float,
    quadrature: int | None = None,
) -> Callable[[float], dict[str, float]]:
    """t -> the norms of the defects and of their time derivatives in H^-1_h.

    The derivatives of nodal values by time are differences of order 8 (`derivative`), within a time
    step to both sides; those of defects again, so that they reach two steps back from t, before 0
    too.

    Parameters
    ----------
    mesh, p : the mesh, and its nodes (N, 3) on Gamma(0).
    solution : whose nodal values are put into the equations, with their law, forcing included.
    tau : the time step.
    length : the unit L of the norms.
    quadrature : as in `esfem.solver.geometry.geometry`.

    Returns
    -------
    "defect_H" and "defect_nu" (the two parts of d_u), "defect_V" and "defect_z" (those of d_w);
    with "_dt" the derivatives by time of their nodal vectors.
    """
    X, step = solution.trajectories(p), tau / REACH
    names = [f"defect_{name}" for name in (*U, *W)]
    columns = [*U.values(), *(slice(c.start + 4, c.stop + 4) for c in W.values())]

    def at(t: float) -> dict[str, float]:
        times = [t + j * step for j in range(-2 * REACH, 2 * REACH + 1)]
        exact = [exact_state(solution, X(s), s) for s in times]
        systems, left = [], []
        for i in range(REACH, 3 * REACH + 1):
            state = exact[i]
            du = derivative([s.u for s in exact[i - REACH : i + REACH + 1]], step)
            systems.append(assembled(mesh, state.x, state.u, law, times[i], quadrature))
            left.append(residuals(systems[-1], state.u, du, state.w))
        here, r = systems[REACH], left[REACH]
        d = factored(here.M)(r)
        # M dd/dt = d/dt (M d) - (dM/dt) d: one solve, and the Leibniz formula of section 6.4.
        dr = derivative([b - on.M @ d for on, b in zip(systems, left, strict=True)], step)
        norms = dual_norms(here.M, here.A, np.hstack([r, dr]), length).reshape(2, -1)
        return {
            name + which: float(np.linalg.norm(own[part]))
            for which, own in zip(("", "_dt"), norms, strict=True)
            for name, part in zip(names, columns, strict=True)
        }

    return at
