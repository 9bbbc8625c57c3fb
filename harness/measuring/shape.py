"""Errors of the shape alone: of W, area and volume, and the distance to the exact surface.

They are there for schemes whose nodes slide, where nodal errors mean nothing.
"""

from collections.abc import Callable

import numpy as np

from esfem.measuring.lift import at_time, lifted_surface
from esfem.reference_solutions import ExactSolution
from esfem.solver import Mesh, State
from esfem.solver.functionals import area, volume, willmore_energy
from esfem.solver.geometry import Geometry, geometry
from esfem.solver.reference_element import Array

SHAPES = ("W", "area", "volume", "distance")


def shape_errors(exact: Geometry, solution: ExactSolution, state: State) -> dict[str, float]:
    """The errors named in `SHAPES`, at the time of the State.

    Parameters
    ----------
    exact : Gamma(t), parametrised, with a quadrature for its area and volume.
    solution, state : what is to be approximated, and by what.

    Returns
    -------
    Relative errors of W, area and volume, and the largest distance of the quadrature points of
    Gamma_h to Gamma(t).
    """
    geo = geometry(exact.mesh, state.x)
    return {
        "W": abs(willmore_energy(geo, state.H) / solution.willmore(state.t) - 1.0),
        "area": abs(area(geo) / area(exact) - 1.0),
        "volume": abs(volume(geo) / volume(exact) - 1.0),
        "distance": float(distances(geo.points, solution, state.t).max()),
    }


def shape_of(mesh: Mesh, p: Array, solution: ExactSolution) -> Callable[[State], dict[str, float]]:
    """State -> its `shape_errors`; Gamma(t) is parametrised from nodes that start at p (N, 3)."""
    X = solution.trajectories(p)
    exact = at_time(solution, lambda t: lifted_surface(mesh, solution, X(t), t).geometry)
    return lambda state: shape_errors(exact(state.t), solution, state)


def distances(points: Array, solution: ExactSolution, t: float) -> Array:
    """The distance of each point (..., 3) to Gamma(t)."""
    return np.linalg.norm(points - solution.closest_point(points, t), axis=-1)
