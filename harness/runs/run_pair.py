"""Two runs in lockstep: from a Case and a variation of it to how far their States lie apart."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, Literal

import numpy as np

from esfem.common.provenance import environment
from esfem.measuring.differences import differences, flow_map_difference
from esfem.measuring.lift import error_quadrature
from esfem.meshes import SurfaceMesh
from esfem.reference_solutions import InitialSurface
from esfem.runs.checkpoint import Keeper
from esfem.runs.loop import Status, measured
from esfem.runs.problem import problem_of
from esfem.runs.recorder import LEVELS, append, level_numbers
from esfem.runs.run_case import computational_mesh
from esfem.runs.stepping import states
from esfem.solver import Diverged, Levels, Mesh, SolverFailure, State
from esfem.solver.geometry import geometry
from esfem.solver.reference_element import Array
from esfem.studies.case import Case

TABLES = ("norms", "levels", "varied_levels")  # as `PairRecord` has them


@dataclass(frozen=True)
class PairRecord:
    """How far two runs on one mesh, from one set of nodes, lie apart.

    ``t`` lists the times at which their States were compared. One number a time: ``norms`` of the
    differences (by name, see `esfem.measuring.differences`; of flow maps where the case asks for
    them), and what is measured of each run
    alone, ``levels`` and ``varied_levels`` (by name, see `esfem.runs.recorder`). ``stopped`` names
    the run that ended early, by its field; then ``status``, ``stopped_at`` and ``reason`` are its
    own, and the other one, which was well so far, was not continued. ``seconds``: differences,
    total.
    """

    case: dict[str, Any]
    varied: dict[str, Any]
    mesh: dict[str, Any]
    nodes: int
    status: Status
    stopped: Literal["", "case", "varied"]
    stopped_at: float | None
    reason: str
    t: list[float]
    norms: dict[str, list[float]]
    levels: dict[str, list[float]]
    varied_levels: dict[str, list[float]]
    seconds: dict[str, float]
    environment: dict[str, str] = field(default_factory=environment)


class Walk:
    """One evolution, which is told to what level to go.

    A class because it stands somewhere.

    Parameters
    ----------
    states : of the levels after ``level``.
    level : at which it stands, -1 before the first one.
    passed : is given the number of each level and its State.
    """

    def __init__(
        self, states: Iterator[State], level: int, passed: Callable[[int, State], None]
    ) -> None:
        self._states, self._passed = states, passed
        self.level, self.stopped = level, False

    def to(self, level: int) -> State:
        """Go on to a later level; what ends the evolution is raised, and noted as ``stopped``."""
        while self.level < level:
            try:
                state = next(self._states)
            except (Diverged, SolverFailure):
                self.stopped = True
                raise
            self.level += 1
            self._passed(self.level, state)
        return state


class Apart:
    """How far two runs lie apart so far; it is called with both States, so it changes.

    ``series`` has what a `PairRecord` has, by the name of its field, or of its table and the number
    in it, such as "norms/x". Compared are the States at the times at which runs are compared with a
    reference, at all levels if there are none; but not at the first levels of a multistep method
    that were given by the exact solution: there a run of half the time step has an error in space
    already, and it would count as one in time.
    """

    def __init__(
        self, case: Case, mesh: Mesh, p: Array, solution: InitialSurface, started: float
    ) -> None:
        self.case, self.mesh, self.solution = case, mesh, solution
        self._start = None
        if "flow_map" in case.also:
            self._start = geometry(mesh, p, error_quadrature(mesh.degree))
        self.series: dict[str, list[float]] = {"t": []}
        self._wanted = {case.levels.at(t) for t in case.compare_at}
        self._given = range(1, case.scheme.order) if case.exact_start else range(0)
        self._spent, self._started = 0.0, started

    def __call__(self, n: int, state: State, other: State) -> None:
        """Compare the States of both at the time of level n of the case."""
        if n in self._given or (self._wanted and n not in self._wanted):
            return
        began = perf_counter()
        found = {
            "norms": self._norms(state, other),
            "levels": self._numbers(state),
            "varied_levels": self._numbers(other),
        }
        append(self.series, {"t": state.t})
        for table, numbers in found.items():
            append(self.series, {f"{table}/{name}": value for name, value in numbers.items()})
        self._spent += perf_counter() - began

    def fields(self) -> dict[str, Any]:
        """By the fields of a PairRecord."""
        found: dict[str, Any] = {table: {} for table in TABLES}
        for path, values in self.series.items():
            table, _, name = path.rpartition("/")
            (found[table] if table else found)[name] = values
        return found | {"seconds": {"differences": self._spent, "total": self._gone()}}

    def arrays(self) -> dict[str, Array]:
        """All of it, for a checkpoint: `restore` has it back to the last bit."""
        series = {path: np.array(values) for path, values in self.series.items()}
        return {**series, "seconds": np.array([self._spent, self._gone()])}

    def restore(self, arrays: Mapping[str, Array]) -> None:
        """Take over what another one of the same case had found."""
        found = dict(arrays)
        self._spent, total = found.pop("seconds").tolist()
        self._started -= total
        self.series = {path: values.tolist() for path, values in found.items()}

    def _norms(self, state: State, other: State) -> dict[str, float]:
        length = self.solution.length
        found = differences(self.mesh, state, other, length)
        if self._start is not None:
            found["flow_map"] = flow_map_difference(self._start, state, other, length)
        return found

    def _gone(self) -> float:
        return perf_counter() - self._started

    def _numbers(self, state: State) -> dict[str, float]:
        return level_numbers(LEVELS, self.mesh, state, self.case.law.energy, self.solution)


def run_pair(
    case: Case,
    varied: Case,
    surface: SurfaceMesh,
    report: Callable[[float], None] = lambda fraction: None,
    keeper: Keeper | None = None,
) -> PairRecord:
    """Compute a case and a variation of it side by side, and compare them at each time that both
    have a level at; divergence and solver failure are results, and end both.

    Parameters
    ----------
    case, varied : what to compute, from the same nodes.
    surface : the triangulation of the unit surface.
    report : is told the fraction of time steps done, after each.
    keeper : of a checkpoint, with the levels of the variation ``beside``; the runs go on from
        there, and write the next ones.
    """
    started = perf_counter()
    solution = case.initial
    mesh, p = computational_mesh(surface, solution, case.scheme.degree)
    apart = Apart(case, mesh, p, solution, started)
    kept = None if keeper is None else keeper.resume()
    if kept is not None:
        apart.restore(kept.arrays)

    def walk(of: Case, past: Sequence[State], beside: bool) -> Walk:
        def passed(n: int, state: State) -> None:
            if keeper is not None:
                keeper.remember(n, state, beside)

        level = of.levels.at(past[0].t) if past else -1
        return Walk(states(problem_of(of, mesh, p, solution), of.levels, past), level, passed)

    one = walk(case, () if kept is None else kept.past, False)
    other = walk(varied, () if kept is None else kept.beside, True)

    def watch(_: int, pair: tuple[State, State]) -> None:
        apart(one.level, *pair)
        report(one.level / case.steps)
        if keeper is not None:
            keeper.write_if_due(apart.arrays)

    common = [(n, m) for n, m in common_levels(case.levels, varied.levels) if n > one.level]
    ending = measured(((one.to(n), other.to(m)) for n, m in common), watch)
    return PairRecord(
        case=case.model_dump(mode="json"),
        varied=varied.model_dump(mode="json"),
        mesh=surface.identity,
        nodes=mesh.node_count,
        status=ending.status,
        stopped="case" if one.stopped else "varied" if other.stopped else "",
        stopped_at=ending.t,
        reason=ending.reason,
        **apart.fields(),
    )


def common_levels(one: Levels, other: Levels) -> Iterator[tuple[int, int]]:
    """The levels of both at each time that both have, early before late."""
    for n in range(one.steps + 1):
        try:
            yield n, other.at(one.t(n))
        except ValueError:
            continue
