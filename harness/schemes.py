"""The schemes a study may name: the harness knows of a scheme only its name and its States."""

from collections.abc import Callable, Iterator

from harness.case import Case
from harness.errors import exact_state
from reference_solutions import ExactSolution
from solver import BDF, Mesh, Scheme, State, evolve
from solver.laws import velocity_law
from solver.reference_element import Array

# States of a case from its mesh, its nodes p (N, 3) on Gamma(0) and the exact solution.
Run = Callable[[Case, Mesh, Array, ExactSolution], Iterator[State]]


def kll(case: Case, mesh: Mesh, p: Array, solution: ExactSolution) -> Iterator[State]:
    """Kovacs, Li, Lubich: evolution equations for nu and H, BDF with exact start values."""
    scheme = Scheme(
        bdf=BDF.of_order(case.scheme.bdf),
        law=velocity_law(case.law.name, **case.law.parameters),
        project=case.scheme.project,
        theta=case.scheme.theta,
        tolerance=case.scheme.tolerance,
    )

    def exact(t: float) -> State:
        return exact_state(solution, p, t)

    return evolve(mesh, exact(0.0), scheme, case.tau, case.steps, start=exact)


SCHEMES: dict[str, Run] = {"kll": kll}
