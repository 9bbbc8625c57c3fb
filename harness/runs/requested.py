"""What a run measures because the claim of its study names it (`esfem.studies.case.Case.also`)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from esfem.measuring.flow_map import flow_map_error
from esfem.measuring.gauss_bonnet import gauss_bonnet_error
from esfem.measuring.lift import is_exact
from esfem.measuring.residuals import defects, start_of_w
from esfem.reference_solutions import ExactSolution, InitialSurface
from esfem.runs.problem import law_of
from esfem.schemes.kll import KLLOptions, scheme_of
from esfem.solver import Mesh, State
from esfem.solver.geometry import geometry
from esfem.solver.reference_element import Array
from esfem.studies.case import Case
from esfem.studies.quantities import DEFECTS, STARTS_OF_W

# From the number of a level and its State to numbers by the names of quantities.
Measure = Callable[[int, State], dict[str, float]]


@dataclass(frozen=True)
class Asked:
    """Of what something is measured: a case, its mesh with nodes p (N, 3) on Gamma(0), the
    solution."""

    case: Case
    mesh: Mesh
    p: Array
    solution: InitialSurface

    @property
    def length(self) -> float:
        """The unit of length of the norms."""
        return self.solution.length

    @property
    def exact(self) -> ExactSolution:
        """The solution, which is exact at all times."""
        assert is_exact(self.solution)
        return self.solution


def requested(case: Case, mesh: Mesh, p: Array, solution: InitialSurface) -> Measure:
    """What the case asks for, as a function of level and State; {} where it asks for nothing.

    A group of quantities is measured as a whole if one of it is asked for.
    """
    asked = Asked(case, mesh, p, solution)
    measures = [make(asked) for names, make in MEASURES if set(names) & set(case.also)]

    def measure(n: int, state: State) -> dict[str, float]:
        return {name: value for one in measures for name, value in one(n, state).items()}

    return measure


def _start(asked: Asked) -> Measure:
    options, law = asked.case.scheme, law_of(asked.case.law, asked.solution)
    assert isinstance(options, KLLOptions)
    scheme = scheme_of(options, law)
    return lambda n, state: start_of_w(asked.mesh, state, scheme, asked.length) if n == 0 else {}


def _defects(asked: Asked) -> Measure:
    case, law = asked.case, law_of(asked.case.law, asked.solution)
    exact, quadrature = asked.exact, case.scheme.quadrature
    at = defects(asked.mesh, asked.p, exact, law, case.tau, asked.length, quadrature)
    return lambda n, state: at(state.t) if n == case.steps else {}


def _flow_map(asked: Asked) -> Measure:
    error = flow_map_error(asked.mesh, asked.p, asked.exact, asked.length)
    return lambda n, state: {"flow_map": error(state)}


def _gauss_bonnet(asked: Asked) -> Measure:
    def measure(n: int, state: State) -> dict[str, float]:
        geo = geometry(asked.mesh, state.x, asked.case.scheme.quadrature)
        return {"gauss_bonnet": gauss_bonnet_error(geo, state.nu, state.H)}

    return measure


MEASURES: tuple[tuple[Sequence[str], Callable[[Asked], Measure]], ...] = (
    (tuple(STARTS_OF_W), _start),
    (tuple(DEFECTS), _defects),
    (("flow_map",), _flow_map),
    (("gauss_bonnet",), _gauss_bonnet),
)
