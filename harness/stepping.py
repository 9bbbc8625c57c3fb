"""The loop over the time levels of a scheme that is given by its step."""

from collections import deque
from collections.abc import Iterator
from time import perf_counter

import numpy as np

from harness.case import Case
from harness.plugin import Level, Plugin, Problem, Run
from harness.recovery import completed
from harness.schemes import named_scheme
from harness.start_states import disturbed, exact_states, initial_state
from reference_solutions import InitialSurface
from solver import Diverged, Mesh, Scheme, SolverFailure, State
from solver.block_system import NotFinite
from solver.flow import Guard
from solver.laws import forced, velocity_law
from solver.reference_element import Array
from solver.scheme import Work
from solver.threads import one_blas_thread


def run_of(name: str) -> Run:
    """The States of a case by the scheme of that name."""
    scheme = named_scheme(name)
    if scheme.run is not None:
        return scheme.run
    return lambda case, mesh, p, solution, past: stepped(
        scheme, problem_of(case, mesh, p, solution), case.steps
    )


def problem_of(case: Case, mesh: Mesh, p: Array, solution: InitialSurface) -> Problem:
    """What a case asks for, on a mesh with nodes p (N, 3) on Gamma(0)."""
    forcing = solution.forcing(case.law.name, case.law.parameters)
    fourth_order = case.law.name != "mean_curvature"
    return Problem(
        mesh=mesh,
        initial=disturbed(initial_state(case.law, p, solution), case.disturbance),
        law=forced(velocity_law(case.law.name, **case.law.parameters), forcing)
        if fourth_order
        else None,
        forcing=forcing,
        tau=case.tau,
        options=case.scheme,
        exact=exact_states(solution, p) if case.exact_start else None,
    )


def stepped(scheme: Plugin, problem: Problem, steps: int) -> Iterator[State]:
    """Yield the States at t_n = n tau, n = 0..steps, with what the scheme lacks recovered.

    Raises
    ------
    Diverged
        As `solver.evolve` does.
    SolverFailure
        When a step fails.
    """
    mesh, quadrature = problem.mesh, problem.options.quadrature
    guard = Guard(mesh, problem.initial, Scheme(quadrature_degree=quadrature))
    past: deque[Level] = deque(maxlen=scheme.remembers(problem.options))
    past.append(scheme.start(problem))
    yield problem.initial
    for n in range(1, steps + 1):
        t, started = n * problem.tau, perf_counter()
        try:
            with one_blas_thread(), np.errstate(all="ignore"):
                level = scheme.step(problem, past, t)
                work = Work(0, {"rest": perf_counter() - started})
                if not np.isfinite(level.x).all():
                    raise NotFinite("x is not finite")
                state = completed(mesh, level, past[0], work, quadrature)
        except NotFinite as error:
            raise Diverged(str(error), t) from error
        except (ArithmeticError, RuntimeError, np.linalg.LinAlgError) as error:
            raise SolverFailure(str(error), t) from error
        with one_blas_thread():
            guard.check(state)
        past.appendleft(level)
        yield state
