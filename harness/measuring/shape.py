"""Errors of the shape alone: against an exact surface, and against the axisymmetric flow.

They are there for schemes whose nodes slide, where nodal errors mean nothing, and for flows that
are known as profiles.
"""

from collections.abc import Callable, Sequence
from math import isclose
from typing import Protocol

import numpy as np

from esfem.common.bad_input import BadInput
from esfem.measuring.curved_distance import distance_to_surface, lattice_surface
from esfem.measuring.lift import at_time, lifted_surface
from esfem.reference_solutions import ExactSolution, SurfaceFlow
from esfem.reference_solutions.axisymmetric import ProfileFlow
from esfem.reference_solutions.profile_distance import profile_distance
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


class NamedLaw(Protocol):
    """A law by its name, with its parameters."""

    @property
    def name(self) -> str: ...

    @property
    def parameters(self) -> dict[str, float]: ...


def profile_flow(
    solution: SurfaceFlow, law: NamedLaw, times: Sequence[float], key: str = "[sweep] compare_at"
) -> ProfileFlow:
    """The axisymmetric flow at these times, the first of which is 0; computed once a process.

    Raises
    ------
    BadInput
        If the axisymmetric solver does not get there, for example as the surface pinches off or
        shrinks to a point; ``key`` is where the times were given.
    """
    try:
        return solution.profile_flow(law.name, law.parameters, times)
    except (RuntimeError, ValueError) as error:
        last = f"{times[-1]:g}"
        raise BadInput(
            f"{key} = {last}: the axisymmetric solver does not get there from surface "
            f"{solution.surface!r} under law {law.name!r}: {error}"
        ) from error


def against_profile(
    mesh: Mesh, state: State, numbers: dict[str, float], flow: ProfileFlow, i: int
) -> dict[str, float]:
    """Relative errors of W, area, volume and the energy, and distances, at the i-th time of the
    flow.

    Parameters
    ----------
    mesh, state : the computed surface.
    numbers : its energy (that of the law of the flow), willmore, area and volume.
    flow : the reference.

    Returns
    -------
    "t"; "W", "area", "volume" (relative errors); "energy" (the error relative to the larger of
    energy and W at the start, for an energy may be zero); "distance" and "distance_mean" from
    points of the computed surface to the reference, "distance_back" and "distance_back_mean" the
    other way (see `esfem.reference_solutions.profile_distance`).
    """
    if not isclose(flow.times[i], state.t, rel_tol=1e-9):
        raise ValueError(f"state.t = {state.t!r}: must be {flow.times[i]!r}, the time of the flow")
    distance = profile_distance(
        lattice_surface(mesh, state.x),
        flow.profile(i),
        surface=lambda y: distance_to_surface(mesh, state.x, y),
    )
    # As `measuring.energies.scale_of`: it is asked for where the energy is neither W nor an area.
    scale = max(flow.energies[0], flow.willmore[0])
    return {
        "t": state.t,
        "W": float(abs(numbers["willmore"] / flow.willmore[i] - 1.0)),
        "area": float(abs(numbers["area"] / flow.areas[i] - 1.0)),
        "volume": float(abs(numbers["volume"] / flow.volumes[i] - 1.0)),
        "energy": float(abs(numbers["energy"] - flow.energies[i]) / scale),
        "distance": distance.maximum_to_profile,
        "distance_mean": distance.mean_to_profile,
        "distance_back": distance.maximum_from_profile,
        "distance_back_mean": distance.mean_from_profile,
    }
