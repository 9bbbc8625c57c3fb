"""Which schemes are compared, on which surfaces; one march of one of them, measured."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from time import process_time
from typing import Any

import numpy as np

from harness.case import Case
from harness.meshing import surface_mesh
from harness.meshing.stored_mesh import radius_ratios
from harness.recorder import lifted_errors
from harness.reference import against_profile
from harness.runner import computational_mesh
from harness.schemes import named_scheme
from harness.shape import distances
from harness.stepping import run_of
from reference_solutions import InitialSurface
from solver import Diverged, Mesh, SolverFailure, State
from solver.functionals import area, mesh_width, volume, willmore_energy
from solver.geometry import geometry

# By the word that tables show: the options beside the degree.
ENTRANTS: dict[str, dict[str, Any]] = {
    "kll": {"name": "kll", "bdf": 1, "project": True, "theta": False},
    "kll, theta": {"name": "kll", "bdf": 1, "project": True, "theta": True},
    "dziuk": {"name": "dziuk"},
    "bgn": {"name": "bgn"},
}
ON_AXIS = {"name": "surface", "reference": "axisymmetric"}
GROUNDS: dict[str, dict[str, Any]] = {
    "sphere": {"name": "sphere"},
    "Clifford torus": {"name": "clifford_torus"},
    "1 + 0.2 P2 sphere": {**ON_AXIS, "surface": "p2_sphere"},
    "red blood cell": {**ON_AXIS, "surface": "red_blood_cell"},
    "ellipsoid 2:1:1": {**ON_AXIS, "surface": "ellipsoid"},
}


@dataclass
class March:
    """What was measured, a number a level; a list grows while the scheme steps.

    ``quality`` is the least ratio of inscribed to circumscribed circle, twice, of a triangle of
    vertices; ``seconds`` of the processor are those of a step alone; ``h1`` is the error of x in
    H^1, where nodes have exact trajectories to be compared with. At the end, NaN if it was not
    reached: ``distance`` and relative error of ``W``; ``area_drift`` and ``volume_drift``, how much
    more or less they have changed, relative to the start, than on the exact surface. ``ended`` says
    how it ended.
    """

    nodes: int
    h: float
    t: list[float] = field(default_factory=list)
    energy: list[float] = field(default_factory=list)
    area: list[float] = field(default_factory=list)
    volume: list[float] = field(default_factory=list)
    quality: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    amplitude: list[float] = field(default_factory=list)
    h1: list[float] = field(default_factory=list)
    distance: float = np.nan
    W: float = np.nan
    area_drift: float = np.nan
    volume_drift: float = np.nan
    ended: str = "ok"

    @property
    def rise(self) -> float:
        """The largest relative increase of W in a step; H is recovered from the first level on."""
        return float(np.max(np.diff(self.energy[1:]), initial=0.0)) / self.energy[0]

    @property
    def x_error(self) -> float:
        """The error of x in L-infinity(H^1); NaN if it was not measured, or broke down."""
        return max(self.h1, default=np.nan) if self.ended == "ok" else np.nan

    @property
    def cpu(self) -> float:
        """All seconds of the steps."""
        return float(sum(self.seconds))


def case_of(
    entrant: str, solution: dict, V: int, tau: float, T: float, degree: int = 2, law="willmore"
) -> Case:
    """The case of an entrant of the contest."""
    return Case.model_validate(
        {
            "solution": solution,
            "law": {"name": law},
            "scheme": {**ENTRANTS[entrant], "degree": degree},
            "vertices": V,
            "tau": tau,
            "final_time": T,
            "compare_at": (T,) if solution["name"] == "surface" else (),
        }
    )


def march(case: Case, compare: bool = True) -> March:
    """Run a case; errors at its end only if they are asked for. Divergence is a result."""
    solution = case.solution.initial()
    surface = surface_mesh(solution.mesh_surface, case.vertices)
    mesh, p = computational_mesh(surface, solution, case.scheme.degree)
    found = March(mesh.node_count, mesh_width(geometry(mesh, p)))
    comparable = solution.always_exact and not named_scheme(case.scheme.name).slides
    error_of = lifted_errors(mesh, p, solution) if compare and comparable else None
    states, state = run_of(case.scheme.name)(case, mesh, p, solution, ()), None
    try:
        for state, seconds in timed(states):
            measure(found, mesh, solution, state, seconds)
            if error_of is not None:
                found.h1.append(error_of(state)["x"][1])
    except Diverged as stop:
        found.ended = f"diverged at t = {stop.t:g}"
    except SolverFailure as stop:
        found.ended = f"failed at t = {stop.t:g}"
    if compare and found.ended == "ok":
        compare_end(case, mesh, solution, state, found)
    return found


def timed(states: Iterator[State]) -> Iterator[tuple[State, float]]:
    """The States, each with the seconds of the processor that it took."""
    while True:
        started = process_time()
        state = next(states, None)
        if state is None:
            return
        yield state, process_time() - started


def measure(
    found: March, mesh: Mesh, solution: InitialSurface, state: State, seconds: float
) -> None:
    """Append what a State gives; the seconds of the first one are no step."""
    geo = geometry(mesh, state.x)
    if found.t:
        found.seconds.append(seconds)
    found.t.append(state.t)
    found.energy.append(willmore_energy(geo, state.H))
    found.area.append(area(geo))
    found.volume.append(volume(geo))
    corners = state.x[: mesh.vertex_count]
    found.quality.append(float(radius_ratios(corners, mesh.triangles).min()))
    if hasattr(solution, "mode_amplitude"):
        weights = np.bincount(mesh.cells.ravel(), (geo.dA @ geo.element.phi**2).ravel())
        found.amplitude.append(solution.mode_amplitude(state.x, weights))


def compare_end(
    case: Case, mesh: Mesh, solution: InitialSurface, state: State, found: March
) -> None:
    """Set what is known at the end only: on an exact solution at rest, or beside a profile."""
    growth = {"area": 1.0, "volume": 1.0}
    if solution.always_exact:
        points = geometry(mesh, state.x).points
        found.distance = float(distances(points, solution, state.t).max())
        found.W = abs(found.energy[-1] / solution.energy(state.t) - 1.0)
    else:
        flow = solution.profile_flow(case.law.name, case.law.parameters, (0.0, *case.compare_at))
        numbers = {name: getattr(found, name)[-1] for name in ("energy", "area", "volume")}
        errors = against_profile(mesh, state, numbers, flow, 1)
        found.distance, found.W = max(errors["distance"], errors["distance_back"]), errors["W"]
        growth = {
            "area": flow.areas[1] / flow.areas[0],
            "volume": flow.volumes[1] / flow.volumes[0],
        }
    found.area_drift = abs(found.area[-1] / found.area[0] / growth["area"] - 1.0)
    found.volume_drift = abs(found.volume[-1] / found.volume[0] / growth["volume"] - 1.0)
