"""How far two States on one mesh lie apart: norms of the difference, not differences of norms.

Two runs that start in the same nodes have the same I_h u, so that the difference of their States is
the difference of their errors, d = e' - e. Its norm bounds | |e'| - |e| | and is what matters: of a
d that is orthogonal to e, the norm of the error shows d^2 / (2 |e|) alone.
"""

import numpy as np

from esfem.measuring.lift import (
    VARIABLES,
    error_quadrature,
    squared_norms,
    unknowns,
    weighted_metric,
)
from esfem.solver import Mesh, State
from esfem.solver.geometry import Geometry, geometry, interpolate, reference_gradient

DISTANCE = "distance"


def differences(mesh: Mesh, state: State, other: State, length: float) -> dict[str, float]:
    """The norms of d = other - state on the surface of ``state``.

    Parameters
    ----------
    mesh : that of both.
    state, other : with nodes that belong to each other.
    length : the unit of length L.

    Returns
    -------
    By `measuring.lift.VARIABLES` sqrt(|d|^2 / L^2 + |grad d|^2), and "distance", the largest
    |d_x . n| in a quadrature point: what the difference of the surfaces is but for second order,
    wherever nodes slide.
    """
    geo = geometry(mesh, state.x, error_quadrature(mesh.degree))
    d = unknowns(other) - unknowns(state)
    at_points = interpolate(geo, d)
    gradients = reference_gradient(mesh, geo.element, d)
    l2, seminorm = squared_norms(geo, weighted_metric(geo), at_points, gradients)
    squares = l2 / length**2 + seminorm
    norms = {name: float(np.sqrt(squares[c].sum())) for name, c in VARIABLES.items()}
    across = np.einsum("eqa,eqa->eq", at_points[..., VARIABLES["x"]], geo.normal)
    return norms | {DISTANCE: float(np.abs(across).max())}


def flow_map_difference(start: Geometry, state: State, other: State, length: float) -> float:
    """The norm in H^1 of the difference of two flow maps, on the surface interpolated at the start.

    Parameters
    ----------
    start : that surface, with the nodes at t = 0 as labels; it has the norms of Gamma(0) but for
        O(h^k), relative.
    state, other, length : as in `differences`.
    """
    d = other.x - state.x
    gradients = reference_gradient(start.mesh, start.element, d)
    parts = squared_norms(start, weighted_metric(start), interpolate(start, d), gradients)
    l2, seminorm = (float(part.sum()) for part in parts)
    return float(np.sqrt(l2 / length**2 + seminorm))
