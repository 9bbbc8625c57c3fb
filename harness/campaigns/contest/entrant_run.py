"""One run of one entrant, what was measured on it, and its largest stable time step."""

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from time import process_time
from typing import Any, TypeVar

import numpy as np

from esfem.campaigns.contest.contest import Options, case_of
from esfem.measuring.energies import largest_rise
from esfem.measuring.lift import (
    at_time,
    errors,
    exact_surfaces,
    interpolation,
    is_exact,
    nodal_errors,
)
from esfem.measuring.shape import against_profile, distances, profile_flow
from esfem.meshes import surface_mesh
from esfem.reference_solutions import ExactSolution, SurfaceFlow
from esfem.reference_solutions.axisymmetric import ProfileFlow
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
STEPS = 20
GROWTH = 1.1  # of the own energy over these steps that still counts as stable
LARGEST, SMALLEST = 1.0, 1e-6
FACTOR = 1.1  # between the stable and the unstable end of the answer
Item = TypeVar("Item")


@dataclass
class EntrantRun:
    """What was measured; a list grows while the scheme steps.

    ``levels`` has a number a level by name (`runs.recorder`), and besides "own_energy", the
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


def run_entrant(case: Case, compare: bool = True) -> EntrantRun:
    """Run a case; errors only if they are asked for. Divergence is a result."""
    solution, plugin = case.initial, case.plugin
    length = solution.length
    surface = surface_mesh(solution.mesh_surface, case.vertices)
    mesh, p = computational_mesh(surface, solution, case.scheme.degree)
    problem = problem_of(case, mesh, p, solution)
    found = EntrantRun(mesh.node_count, mesh_width(geometry(mesh, p)))
    apart = None
    if compare and is_exact(solution) and not plugin.slides:
        apart = distance_of_nodes(mesh, p, solution)
    ends: dict[str, State] = {}

    def watch(n: int, item: tuple[tuple[State, Level | None], float]) -> None:
        (state, level), seconds = item
        numbers = level_numbers(NUMBERS, mesh, state, case.law.energy, solution)
        numbers["own_energy"] = numbers["energy"]
        if plugin.energy is not None and level is not None:
            with failures(state.t):
                numbers["own_energy"] = plugin.energy(problem, level)
        if apart is not None:
            numbers["apart"] = apart(state)
        append(found.levels, numbers)
        if n > 0:
            found.seconds.append(seconds)
        ends.update({"end": state} if ends else dict.fromkeys(ENDS, state))

    found.ended = str(measured(timed(with_levels(problem, case.levels)), watch))
    if compare and found.ended == "ok" and is_exact(solution):
        on_exact(found, mesh, solution, ends)
        if not plugin.slides:
            exact_at = exact_surfaces(mesh, p, solution)
            for when, state in ends.items():
                found.errors[when]["x"] = errors(exact_at(state.t)[0], state)["x"].h1(length)
    elif compare and found.ended == "ok" and isinstance(solution, SurfaceFlow):
        by_profile(found, mesh, profile_flow(solution, case.law, (0.0, case.final_time)), ends)
    return found


def timed(items: Iterator[Item]) -> Iterator[tuple[Item, float]]:
    """The items, each with the seconds of the processor that it took."""
    while True:
        began = process_time()
        try:
            item = next(items)
        except StopIteration:
            return
        yield item, process_time() - began


def distance_of_nodes(mesh: Mesh, p: Array, solution: ExactSolution) -> Callable[[State], float]:
    """State -> the H^1 norm of x_h minus the interpolation of x, on the interpolated surface."""
    X = solution.trajectories(p)
    exact_at = at_time(solution, lambda t: interpolation(mesh, solution, X(t), t))
    return lambda state: nodal_errors(exact_at(state.t), state)["x"].h1(solution.length)


def on_exact(
    found: EntrantRun, mesh: Mesh, solution: ExactSolution, ends: dict[str, State]
) -> None:
    """Set what is known of the first and the last State on an exact solution that is at rest."""
    for when, state in ends.items():
        away = distances(geometry(mesh, state.x).points, solution, state.t)
        set_errors(found, when, float(away.max()), solution.willmore(state.t))
    set_drifts(found, area=1.0, volume=1.0)


def by_profile(found: EntrantRun, mesh: Mesh, flow: ProfileFlow, ends: dict[str, State]) -> None:
    """Set what is known of the first and the last State beside the axisymmetric flow."""
    for i, (when, state) in enumerate(ends.items()):
        numbers = {name: values[ENDS[when]] for name, values in found.levels.items()}
        numbers["willmore"] = numbers["energy"]
        errors = against_profile(mesh, state, numbers, flow, i)
        distance = max(errors["distance"], errors["distance_back"])
        set_errors(found, when, distance, flow.willmore[i])
    set_drifts(found, flow.areas[1] / flow.areas[0], flow.volumes[1] / flow.volumes[0])


def set_errors(found: EntrantRun, when: str, distance: float, W: float) -> None:
    """Set the distance, and the errors of both energies as W."""
    energies = {"W": found.levels["energy"], "own_W": found.levels["own_energy"]}
    errors = {name: abs(values[ENDS[when]] / W - 1.0) for name, values in energies.items()}
    found.errors[when] = {"distance": distance, **errors}


def set_drifts(found: EntrantRun, area: float, volume: float) -> None:
    """Set the drifts, from end over start of the exact surface."""
    for name, ratio in (("area", area), ("volume", volume)):
        values = found.levels[name]
        found.errors["end"][f"{name}_drift"] = abs(values[-1] / values[0] / ratio - 1.0)


# The largest stable time step.


def is_stable(options: Options, solution: dict[str, Any], V: int, tau: float) -> bool:
    """Whether `STEPS` steps with P_2 run to their end and the scheme's own energy never exceeds
    `GROWTH` times its start."""
    found = run_entrant(case_of(options, solution, V, tau, STEPS * tau), compare=False)
    own = found.levels["own_energy"]
    bounded = all(energy <= GROWTH * own[0] for energy in own)  # NaN is not
    return found.ended == "ok" and bounded


def largest_stable(stable: Callable[[float], bool]) -> float:
    """The largest step up to which halving and bisection found a scheme stable, within `FACTOR`.

    `LARGEST` if that is stable, 0.0 if not even `SMALLEST` is. Steps are tried from above, so that
    a scheme may be unstable for some smaller step.
    """
    tau = LARGEST
    if stable(tau):
        return tau
    while not stable(tau / 4):
        tau /= 4
        if tau < SMALLEST:
            return 0.0
    low, high = tau / 4, tau
    while high / low > FACTOR:
        middle = (low * high) ** 0.5
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low
