"""What a case asks a scheme to solve: where it starts, the law, the exact States."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from esfem.measuring.lift import exact_state, is_exact
from esfem.reference_solutions import ExactSolution, Fields, InitialSurface
from esfem.reference_solutions.laws import velocity
from esfem.schemes import Problem
from esfem.solver import Mesh, State
from esfem.solver.laws import VelocityLaw, forced, velocity_law
from esfem.solver.reference_element import Array
from esfem.studies.case import Case, Law


def problem_of(case: Case, mesh: Mesh, p: Array, solution: InitialSurface) -> Problem:
    """What a case asks for, on a mesh with nodes p (N, 3) on Gamma(0)."""
    return Problem(
        mesh=mesh,
        initial=disturbed(initial_state(case.law, p, solution), case.disturbance),
        law=law_of(case.law, solution) if case.law.name != "mean_curvature" else None,
        forcing=solution.forcing(case.law.name, case.law.parameters),
        tau=case.tau,
        options=case.scheme,
        exact=exact_states(solution, p) if case.exact_start and is_exact(solution) else None,
    )


def law_of(law: Law, solution: InitialSurface) -> VelocityLaw:
    """The law V = Lap H + Q with its parameters, and with the forcing that the solution needs."""
    known = velocity_law(law.name, **law.parameters)
    return forced(known, solution.forcing(law.name, law.parameters))


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
    known = f.V if isinstance(f, Fields) and solution.always_exact else None
    V = velocity(law.name, law.parameters, f) if known is None else known
    return State(0.0, p, f.nu, f.H, V, f.z)
