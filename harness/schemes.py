"""The schemes a study may name: the harness knows of a scheme only its name and its States."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from harness.case import Case, Law
from harness.errors import exact_state
from reference_solutions import ExactSolution, InitialSurface
from reference_solutions.laws import velocity
from solver import BDF, Mesh, Scheme, State, evolve
from solver.laws import forced, velocity_law
from solver.reference_element import Array

# States of a case from its mesh, its nodes (N, 3) on Gamma(0), the solution; and of an interrupted
# run the last States, newest first, after which it goes on.
Run = Callable[[Case, Mesh, Array, InitialSurface, Sequence[State]], Iterator[State]]


def kll(
    case: Case, mesh: Mesh, p: Array, solution: InitialSurface, past: Sequence[State] = ()
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
        quadrature_degree=case.scheme.quadrature,
    )

    start = exact_states(solution, p) if case.exact_start else None
    initial = disturbed(initial_state(case.law, p, solution), case.disturbance)
    return evolve(mesh, initial, scheme, case.tau, case.steps, start, past=past)


def exact_states(solution: ExactSolution, p: Array) -> Callable[[float], State]:
    """t -> the exact State in the nodes that start at p (N, 3)."""
    X = solution.trajectories(p)
    return lambda t: exact_state(solution, X(t), t)


def disturbed(state: State, size: float) -> State:
    """x and u = (H; nu) times 1 + size * normal random numbers, always the same ones."""
    if size == 0.0:
        return state
    noise = 1.0 + size * np.random.default_rng(0).standard_normal((len(state.x), 7))
    return replace(
        state, x=state.x * noise[:, :3], nu=state.nu * noise[:, 3:6], H=state.H * noise[:, 6]
    )


def initial_state(law: Law, p: Array, solution: InitialSurface) -> State:
    """The exact State at t = 0 in nodes p (N, 3); V is that of the law, also where the solution
    moves otherwise to second order."""
    f = solution.fields(p, 0.0)
    V = f.V if solution.always_exact else velocity(law.name, law.parameters, f)
    return State(0.0, p, f.nu, f.H, V, f.z)


SCHEMES: dict[str, Run] = {"kll": kll}
