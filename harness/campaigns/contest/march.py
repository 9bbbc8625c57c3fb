"""One march of one scheme, and what was measured on it."""

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from time import process_time
from typing import Any

import numpy as np

from esfem.measuring.energies import largest_rise
from esfem.measuring.lift import at_time, interpolation, lifted_errors, nodal_errors
from esfem.measuring.shape import against_profile, distances, profile_flow
from esfem.meshes import surface_mesh
from esfem.reference_solutions import InitialSurface
from esfem.runs.loop import measured
from esfem.runs.problem import problem_of
from esfem.runs.recorder import append, level_numbers
from esfem.runs.run_case import computational_mesh
from esfem.runs.stepping import failures, with_levels
from esfem.schemes import Level
from esfem.solver import Mesh, State
from esfem.solver.functionals import mesh_width
from esfem.solver.geometry import geometry
from esfem.solver.reference_element import Array
from esfem.studies.case import Case

NUMBERS = ("t", "energy", "area", "volume", "quality")
ENDS = {"start": 0, "end": -1}  # the level that each of them is


@dataclass
class March:
    """What was measured; a list grows while the scheme steps.

    ``levels`` has a number a level by name (`runs.level_numbers`), and besides "own_energy", the
    discrete one that the scheme itself descends, where it has another than that of the law; and
    "apart", the distance in H^1 of x_h from the interpolation of x, where nodes can be compared.
    ``seconds`` are those of the processor for each step, with what the harness recovers and checks.
    ``errors`` at "start" and "end", as far as they are known: "distance" to the exact surface, "x"
    the error of x in H^1, "W" and "own_W" the relative errors of both energies as W, the energy of
    the law of the contest; and at the end "area_drift" and "volume_drift", how much more or less
    they have changed, relative to the start, than on the exact surface. ``ended`` says how it
    ended.
    """

    nodes: int
    h: float
    levels: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    seconds: list[float] = field(default_factory=list)
    errors: dict[str, dict[str, float]] = field(default_factory=dict)
    ended: str = "ok"

    def rise(self, energy: str = "energy") -> float:
        """The largest increase of an energy, "energy" or "own_energy", in a step after the first,
        before which H is exact and not the scheme's, relative to the start; NaN for a run that
        broke down."""
        if self.ended != "ok":
            return np.nan
        values = self.levels[energy]
        return largest_rise(values, values[0], 1)[0]

    @property
    def furthest(self) -> float:
        """The largest distance of x_h from the interpolation of x; NaN for a run that broke down,
        or where nodes cannot be compared."""
        return max(self.levels.get("apart", ()), default=np.nan) if self.ended == "ok" else np.nan

    @property
    def cpu(self) -> float:
        """All seconds of the steps."""
        return float(sum(self.seconds))

    def at(self, when: str, name: str) -> float:
        """The error of that name at the "start" or the "end", NaN if it is not known."""
        return self.errors.get(when, {}).get(name, np.nan)


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
    mesh, problem = ground.mesh, problem_of(case, ground.mesh, ground.p, solution)
    found = March(mesh.node_count, mesh_width(geometry(mesh, ground.p)))
    apart = distance_of_nodes(ground) if compare and ground.comparable else None
    ends: dict[str, State] = {}

    def watch(n: int, item: tuple[tuple[State, Level | None], float]) -> None:
        (state, level), seconds = item
        numbers = level_numbers(NUMBERS, mesh, state, case.law.energy, solution)
        numbers["own_energy"] = numbers["energy"]
        if case.plugin.energy is not None:
            with failures(state.t):
                numbers["own_energy"] = case.plugin.energy(problem, level)
        if apart is not None:
            numbers["apart"] = apart(state)
        append(found.levels, numbers)
        if n > 0:
            found.seconds.append(seconds)
        ends.update({"end": state} if ends else dict.fromkeys(ENDS, state))

    found.ended = str(measured(timed(with_levels(problem, case.levels)), watch))
    if compare and found.ended == "ok":
        (on_exact if solution.always_exact else by_profile)(found, ground, ends)
    return found


def timed(items: Iterator[Any]) -> Iterator[tuple[Any, float]]:
    """The items, each with the seconds of the processor that it took."""
    done = object()
    while True:
        began = process_time()
        item = next(items, done)
        if item is done:
            return
        yield item, process_time() - began


def distance_of_nodes(ground: Ground) -> Callable[[State], float]:
    """State -> the H^1 norm of x_h minus the interpolation of x, on the interpolated surface."""
    mesh, solution, X = ground.mesh, ground.solution, ground.solution.trajectories(ground.p)
    exact_at = at_time(solution, lambda t: interpolation(mesh, solution, X(t), t))
    return lambda state: nodal_errors(exact_at(state.t), state)["x"][1]


def on_exact(found: March, ground: Ground, ends: dict[str, State]) -> None:
    """Set what is known of the first and the last State on an exact solution that is at rest."""
    solution = ground.solution
    errors = lifted_errors(ground.mesh, ground.p, solution) if ground.comparable else None
    for when, state in ends.items():
        points, W = geometry(ground.mesh, state.x).points, solution.willmore(state.t)
        found.errors[when] = {
            "distance": float(distances(points, solution, state.t).max()),
            "W": abs(found.levels["energy"][ENDS[when]] / W - 1.0),
            "own_W": abs(found.levels["own_energy"][ENDS[when]] / W - 1.0),
        }
        if errors is not None:
            found.errors[when]["x"] = errors(state)[0]["x"][1]
    set_drifts(found, area=1.0, volume=1.0)


def by_profile(found: March, ground: Ground, ends: dict[str, State]) -> None:
    """Set what is known of the first and the last State beside the axisymmetric flow."""
    law, times = ground.case.law, (0.0, ground.case.final_time)
    flow = profile_flow(ground.solution, law, times)
    for i, (when, state) in enumerate(ends.items()):
        numbers = {name: values[ENDS[when]] for name, values in found.levels.items()}
        numbers["willmore"] = numbers["energy"]
        errors = against_profile(ground.mesh, state, numbers, flow, i)
        found.errors[when] = {
            "distance": max(errors["distance"], errors["distance_back"]),
            "W": errors["W"],
            "own_W": abs(numbers["own_energy"] / flow.willmore[i] - 1.0),
        }
    ratios = (values[1] / values[0] for values in (flow.areas, flow.volumes))
    set_drifts(found, *ratios)


def set_drifts(found: March, area: float, volume: float) -> None:
    """Set the drifts, from end over start of the exact surface."""
    for name, ratio in (("area", area), ("volume", volume)):
        values = found.levels[name]
        found.errors["end"][f"{name}_drift"] = abs(values[-1] / values[0] / ratio - 1.0)
