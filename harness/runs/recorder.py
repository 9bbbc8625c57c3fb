"""What is measured at each time level of a run."""

from collections.abc import Mapping
from time import perf_counter
from typing import Any

import numpy as np

from esfem.measuring.lift import lifted_errors, unknowns
from esfem.measuring.profile import against_profile, profile_flow
from esfem.measuring.shape import shape_of
from esfem.reference_solutions import InitialSurface
from esfem.runs.level_numbers import append, level_numbers
from esfem.solver import Mesh, State
from esfem.solver.reference_element import Array
from esfem.studies.case import Case

LEVELS = ("energy", "willmore", "area", "volume", "least_normal", "greatest_normal")
TABLES = ("levels", "l2", "h1", "nodal", "compared")  # as `esfem.runs.run_case.Record` has them
PARTS = ("assembly", "factorisation", "krylov", "rest", "errors")


class Recorder:
    """The numbers of a run so far; it is called with each State, so it changes.

    ``series`` has what a `runs.run_case.Record` has, by the name of its field, or of its table and
    the number in it, such as "levels/energy". The levels have the `LEVELS`, amplitude if the
    solution is a decaying mode, and err_W, err_area, err_volume and err_distance where nodes slide;
    ``nodal`` has the errors against the interpolation (`measuring.lift.nodal_errors`), ``compared``
    what `esfem.measuring.profile.against_profile` measures.

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
        exact, slides = solution.always_exact, case.plugin.slides
        self._shape = shape_of(mesh, p, solution) if exact and slides else None
        self._lifted_errors = lifted_errors(mesh, p, solution) if exact and not slides else None
        levels = case.levels
        self._to_compare = {levels.at(t) for t in case.compare_at}
        self._snapshots: list[Array] = []

    def __len__(self) -> int:
        return len(self.series["t"])

    def __call__(self, n: int, state: State) -> None:
        """Measure the State at level n."""
        began, law, solution = perf_counter(), self.case.law, self.solution
        numbers = level_numbers(LEVELS, self.mesh, state, law.energy, solution)
        if self._shape is not None:
            numbers |= {f"err_{name}": error for name, error in self._shape(state).items()}
        append(self.series, {"t": state.t})
        self._append("levels", numbers)
        if self._lifted_errors is not None:
            found, nodal = self._lifted_errors(state)
            self._append("l2", {name: norms[0] for name, norms in found.items()})
            self._append("h1", {name: norms[1] for name, norms in found.items()})
            self._append("nodal", {name: norms[1] for name, norms in nodal.items()})
        if n in self._to_compare:
            self._compare(state, numbers)
        if state.work.seconds:
            append(self.series, {"iterations": state.work.iterations})
        for part, spent in (*state.work.seconds.items(), ("errors", perf_counter() - began)):
            self._parts[part] += spent

    def snapshots(self) -> Array | None:
        """The stacked unknowns (times, N, 14) at the times of comparison; None if none is kept."""
        return np.stack(self._snapshots) if self._snapshots else None

    def fields(self) -> dict[str, Any]:
        """All but the snapshots, by the fields of a Record."""
        found: dict[str, Any] = {table: {} for table in TABLES}
        for path, values in self.series.items():
            table, _, name = path.rpartition("/")
            (found[table] if table else found)[name] = values
        return found | {"seconds": {**self._parts, "total": perf_counter() - self._started}}

    def arrays(self) -> dict[str, Array]:
        """All that was measured, for a checkpoint: `restore` has it back to the last bit."""
        seconds = np.array([*self._parts.values(), perf_counter() - self._started])
        series = {path: np.array(values) for path, values in self.series.items()}
        return {**series, "seconds": seconds, "snapshots": np.array(self._snapshots)}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Take over what another Recorder of the same case had measured."""
        found = dict(arrays)
        self._snapshots = list(found.pop("snapshots"))
        *parts, total = found.pop("seconds").tolist()
        self._parts, self._started = dict(zip(PARTS, parts, strict=True)), self._started - total
        self.series = {path: values.tolist() for path, values in found.items()}

    def _append(self, table: str, numbers: dict[str, float]) -> None:
        append(self.series, {f"{table}/{name}": value for name, value in numbers.items()})

    def _compare(self, state: State, numbers: dict[str, float]) -> None:
        if self.solution.reference == "axisymmetric":
            times = (0.0, *self.case.compare_at)
            flow = profile_flow(self.solution, self.case.law, times)
            i = 1 + len(self.series.get("compared/t", ()))
            self._append("compared", against_profile(self.mesh, state, numbers, flow, i))
        else:
            self._snapshots.append(unknowns(state))
