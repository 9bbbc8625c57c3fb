"""The schemes a study may name: the harness knows of a scheme only its name and its States."""

from collections.abc import Callable, Iterator

from harness.case import Case
from harness.errors import exact_state
from reference_solutions import ExactSolution
from solver import BDF, Mesh, Scheme, State, evolve
from solver.laws import forced, velocity_law
from solver.reference_element import Array

# States of a case from its mesh, the exact motion t -> X(., t) (N, 3) of its nodes, the solution.
Run = Callable[[Case, Mesh, Callable[[float], Array], ExactSolution], Iterator[State]]


def kll(
    case: Case, mesh: Mesh, X: Callable[[float], Array], solution: ExactSolution
) -> Iterator[State]:
    """Kovacs, Li, Lubich: evolution equations for nu and H, linearly implicit BDF."""
    scheme = Scheme(
        bdf=BDF.of_order(case.scheme.bdf),
        law=forced(
            velocity_law(case.law.name, **case.law.parameters),
            solution.forcing(case.law.name, case.law.parameters),
        ),
        project=case.scheme.project,
        theta=case.scheme.theta,
        tolerance=case.scheme.tolerance,
    )

    def exact(t: float) -> State:
        return exact_state(solution, X(t), t)

    start = exact if case.scheme.start == "exact" else None
    return evolve(mesh, exact(0.0), scheme, case.tau, case.steps, start)


SCHEMES: dict[str, Run] = {"kll": kll}
