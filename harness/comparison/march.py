"""One march of one scheme, and what was measured on it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from time import process_time
from typing import Any

import numpy as np

from harness.case import Case
from harness.meshing import surface_mesh
from harness.meshing.stored_mesh import radius_ratios
from harness.recorder import lifted_errors, nodal_weights
from harness.reference import against_profile
from harness.runner import computational_mesh
from harness.schemes import named_scheme
from harness.shape import distances
from harness.stepping import levels, problem_of
from reference_solutions import ExactSolution, InitialSurface
from solver import Diverged, Mesh, SolverFailure, State
from solver.assembly import mass_matrix, stiffness_matrix
from solver.functionals import area, mesh_width, volume, willmore_energy
from solver.geometry import geometry
from solver.reference_element import Array


@dataclass
class March:
    """What was measured, a number a level; a list grows while the scheme steps.

    ``energy`` is the scheme's own discrete Willmore energy. ``quality`` is the least ratio of
    inscribed to circumscribed circle, twice, of a triangle of vertices. ``seconds`` are those of
    the processor for each step, with what the harness recovers and checks. ``ended`` says how it
    ended. By "start" and "end", as far as they are known: ``distance`` to the exact surface, ``x``
    the error of x in H^1 where nodes can be compared, ``apart`` that of x_h from the interpolation
    of x; ``W`` the relative error of the energy. ``area_drift`` and ``volume_drift``: how much more
    or less they have changed, relative to the start, than on the exact surface.
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
    distance: dict[str, float] = field(default_factory=dict)
    x: dict[str, float] = field(default_factory=dict)
    apart: dict[str, float] = field(default_factory=dict)
    W: dict[str, float] = field(default_factory=dict)
    area_drift: float = np.nan
    volume_drift: float = np.nan
    ended: str = "ok"

    @property
    def rise(self) -> float:
        """The largest relative increase of the energy in a step after the first, before which H is
        exact and not the scheme's; NaN for a run that broke down."""
        if self.ended != "ok":
            return np.nan
        return float(np.max(np.diff(self.energy[1:]), initial=0.0)) / self.energy[0]

    @property
    def cpu(self) -> float:
        """All seconds of the steps."""
        return float(sum(self.seconds))

    def at_end(self, name: str) -> float:
        """The error of that name at the end, NaN if it is not known."""
        return getattr(self, name).get("end", np.nan)


def march(case: Case, compare: bool = True) -> March:
    """Run a case; errors at start and end only if they are asked for. Divergence is a result."""
    solution = case.solution.initial()
    surface = surface_mesh(solution.mesh_surface, case.vertices)
    mesh, p = computational_mesh(surface, solution, case.scheme.degree)
    found = March(mesh.node_count, mesh_width(geometry(mesh, p)))
    states = timed(with_energy(case, mesh, p, solution))
    first = state = None
    try:
        for (state, energy), seconds in states:
            measure(found, mesh, solution, state, energy)
            if first is None:
                first = state
            else:
                found.seconds.append(seconds)
    except Diverged as stop:
        found.ended = f"diverged at t = {stop.t:g}"
    except SolverFailure as stop:
        found.ended = f"failed at t = {stop.t:g}"
    if compare and found.ended == "ok":
        compare_ends(case, mesh, p, solution, (first, state), found)
    return found


def with_energy(
    case: Case, mesh: Mesh, p: Array, solution: InitialSurface
) -> Iterator[tuple[State, float]]:
    """The States of a case, each with the scheme's own discrete energy."""
    scheme = named_scheme(case.scheme.name)
    if scheme.run is not None:
        pairs = ((state, None) for state in scheme.run(case, mesh, p, solution, ()))
    else:
        problem = problem_of(case, mesh, p, solution)
        pairs = levels(scheme, problem, case.steps)
    for state, level in pairs:
        if scheme.energy is None:
            yield state, willmore_energy(geometry(mesh, state.x), state.H)
        else:
            yield state, scheme.energy(problem, level)


def timed(items: Iterator[Any]) -> Iterator[tuple[Any, float]]:
    """The items, each with the seconds of the processor that it took."""
    done = object()
    while True:
        started = process_time()
        item = next(items, done)
        if item is done:
            return
        yield item, process_time() - started


def measure(
    found: March, mesh: Mesh, solution: InitialSurface, state: State, energy: float
) -> None:
    """Append what a State gives."""
    geo = geometry(mesh, state.x)
    found.t.append(state.t)
    found.energy.append(energy)
    found.area.append(area(geo))
    found.volume.append(volume(geo))
    corners = state.x[: mesh.vertex_count]
    found.quality.append(float(radius_ratios(corners, mesh.triangles).min()))
    if hasattr(solution, "mode_amplitude"):
        found.amplitude.append(solution.mode_amplitude(state.x, nodal_weights(geo)))


def compare_ends(
    case: Case,
    mesh: Mesh,
    p: Array,
    solution: InitialSurface,
    states: tuple[State, State],
    found: March,
) -> None:
    """Set what is known of the first and the last State: on an exact solution, or by a profile."""
    ends = list(zip(("start", "end"), states, strict=True))
    if solution.always_exact:
        slides = named_scheme(case.scheme.name).slides
        nodal = None if slides else nodal_errors(mesh, p, solution)
        for i, (when, state) in enumerate(ends):
            points = geometry(mesh, state.x).points
            found.distance[when] = float(distances(points, solution, state.t).max())
            found.W[when] = abs(found.energy[-i] / solution.energy(state.t) - 1.0)
            if nodal is not None:
                found.x[when], found.apart[when] = nodal(state)
        growth = (1.0, 1.0)
    else:
        times = (0.0, case.final_time)
        flow = solution.profile_flow(case.law.name, case.law.parameters, times)
        for i, (when, state) in enumerate(ends):
            numbers = {name: getattr(found, name)[-i] for name in ("energy", "area", "volume")}
            errors = against_profile(mesh, state, numbers, flow, i)
            found.distance[when] = max(errors["distance"], errors["distance_back"])
            found.W[when] = errors["W"]
        growth = (flow.areas[1] / flow.areas[0], flow.volumes[1] / flow.volumes[0])
    found.area_drift = abs(found.area[-1] / found.area[0] / growth[0] - 1.0)
    found.volume_drift = abs(found.volume[-1] / found.volume[0] / growth[1] - 1.0)


def nodal_errors(
    mesh: Mesh, p: Array, solution: ExactSolution
) -> Callable[[State], tuple[float, float]]:
    """State -> in H^1 its error of x, and the distance of x_h from the interpolation of x."""
    X, lifted = solution.trajectories(p), lifted_errors(mesh, p, solution)

    def measured(state: State) -> tuple[float, float]:
        nodes = X(state.t)
        geo, e = geometry(mesh, nodes), state.x - nodes
        square = np.sum(e * (mass_matrix(geo) @ e + stiffness_matrix(geo) @ e))
        return lifted(state)["x"][1], float(np.sqrt(square))

    return measured
