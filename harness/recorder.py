"""What is measured at each time level of a run."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import perf_counter

import numpy as np
import scipy.sparse as sp

from harness.case import Case
from harness.errors import (
    LiftedSurface,
    error_quadrature,
    errors,
    exact_state,
    lifted_surface,
    nodal_errors,
    unknowns,
)
from harness.reference import against_profile, profile_flow
from harness.shape import shape_errors
from reference_solutions import ExactSolution, InitialSurface
from solver import Mesh, State
from solver.assembly import mass_matrix, stiffness_matrix
from solver.functionals import area, normal_lengths, volume, willmore_energy
from solver.geometry import Geometry, geometry
from solver.reference_element import Array

PARTS = ("assembly", "factorisation", "krylov", "rest", "errors")
KEPT = ("t", "iterations", "total")
SERIES = ("levels", "l2", "h1", "nodal", "compared")


class Recorder:
    """The numbers of a run so far; it is called with each State, so it changes.

    Attributes
    ----------
    t : the time levels.
    levels : at each level, energy (that of the law), willmore (W = 1/2 int H^2), area, volume,
        least_normal and greatest_normal (lengths of the nodal normals), amplitude if the solution
        is a decaying mode, and err_W, err_area, err_volume and err_distance where nodes slide.
    l2, h1 : at each level, the errors by variable, if the solution is exact.
    nodal : likewise, the errors against the interpolation in H^1 (`harness.errors.nodal_errors`).
    compared : at each time of comparison, what `harness.reference.against_profile` measures.
    iterations : of each step that was not given.
    seconds, total : by part, and all together, which its owner sets.
    """

    def __init__(self, case: Case, mesh: Mesh, p: Array, solution: InitialSurface) -> None:
        self.case, self.mesh, self.solution = case, mesh, solution
        self._energy = case.law.energy
        self.t: list[float] = []
        self.iterations: list[int] = []
        self.levels: dict[str, list[float]] = {}
        self.l2: dict[str, list[float]] = {}
        self.h1: dict[str, list[float]] = {}
        self.nodal: dict[str, list[float]] = {}
        self.compared: dict[str, list[float]] = {}
        self.seconds = dict.fromkeys(PARTS, 0.0)
        self.total = 0.0
        exact, slides = solution.always_exact, case.plugin.slides
        self._shape = shape_of(mesh, p, solution) if exact and slides else None
        self._lifted_errors = lifted_errors(mesh, p, solution) if exact and not slides else None
        levels = case.levels
        self._to_compare = {levels.at(t) for t in case.compare_at}
        self._snapshots: list[Array] = []

    def __call__(self, n: int, state: State) -> None:
        """Measure the State at level n."""
        started = perf_counter()
        self.t.append(state.t)
        _append(self.levels, self._numbers(state))
        if self._shape is not None:
            _append(self.levels, {f"err_{k}": e for k, e in self._shape(state).items()})
        if self._lifted_errors is not None:
            found, nodal = self._lifted_errors(state)
            _append(self.l2, {name: norms[0] for name, norms in found.items()})
            _append(self.h1, {name: norms[1] for name, norms in found.items()})
            _append(self.nodal, {name: norms[1] for name, norms in nodal.items()})
        if n in self._to_compare:
            self._compare(state)
        if state.work.seconds:
            self.iterations.append(state.work.iterations)
        for part, spent in state.work.seconds.items():
            self.seconds[part] += spent
        self.seconds["errors"] += perf_counter() - started

    def snapshots(self) -> Array | None:
        """The stacked unknowns (times, N, 14) at the times of comparison; None if none is kept."""
        return np.stack(self._snapshots) if self._snapshots else None

    def arrays(self) -> dict[str, Array]:
        """All that was measured, for a checkpoint: `restore` has it back to the last bit."""
        series = {
            f"{table}/{name}": np.array(values)
            for table in SERIES
            for name, values in getattr(self, table).items()
        }
        lists = {name: np.array(getattr(self, name)) for name in KEPT}
        seconds = {f"seconds/{part}": np.array(spent) for part, spent in self.seconds.items()}
        return {**lists, **series, **seconds, "snapshots": np.array(self._snapshots)}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Take over what another Recorder of the same case had measured."""
        for name in KEPT:
            setattr(self, name, arrays[name].tolist())
        for path, values in arrays.items():
            table, _, name = path.partition("/")
            if name and table in (*SERIES, "seconds"):
                getattr(self, table)[name] = values.tolist()
        self._snapshots = list(arrays["snapshots"])

    def _numbers(self, state: State) -> dict[str, float]:
        geo = geometry(self.mesh, state.x)
        least, greatest = normal_lengths(state.nu)
        numbers = {
            "energy": self._energy.value(geo, state.H),
            "willmore": willmore_energy(geo, state.H),
            "area": area(geo),
            "volume": volume(geo),
            "least_normal": least,
            "greatest_normal": greatest,
        }
        if "decay" in self.solution.measures:
            numbers["amplitude"] = self.solution.mode_amplitude(state.x, nodal_weights(geo))
        return numbers

    def _compare(self, state: State) -> None:
        if self.solution.reference == "axisymmetric":
            times = (0.0, *self.case.compare_at)
            flow = profile_flow(self.solution, self.case.law, times)
            numbers = {name: values[-1] for name, values in self.levels.items()}
            i = 1 + len(self.compared.get("t", ()))
            _append(self.compared, against_profile(self.mesh, state, numbers, flow, i))
        else:
            self._snapshots.append(unknowns(state))


def shape_of(mesh: Mesh, p: Array, solution: ExactSolution) -> Callable[[State], dict[str, float]]:
    """State -> its errors of shape; a surface at rest is parametrised once."""
    X = solution.trajectories(p)
    rest = lifted_surface(mesh, solution, X(0.0), 0.0).geometry if solution.stationary else None

    def measure(state: State) -> dict[str, float]:
        exact = rest or lifted_surface(mesh, solution, X(state.t), state.t).geometry
        return shape_errors(exact, solution, state)

    return measure


ByVariable = dict[str, tuple[float, float]]  # the norms L2 and H1


@dataclass(frozen=True)
class Exact:
    """The exact surface at a time: lifted, and interpolated in its nodes with M and A there."""

    lifted: LiftedSurface
    nodes: State
    mass: sp.csr_array
    stiffness: sp.csr_array


def exact_at(mesh: Mesh, solution: ExactSolution, x: Array, t: float) -> Exact:
    """The exact surface at time t, its nodes at x (N, 3)."""
    interpolated = geometry(mesh, x, error_quadrature(mesh.degree))
    matrices = mass_matrix(interpolated), stiffness_matrix(interpolated)
    return Exact(lifted_surface(mesh, solution, x, t), exact_state(solution, x, t), *matrices)


def lifted_errors(
    mesh: Mesh, p: Array, solution: ExactSolution
) -> Callable[[State], tuple[ByVariable, ByVariable]]:
    """State -> its errors by the lift, and against the interpolation; a surface at rest is made
    once."""
    X = solution.trajectories(p)
    at_rest: Exact | None = None

    def measure(state: State) -> tuple[ByVariable, ByVariable]:
        nonlocal at_rest
        exact = at_rest or exact_at(mesh, solution, X(state.t), state.t)
        if solution.stationary:
            at_rest = exact
        nodal = nodal_errors(exact.mass, exact.stiffness, state, exact.nodes)
        return errors(exact.lifted, state), nodal

    return measure


def nodal_weights(geo: Geometry) -> Array:
    """int phi_i^2, (N,): positive weights that do not favour densely meshed parts."""
    mesh = geo.mesh
    return np.bincount(mesh.cells.ravel(), (geo.dA @ geo.element.phi**2).ravel(), mesh.node_count)


def _append(series: dict[str, list[float]], numbers: dict[str, float]) -> None:
    for name, value in numbers.items():
        series.setdefault(name, []).append(value)
