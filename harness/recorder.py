"""What is measured at each time level of a run."""

from collections.abc import Mapping
from time import perf_counter

import numpy as np

from harness.case import Case
from harness.errors import lifted_errors, unknowns
from harness.level_numbers import append, level_numbers
from harness.reference import against_profile, profile_flow
from harness.schemes import named_scheme
from harness.shape import shape_of
from reference_solutions import InitialSurface
from solver import Mesh, State
from solver.reference_element import Array

LEVELS = ("energy", "willmore", "area", "volume", "least_normal", "greatest_normal")
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
        self.t: list[float] = []
        self.iterations: list[int] = []
        self.levels: dict[str, list[float]] = {}
        self.l2: dict[str, list[float]] = {}
        self.h1: dict[str, list[float]] = {}
        self.nodal: dict[str, list[float]] = {}
        self.compared: dict[str, list[float]] = {}
        self.seconds = dict.fromkeys(PARTS, 0.0)
        self.total = 0.0
        exact, slides = solution.always_exact, named_scheme(case.scheme.name).slides
        self._shape = shape_of(mesh, p, solution) if exact and slides else None
        self._lifted_errors = lifted_errors(mesh, p, solution) if exact and not slides else None
        levels = case.levels
        self._to_compare = {levels.at(t) for t in case.compare_at}
        self._snapshots: list[Array] = []

    def __call__(self, n: int, state: State) -> None:
        """Measure the State at level n."""
        started = perf_counter()
        self.t.append(state.t)
        law, solution = self.case.law, self.solution
        append(self.levels, level_numbers(LEVELS, self.mesh, state, law.energy, solution))
        if self._shape is not None:
            append(self.levels, {f"err_{k}": e for k, e in self._shape(state).items()})
        if self._lifted_errors is not None:
            found, nodal = self._lifted_errors(state)
            append(self.l2, {name: norms[0] for name, norms in found.items()})
            append(self.h1, {name: norms[1] for name, norms in found.items()})
            append(self.nodal, {name: norms[1] for name, norms in nodal.items()})
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

    def _compare(self, state: State) -> None:
        if self.solution.reference == "axisymmetric":
            times = (0.0, *self.case.compare_at)
            flow = profile_flow(self.solution, self.case.law, times)
            numbers = {name: values[-1] for name, values in self.levels.items()}
            i = 1 + len(self.compared.get("t", ()))
            append(self.compared, against_profile(self.mesh, state, numbers, flow, i))
        else:
            self._snapshots.append(unknowns(state))
