"""One run: from a Case to a Record with what was measured at every time level."""

from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from esfem.common.provenance import environment
from esfem.measuring.lift import in_h1
from esfem.meshes import SurfaceMesh
from esfem.reference_solutions import InitialSurface, decays
from esfem.runs.checkpoint import Keeper
from esfem.runs.loop import Ending, Status, measured, resumed
from esfem.runs.problem import problem_of
from esfem.runs.recorder import Recorder, append, level_numbers
from esfem.runs.stepping import states
from esfem.solver import Mesh, State, elevate
from esfem.solver.functionals import largest_diameter, mesh_width
from esfem.solver.geometry import geometry
from esfem.solver.reference_element import Array
from esfem.studies.case import Case, Solution


@dataclass(frozen=True)
class Record:
    """Everything measured in one run.

    ``t`` lists the time levels that were reached. One number a level: ``l2`` and ``seminorm`` of
    the error u_h - u (by variable; {} without exact solution), ``nodal_l2`` and ``nodal_seminorm``
    of the error against the interpolation u_h - I_h u, and ``levels`` (by name, see
    `esfem.runs.recorder`); one a step: ``iterations``; one a time of comparison: ``compared``; one
    at each of a few levels: ``idle_l2``, ``idle_seminorm`` and ``idle_levels``, the errors of the
    initial State kept for ever. ``length`` is the unit of length that makes norms in H^1 of these.
    ``moved`` is False if no nodal value of any State differs from the start. ``stopped_at`` is the
    time at which a run ended early, with its ``reason``. ``seconds`` by part: assembly,
    factorisation, krylov, rest, errors, total.
    ``snapshots`` (times, N, 14), the nodal unknowns at the times of comparison, are kept in a file
    of their own, whose digest is ``snapshots_digest``.
    """

    case: dict[str, Any]
    mesh: dict[str, Any]
    nodes: int
    h: float
    h_max: float
    length: float
    status: Status
    stopped_at: float | None
    reason: str
    t: list[float]
    l2: dict[str, list[float]]
    seminorm: dict[str, list[float]]
    nodal_l2: dict[str, list[float]]
    nodal_seminorm: dict[str, list[float]]
    idle_l2: dict[str, list[float]]
    idle_seminorm: dict[str, list[float]]
    idle_levels: dict[str, list[float]]
    moved: bool
    levels: dict[str, list[float]]
    compared: dict[str, list[float]]
    iterations: list[int]
    seconds: dict[str, float]
    snapshots_digest: str = ""
    environment: dict[str, str] = field(default_factory=environment)

    def h1(self, length: float | None = None) -> dict[str, list[float]]:
        """The error in H^1 at each level by variable, with this unit of length or its own."""
        return in_h1(self.l2, self.seminorm, self._length(length))

    def nodal_h1(self, length: float | None = None) -> dict[str, list[float]]:
        """The error against the interpolation in H^1, likewise."""
        return in_h1(self.nodal_l2, self.nodal_seminorm, self._length(length))

    def idle_h1(self, length: float | None = None) -> dict[str, list[float]]:
        """The error in H^1 of the initial State kept for ever, likewise, at a few levels."""
        return in_h1(self.idle_l2, self.idle_seminorm, self._length(length))

    def _length(self, asked: float | None) -> float:
        return self.length if asked is None else asked


def computational_mesh(
    surface: SurfaceMesh, solution: InitialSurface, degree: int
) -> tuple[Mesh, Array]:
    """The P_k mesh of a solution and its nodes (N, 3), all exactly on Gamma(0)."""
    return elevate(
        surface.triangles,
        solution.scale * surface.vertices + np.array(solution.centre),
        degree,
        lambda x: solution.closest_point(x, 0.0),
    )


def run_case(
    case: Case,
    surface: SurfaceMesh,
    report: Callable[[float], None] = lambda fraction: None,
    keeper: Keeper | None = None,
) -> tuple[Record, Array | None]:
    """Compute a case on a given triangulation; divergence and solver failure are results.

    Parameters
    ----------
    case : what to compute.
    surface : the triangulation of the unit surface.
    report : is told the fraction of time steps done, after each.
    keeper : of a checkpoint; the run goes on from there, and writes the next ones.

    Returns
    -------
    The record, and the snapshots (times, N, 14) for a comparison with other runs, if it is meant
    for one.
    """
    started = perf_counter()
    solution = case.initial
    mesh, p = computational_mesh(surface, solution, case.scheme.degree)
    start_geometry = geometry(mesh, p)
    recorder = Recorder(case, mesh, p, solution, started)
    past = resumed(recorder.restore, keeper)

    evolutions = 2 if decays(solution) else 1

    def watch(n: int, state: State) -> None:
        recorder(n, state)
        report(n / (evolutions * case.steps))
        if keeper is not None:
            keeper.keep(n, state, recorder.arrays)

    problem = problem_of(case, mesh, p, solution)
    ending = measured(states(problem, case.levels, past), watch, first=len(recorder))
    if decays(solution) and ending.status == "ok":
        amplitudes, ending = opposite_amplitudes(case, surface)
        recorder.opposite(amplitudes)
    record = Record(
        case=case.model_dump(mode="json"),
        mesh=surface.identity,
        nodes=mesh.node_count,
        h=mesh_width(start_geometry),
        h_max=largest_diameter(mesh, p),
        length=solution.length,
        status=ending.status,
        stopped_at=ending.t,
        reason=ending.reason,
        **recorder.fields(),
    )
    return record, recorder.snapshots()


def opposite_amplitudes(case: Case, surface: SurfaceMesh) -> tuple[list[float], Ending]:
    """The amplitudes, level by level, of the mode in the run of the case that starts from the
    opposite amplitude, on the same triangulation; and how it ended.

    It keeps no checkpoint: a run that goes on from one does it anew.
    """
    assert decays(case.initial)
    opposite = {**case.solution.parameters, "amplitude": -case.initial.amplitude}
    start = Solution(name=case.solution.name, **opposite).initial()
    mesh, p = computational_mesh(surface, start, case.scheme.degree)
    found: dict[str, list[float]] = {}

    def watch(n: int, state: State) -> None:
        append(found, level_numbers((), mesh, state, case.law.energy, start))

    ending = measured(states(problem_of(case, mesh, p, start), case.levels), watch)
    return found.get("amplitude", []), ending  # none of a run that could not even start
