"""X_h^l - X in H^1(Gamma(0)): the flow map lifted to the initial surface.

X_h(p_h, t) = sum_j x_j(t) phi_j(p_h) lives on the interpolated initial surface and is lifted from
there to Gamma(0), once for all times; the position x_h^L is lifted at time t, from the surface
interpolated in the exact nodes of that time. The two are different functions.

Paper: the last line of Theorem 4.1 (MainTHM).
"""

from collections.abc import Callable

import numpy as np

from esfem.measuring.lift import error_quadrature, squared_norms, weighted_metric
from esfem.measuring.residuals import REACH, derivative
from esfem.reference_solutions import ExactSolution
from esfem.solver import Mesh, State
from esfem.solver.geometry import from_jacobian, interpolate, reference_gradient, values
from esfem.solver.reference_element import Array, reference_element, tabulate

# Of differences in reference coordinates, of order 8: they reach an eighth of a side.
STEP = 1.0 / 32.0


def flow_map_error(
    mesh: Mesh, p: Array, solution: ExactSolution, length: float
) -> Callable[[State], float]:
    """State -> |X_h^l - X| in H^1(Gamma(0)) at its time.

    The gradient of X is that of central differences along the reference coordinates, of an error
    O(h^8 / 32^8), below all that P_4 leaves.

    Parameters
    ----------
    mesh, p : the mesh, and its nodes (N, 3) on Gamma(0), the labels of the nodes of the States.
    solution : knows X, the ``trajectories``.
    length : the unit L of the norm, sqrt(|e|^2 / L^2 + |grad e|^2).
    """
    element = reference_element(mesh.degree, error_quadrature(mesh.degree))
    points = values(mesh, element, p)
    Y = solution.closest_point(points, 0.0)
    J = np.swapaxes(reference_gradient(mesh, element, p), -1, -2)
    geo = from_jacobian(mesh, element, Y, solution.closest_point_derivative(points, 0.0) @ J)
    metric = weighted_metric(geo)

    def lifted(shift: Array) -> Array:
        """The labels (E, Q, 3) at quadrature points moved by a shift (2,)."""
        phi, _ = tabulate(mesh.degree, element.points + shift)
        return solution.closest_point(phi @ p[mesh.cells], 0.0)

    offsets = [j * STEP for j in range(-REACH, REACH + 1)]
    stencils = [
        [solution.trajectories(lifted(offset * axis)) for offset in offsets] for axis in np.eye(2)
    ]

    def error(state: State) -> float:
        X = [[flow(state.t) for flow in stencil] for stencil in stencils]
        dX = np.stack([derivative(along, STEP) for along in X], axis=-2)
        e = interpolate(geo, state.x) - X[0][REACH]
        de = reference_gradient(mesh, element, state.x) - dX
        l2, seminorm = squared_norms(geo, metric, e, de)
        return float(np.sqrt(l2.sum() / length**2 + seminorm.sum()))

    return error
