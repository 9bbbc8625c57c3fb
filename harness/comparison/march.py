"""One march of one scheme, and what was measured on it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from time import process_time
from typing import Any

import numpy as np
import scipy.sparse as sp

from harness.case import Case
from harness.energies import largest_rise
from harness.errors import nodal_errors
from harness.meshing import surface_mesh
from harness.meshing.stored_mesh import radius_ratios
from harness.plugin import Level
from harness.recorder import lifted_errors, nodal_weights
from harness.reference import against_profile, profile_flow
from harness.runner import computational_mesh
from harness.shape import distances
from harness.start_states import exact_states
from harness.stepping import failures, levels, problem_of
from reference_solutions import InitialSurface
from solver import Diverged, Mesh, SolverFailure, State
from solver.assembly import mass_matrix, stiffness_matrix
from solver.functionals import area, mesh_width, volume
from solver.geometry import geometry
from solver.reference_element import Array


@dataclass
class March:
    """What was measured, a number a level; a list grows while the scheme steps.

    ``energy`` is that of the law, 1/2 int H_h^2 of the H that the scheme offers or the harness
    recovers; ``own_energy`` the discrete one that the scheme itself descends, where it has another,
    else the same. ``quality`` is the least ratio of
    inscribed to circumscribed circle, twice, of a triangle of vertices. ``apart`` is the distance
    in H^1 of x_h from the interpolation of x, where nodes can be compared. ``seconds`` are those of
    the processor for each step, with what the harness recovers and checks. ``ended`` says how it
    ended. By "start" and "end", as far as they are known: ``distance`` to the exact surface, ``x``
    the error of x in H^1, ``W`` and ``own_W`` the relative errors of both energies as W, the energy
    of the law of the contest. ``area_drift`` and
    ``volume_drift``: how much more or less they have changed, relative to the start, than on the
    exact surface.
    """

    nodes: int
    h: float
    t: list[float] = field(default_factory=list)
    energy: list[float] = field(default_factory=list)
    own_energy: list[float] = field(default_factory=list)
    area: list[float] = field(default_factory=list)
    volume: list[float] = field(default_factory=list)
    quality: list[float] = field(default_factory=list)
    apart: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    amplitude: list[float] = field(default_factory=list)
    distance: dict[str, float] = field(default_factory=dict)
    x: dict[str, float] = field(default_factory=dict)
    W: dict[str, float] = field(default_factory=dict)
    own_W: dict[str, float] = field(default_factory=dict)
    area_drift: float = np.nan
    volume_drift: float = np.nan
    ended: str = "ok"

    @property
    def rise(self) -> float:
        """The largest increase of the energy of the law in a step after the first, before which H
        is exact and not the scheme's, relative to the start; NaN for a run that broke down."""
        return largest_rise(self.energy, self.energy[0], 1)[0] if self.ended == "ok" else np.nan

    @property
    def own_rise(self) -> float:
        """`rise` of the scheme's own energy."""
        own = self.own_energy
        return largest_rise(own, own[0], 1)[0] if self.ended == "ok" else np.nan

    @property
    def furthest(self) -> float:
        """The largest distance of x_h from the interpolation of x; NaN for a run that broke down,
        or where nodes cannot be compared."""
        return max(self.apart, default=np.nan) if self.ended == "ok" else np.nan

    @property
    def cpu(self) -> float:
        """All seconds of the steps."""
        return float(sum(self.seconds))

    def at_end(self, name: str) -> float:
        """The error of that name at the end, NaN if it is not known."""
        return getattr(self, name).get("end", np.nan)


@dataclass(frozen=True)
class Ground:
    """A case on its mesh, with nodes p (N, 3) on the exact surface at t = 0."""

    case: Case
    solution: InitialSurface
    mesh: Mesh
    p: Array

    @property
    def comparable(self) -> bool:
        """Whether nodes have exact trajectories, and keep to them."""
        return self.solution.always_exact and not self.case.plugin.slides


def march(case: Case, compare: bool = True) -> March:
    """Run a case; errors only if they are asked for. Divergence is a result."""
    solution = case.initial
    surface = surface_mesh(solution.mesh_surface, case.vertices)
    ground = Ground(case, solution, *computational_mesh(surface, solution, case.scheme.degree))
    found = March(ground.mesh.node_count, mesh_width(geometry(ground.mesh, ground.p)))
    apart = distance_of_nodes(ground) if compare and ground.comparable else None
    first = state = None
    try:
        for (state, own_energy), seconds in timed(states_of(ground)):
            measure(found, ground, state, own_energy)
            if apart is not None:
                found.apart.append(apart(state))
            if first is None:
                first = state
            else:
                found.seconds.append(seconds)
    except Diverged as stop:
        found.ended = f"diverged at t = {stop.t:g}"
    except SolverFailure as stop:
        found.ended = f"failed at t = {stop.t:g}"
    if compare and found.ended == "ok":
        (on_exact if solution.always_exact else by_profile)(found, ground, (first, state))
    return found


def states_of(ground: Ground) -> Iterator[tuple[State, Callable[[], float] | None]]:
    """The States, each with what computes the scheme's own discrete energy, if it has one."""
    scheme, mesh = ground.case.plugin, ground.mesh
    if scheme.run is not None:
        for state in scheme.run(ground.case, mesh, ground.p, ground.solution, ()):
            yield state, None
        return
    problem = problem_of(ground.case, mesh, ground.p, ground.solution)

    def own(level: Level) -> float:
        with failures(level.t):
            return scheme.energy(problem, level)

    for state, level in levels(scheme, problem, ground.case.levels):
        yield state, None if scheme.energy is None else partial(own, level)


def timed(items: Iterator[Any]) -> Iterator[tuple[Any, float]]:
    """The items, each with the seconds of the processor that it took."""
    done = object()
    while True:
        began = process_time()
        item = next(items, done)
        if item is done:
            return
        yield item, process_time() - began


def measure(
    found: March, ground: Ground, state: State, own_energy: Callable[[], float] | None
) -> None:
    """Append what a State gives."""
    mesh, geo = ground.mesh, geometry(ground.mesh, state.x)
    energy = ground.case.law.energy.value(geo, state.H)
    own = energy if own_energy is None else own_energy()
    found.t.append(state.t)
    found.energy.append(energy)
    found.own_energy.append(own)
    found.area.append(area(geo))
    found.volume.append(volume(geo))
    corners = state.x[: mesh.vertex_count]
    found.quality.append(float(radius_ratios(corners, mesh.triangles).min()))
    if "decay" in ground.solution.measures:
        found.amplitude.append(ground.solution.mode_amplitude(state.x, nodal_weights(geo)))


def distance_of_nodes(ground: Ground) -> Callable[[State], float]:
    """State -> the H^1 norm of x_h minus the interpolation of x, on the interpolated surface."""
    exact_at = exact_states(ground.solution, ground.p)

    def interpolated(t: float) -> tuple[sp.csr_array, sp.csr_array, State]:
        exact = exact_at(t)
        geo = geometry(ground.mesh, exact.x)
        return mass_matrix(geo), stiffness_matrix(geo), exact

    at_rest = interpolated(0.0) if ground.solution.stationary else None

    def measured(state: State) -> float:
        mass, stiffness, exact = at_rest or interpolated(state.t)
        return nodal_errors(mass, stiffness, state, exact)["x"][1]

    return measured


def on_exact(found: March, ground: Ground, states: tuple[State, State]) -> None:
    """Set what is known of the first and the last State on an exact solution that is at rest."""
    solution = ground.solution
    errors = lifted_errors(ground.mesh, ground.p, solution) if ground.comparable else None
    for i, (when, state) in enumerate(zip(("start", "end"), states, strict=True)):
        points = geometry(ground.mesh, state.x).points
        found.distance[when] = float(distances(points, solution, state.t).max())
        found.W[when] = abs(found.energy[-i] / solution.willmore(state.t) - 1.0)
        found.own_W[when] = abs(found.own_energy[-i] / solution.willmore(state.t) - 1.0)
        if errors is not None:
            found.x[when] = errors(state)[0]["x"][1]
    drifts(found, 1.0, 1.0)


def by_profile(found: March, ground: Ground, states: tuple[State, State]) -> None:
    """Set what is known of the first and the last State beside the axisymmetric flow."""
    law, times = ground.case.law, (0.0, ground.case.final_time)
    flow = profile_flow(ground.solution, law, times)
    for i, (when, state) in enumerate(zip(("start", "end"), states, strict=True)):
        numbers = {name: getattr(found, name)[-i] for name in ("energy", "area", "volume")}
        numbers["willmore"] = found.energy[-i]
        errors = against_profile(ground.mesh, state, numbers, flow, i)
        found.distance[when] = max(errors["distance"], errors["distance_back"])
        found.W[when] = errors["W"]
        found.own_W[when] = abs(found.own_energy[-i] / flow.willmore[i] - 1.0)
    drifts(found, flow.areas[1] / flow.areas[0], flow.volumes[1] / flow.volumes[0])


def drifts(found: March, area_ratio: float, volume_ratio: float) -> None:
    """Set the drifts, from end over start of the exact surface."""
    found.area_drift = abs(found.area[-1] / found.area[0] / area_ratio - 1.0)
    found.volume_drift = abs(found.volume[-1] / found.volume[0] / volume_ratio - 1.0)
