"""One run: from a Case to a Record with the errors at every time level."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from time import perf_counter
from typing import Any, Literal

from harness.case import Case
from harness.errors import VARIABLES, LiftedSurface, errors, lifted_surface
from harness.meshing import SurfaceMesh
from harness.provenance import environment
from harness.schemes import SCHEMES
from reference_solutions import ExactSolution
from solver import Diverged, Mesh, SolverFailure, elevate
from solver.functionals import largest_diameter, mesh_width, normal_lengths, willmore_energy
from solver.geometry import geometry
from solver.reference_element import Array

Status = Literal["ok", "diverged", "failed"]


@dataclass(frozen=True)
class Record:
    """Everything measured in one run.

    ``t`` lists the time levels that were reached; ``l2``, ``h1`` (by variable), ``energy``,
    ``least_normal`` and ``greatest_normal`` have one number a level, ``iterations`` one a step.
    ``stopped_at`` is the time at which a run ended early, with its ``reason``.  ``seconds`` by
    part: assembly, factorisation, krylov, rest, errors, total.
    """

    case: dict[str, Any]
    mesh: dict[str, Any]
    nodes: int
    h: float
    h_max: float
    status: Status
    stopped_at: float | None
    reason: str
    t: list[float]
    l2: dict[str, list[float]]
    h1: dict[str, list[float]]
    energy: list[float]
    least_normal: list[float]
    greatest_normal: list[float]
    iterations: list[int]
    seconds: dict[str, float]
    environment: dict[str, str] = field(default_factory=environment)


def computational_mesh(
    surface: SurfaceMesh, solution: ExactSolution, degree: int
) -> tuple[Mesh, Array]:
    """The P_k mesh of a solution and its nodes (N, 3), all exactly on Gamma(0)."""
    return elevate(
        surface.triangles,
        solution.scale * surface.vertices,
        degree,
        lambda x: solution.closest_point(x, 0.0),
    )


def run_case(
    case: Case, surface: SurfaceMesh, report: Callable[[float], None] = lambda fraction: None
) -> Record:
    """Compute a case on a given triangulation; divergence and solver failure are results.

    Parameters
    ----------
    case : what to compute.
    surface : the triangulation of the unit surface.
    report : is told the fraction of time steps done, after each.
    """
    started = perf_counter()
    solution = case.solution.exact()
    mesh, p = computational_mesh(surface, solution, case.scheme.degree)
    X = solution.trajectories(p)
    start_geometry = geometry(mesh, p)
    levels: dict[str, list[Any]] = {
        name: [] for name in ("t", "energy", "least", "greatest", "iterations")
    }
    l2: dict[str, list[float]] = {name: [] for name in VARIABLES}
    h1: dict[str, list[float]] = {name: [] for name in VARIABLES}
    seconds = dict.fromkeys(("assembly", "factorisation", "krylov", "rest", "errors"), 0.0)
    status, stopped_at, reason = "ok", None, ""
    lifted: LiftedSurface | None = None
    try:
        for n, state in enumerate(SCHEMES[case.scheme.name](case, mesh, X, solution)):
            measured = perf_counter()
            if lifted is None or not solution.stationary:
                lifted = lifted_surface(mesh, solution, X(state.t), state.t)
            for name, (error_l2, error_h1) in errors(lifted, state).items():
                l2[name].append(error_l2)
                h1[name].append(error_h1)
            levels["t"].append(state.t)
            levels["energy"].append(willmore_energy(geometry(mesh, state.x), state.H))
            least, greatest = normal_lengths(state.nu)
            levels["least"].append(least)
            levels["greatest"].append(greatest)
            if state.work.seconds:
                levels["iterations"].append(state.work.iterations)
            for part, spent in state.work.seconds.items():
                seconds[part] += spent
            seconds["errors"] += perf_counter() - measured
            report(n / case.steps)
    except Diverged as stop:
        status, stopped_at, reason = "diverged", stop.t, stop.reason
    except SolverFailure as stop:
        status, stopped_at, reason = "failed", stop.t, stop.reason
    return Record(
        case=case.model_dump(mode="json"),
        mesh={
            "surface": surface.surface,
            "vertices": len(surface.vertices),
            "digest": surface.digest,
        },
        nodes=mesh.node_count,
        h=mesh_width(start_geometry),
        h_max=largest_diameter(mesh, p),
        status=status,
        stopped_at=stopped_at,
        reason=reason,
        t=levels["t"],
        l2=l2,
        h1=h1,
        energy=levels["energy"],
        least_normal=levels["least"],
        greatest_normal=levels["greatest"],
        iterations=levels["iterations"],
        seconds={**seconds, "total": perf_counter() - started},
    )


def as_json(record: Record) -> dict[str, Any]:
    """The record as plain data."""
    return asdict(record)
