"""What is measured of a State, at each time level of a run."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any, Protocol, TypeGuard

import numpy as np

from esfem.measuring.lift import (
    ByVariable,
    errors,
    exact_surfaces,
    is_exact,
    nodal_errors,
    unknowns,
)
from esfem.measuring.shape import against_profile, profile_flow, shape_of
from esfem.meshes.quality import radius_ratios
from esfem.reference_solutions import InitialSurface, SurfaceFlow
from esfem.runs.checkpoint import arrays_of, state_of
from esfem.runs.requested import requested
from esfem.solver import Mesh, State
from esfem.solver.functionals import area, normal_lengths, squared_norm, volume, willmore_energy
from esfem.solver.geometry import Geometry, geometry
from esfem.solver.laws import Energy
from esfem.solver.reference_element import Array
from esfem.studies.case import Case

# From the surface, its State, and the energy of the law. Quality is the least ratio of inscribed to
# circumscribed circle, twice, of a triangle of vertices; the area element the least over the mean
# one, 1 on a mesh of equal flat triangles; the distance that of nodes from the origin, which is the
# centre of the solution here.
NUMBERS: dict[str, Callable[[Geometry, State, Energy], float]] = {
    "t": lambda geo, state, energy: state.t,
    "energy": lambda geo, state, energy: energy.value(geo, state.H),
    "dissipation": lambda geo, state, energy: squared_norm(geo, getattr(state, energy.dissipated)),
    "willmore": lambda geo, state, energy: willmore_energy(geo, state.H),
    "area": lambda geo, state, energy: area(geo),
    "volume": lambda geo, state, energy: volume(geo),
    "least_normal": lambda geo, state, energy: normal_lengths(state.nu)[0],
    "greatest_normal": lambda geo, state, energy: normal_lengths(state.nu)[1],
    "least_H": lambda geo, state, energy: float(state.H.min()),
    "greatest_H": lambda geo, state, energy: float(state.H.max()),
    "speed": lambda geo, state, energy: float(np.abs(state.V).max()),
    "least_area_element": lambda geo, state, energy: least_area_element(geo),
    "quality": lambda geo, state, energy: quality(geo.mesh, state.x),
    "least_distance": lambda geo, state, energy: float(np.linalg.norm(state.x, axis=1).min()),
    "greatest_distance": lambda geo, state, energy: float(np.linalg.norm(state.x, axis=1).max()),
    "iterations": lambda geo, state, energy: float(state.work.iterations),
}
LEVELS = (
    *("energy", "dissipation", "willmore", "area", "volume"),
    *("least_normal", "greatest_normal"),
)
# As `esfem.runs.run_case.Record` has them.
NORMS = ("l2", "seminorm")
OF = ("", "nodal_", "idle_")
TABLES = ("levels", "idle_levels", "compared", *(of + norm for of in OF for norm in NORMS))
IDLE = 16  # the initial State kept for ever is measured at the ends of so many parts of a run
START = "start/"  # how the arrays of the first State begin in a checkpoint
PARTS = ("assembly", "factorisation", "krylov", "rest", "errors")


class DecayingMode(Protocol):
    """A solution with a mode that decays."""

    def mode_amplitude(self, x: Array, weights: Array) -> float:
        """The amplitude of the mode in a surface with nodes x (N, 3)."""


def decays(solution: InitialSurface) -> TypeGuard[DecayingMode]:
    """Whether it is a decaying mode."""
    return "decay" in solution.measures


def level_numbers(
    names: Sequence[str],
    mesh: Mesh,
    state: State,
    energy: Energy,
    solution: InitialSurface | None = None,
) -> dict[str, float]:
    """These `NUMBERS` of a State, and the amplitude if the solution is a decaying mode.

    Parameters
    ----------
    names : which; what is not named costs nothing.
    mesh, state : the computed surface.
    energy : that of the law.
    """
    about = state if solution is None else about_centre(state, solution)
    geo = geometry(mesh, about.x)
    found = {name: NUMBERS[name](geo, about, energy) for name in names}
    if solution is not None and decays(solution):
        found["amplitude"] = solution.mode_amplitude(state.x, nodal_weights(geo))
    return found


def about_centre(state: State, solution: InitialSurface) -> State:
    """The State as it is seen from the centre of the solution."""
    if not any(solution.centre):
        return state
    return replace(state, x=state.x - np.array(solution.centre))


def least_area_element(geo: Geometry) -> float:
    """The least area element over the mean one."""
    element = geo.dA / geo.element.weights
    return float(element.min() / element.mean())


def quality(mesh: Mesh, x: Array) -> float:
    """The least quality of a flat triangle of vertices."""
    return float(radius_ratios(x[: mesh.vertex_count], mesh.triangles).min())


def nodal_weights(geo: Geometry) -> Array:
    """int phi_i^2, (N,): positive weights that do not favour densely meshed parts."""
    mesh = geo.mesh
    weights = (geo.dA @ geo.element.phi**2).ravel()
    found: Array = np.bincount(mesh.cells.ravel(), weights, mesh.node_count)  # type: ignore[assignment]  # the stub of numpy knows counts alone
    return found


def append(series: dict[str, list[float]], numbers: dict[str, float]) -> None:
    """A number more in each series."""
    for name, value in numbers.items():
        series.setdefault(name, []).append(value)


def idle_levels(steps: int) -> set[int]:
    """The levels, at most `IDLE` + 1 and the last among them, at which it is measured."""
    return {round(i * steps / IDLE) for i in range(IDLE + 1)}


class Recorder:
    """The numbers of a run so far; it is called with each State, so it changes.

    ``series`` has what a `runs.run_case.Record` has, by the name of its field, or of its table and
    the number in it, such as "levels/energy". The levels have the `LEVELS`; if the solution is a
    decaying mode its amplitude, and the opposite_amplitude of the run that starts from the opposite
    one; err_W, err_area, err_volume and err_distance where nodes slide; and err_<name> of what the
    case asks for (`esfem.runs.requested`), some at one level alone. ``nodal_*`` have the errors
    against the interpolation (`measuring.lift.nodal_errors`); ``idle_*`` the errors of the first
    State kept for ever, at the `idle_levels`, or once where the solution is at rest; ``compared``
    what `esfem.measuring.shape.against_profile` measures.

    Parameters
    ----------
    case, solution : what is computed.
    mesh, p : the mesh, and its nodes (N, 3) on Gamma(0).
    started : when, by `perf_counter`.
    """

    def __init__(
        self, case: Case, mesh: Mesh, p: Array, solution: InitialSurface, started: float
    ) -> None:
        self.case, self.mesh, self.solution = case, mesh, solution
        self.series: dict[str, list[float]] = {"t": [], "iterations": []}
        self._parts, self._started = dict.fromkeys(PARTS, 0.0), started
        self._requested = requested(case, mesh, p, solution)
        self._shape = self._exact_at = None
        if is_exact(solution) and case.plugin.slides:
            self._shape = shape_of(mesh, p, solution)
        elif is_exact(solution):
            self._exact_at = exact_surfaces(mesh, p, solution)
        levels = case.levels
        self._to_compare = {levels.at(t) for t in case.compare_at}
        self._idle_at = {0} if solution.stationary else idle_levels(levels.steps)
        self._snapshots: list[Array] = []
        self._start: State | None = None
        self._moved = False

    def __len__(self) -> int:
        return len(self.series["t"])

    def __call__(self, n: int, state: State) -> None:
        """Measure the State at level n."""
        began, law, solution = perf_counter(), self.case.law, self.solution
        if self._start is None:
            self._start = state
        if not self._moved:
            self._moved = not np.array_equal(unknowns(state), unknowns(self._start))
        numbers = level_numbers(LEVELS, self.mesh, state, law.energy, solution)
        if self._shape is not None:
            numbers |= {f"err_{name}": error for name, error in self._shape(state).items()}
            if n in self._idle_at:
                self._append("idle_levels", self._shape(replace(self._start, t=state.t)))
        numbers |= {f"err_{name}": error for name, error in self._requested(n, state).items()}
        append(self.series, {"t": state.t})
        self._append("levels", numbers)
        if self._exact_at is not None:
            lifted, nodal = self._exact_at(state.t)
            self._append_norms("", errors(lifted, state))
            self._append_norms("nodal_", nodal_errors(nodal, state))
            if n in self._idle_at:
                self._append_norms("idle_", errors(lifted, self._start))
        if n in self._to_compare:
            self._compare(state, numbers)
        if state.work.seconds:
            append(self.series, {"iterations": state.work.iterations})
        for part, spent in (*state.work.seconds.items(), ("errors", perf_counter() - began)):
            self._parts[part] += spent

    def opposite(self, amplitudes: list[float]) -> None:
        """The amplitudes of the run from the opposite one, all levels at once."""
        self.series["levels/opposite_amplitude"] = amplitudes

    def snapshots(self) -> Array | None:
        """The stacked unknowns (times, N, 14) at the times of comparison; None if none is kept."""
        return np.stack(self._snapshots) if self._snapshots else None

    def fields(self) -> dict[str, Any]:
        """All but the snapshots, by the fields of a Record."""
        found: dict[str, Any] = {table: {} for table in TABLES}
        for path, values in self.series.items():
            table, _, name = path.rpartition("/")
            (found[table] if table else found)[name] = values
        found["moved"] = self._moved
        return found | {"seconds": {**self._parts, "total": perf_counter() - self._started}}

    def arrays(self) -> dict[str, Array]:
        """All that was measured, for a checkpoint: `restore` has it back to the last bit."""
        seconds = np.array([*self._parts.values(), perf_counter() - self._started])
        series = {path: np.array(values) for path, values in self.series.items()}
        start = {} if self._start is None else arrays_of(self._start)
        return {
            **series,
            **{f"{START}{name}": values for name, values in start.items()},
            "moved": np.array(self._moved),
            "seconds": seconds,
            "snapshots": np.array(self._snapshots),
        }

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Take over what another Recorder of the same case had measured."""
        found = dict(arrays)
        self._snapshots, self._moved = list(found.pop("snapshots")), bool(found.pop("moved"))
        start = {path: found.pop(path) for path in list(found) if path.startswith(START)}
        if start:
            self._start = state_of({path.removeprefix(START): a for path, a in start.items()})
        *parts, total = found.pop("seconds").tolist()
        self._parts, self._started = dict(zip(PARTS, parts, strict=True)), self._started - total
        self.series = {path: values.tolist() for path, values in found.items()}

    def _append(self, table: str, numbers: dict[str, float]) -> None:
        append(self.series, {f"{table}/{name}": value for name, value in numbers.items()})

    def _append_norms(self, of: str, norms: ByVariable) -> None:
        for i, name in enumerate(NORMS):
            self._append(of + name, {variable: pair[i] for variable, pair in norms.items()})

    def _compare(self, state: State, numbers: dict[str, float]) -> None:
        solution = self.solution
        if isinstance(solution, SurfaceFlow) and solution.reference == "axisymmetric":
            flow = profile_flow(solution, self.case.law, (0.0, *self.case.compare_at))
            i = 1 + len(self.series.get("compared/t", ()))
            about = about_centre(state, solution)
            self._append("compared", against_profile(self.mesh, about, numbers, flow, i))
        else:
            self._snapshots.append(unknowns(state))
