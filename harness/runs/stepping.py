"""The States of a problem: from the loop of a scheme, or from its step by the loop here."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from time import perf_counter

import numpy as np

from esfem.common.bad_input import BadInput
from esfem.runs.recovery import completed
from esfem.schemes import OFFERS, Level, Plugin, Problem, named_scheme
from esfem.solver import Diverged, Levels, Memory, Scheme, SolverFailure, State
from esfem.solver.block_system import NotFinite
from esfem.solver.flow import Guard
from esfem.solver.scheme import Work
from esfem.solver.threads import one_blas_thread


def states(problem: Problem, times: Levels, past: Sequence[State] = ()) -> Iterator[State]:
    """The States of a problem at these time levels, by the scheme that its options name; those
    after ``past``, the last States of an interrupted run, newest first."""
    for state, _ in with_levels(problem, times, past):
        yield state


def with_levels(
    problem: Problem, times: Levels, past: Sequence[State] = ()
) -> Iterator[tuple[State, Level | None]]:
    """The `states`, each with the level that it was made from; None of a scheme with a loop of its
    own."""
    scheme = named_scheme(problem.options.name)
    if scheme.run is None:
        return levels(scheme, problem, times)
    return ((state, None) for state in scheme.run(problem, times, past))


def levels(scheme: Plugin, problem: Problem, times: Levels) -> Iterator[tuple[State, Level]]:
    """Yield State and level at each of these time levels, with what the scheme lacks recovered.

    At t = 0 what the start lacks is exact.

    Raises
    ------
    BadInput
        If a level is not what the scheme promises.
    Diverged
        As `esfem.solver.evolve` does.
    SolverFailure
        When a step fails.
    """
    mesh, quadrature = problem.mesh, problem.options.quadrature
    guard = Guard(mesh, problem.initial, Scheme(quadrature_degree=quadrature))
    memory: Memory[Level] = Memory(times, max(scheme.remembers(problem.options), 1))
    with failures(0.0):
        first = scheme.start(problem)
    check_level(problem, first, 0.0)
    memory.add(0, first)
    yield started(problem.initial, first), first
    for n in range(1, times.steps + 1):
        t, past, began = times.t(n), memory.before(n), perf_counter()
        with failures(t), one_blas_thread(), np.errstate(all="ignore"):
            level = scheme.step(replace(problem, tau=times.step(n)), past, t)
            check_level(problem, level, t)
            check_offers(scheme, problem, level)
            work = Work(0, {"rest": perf_counter() - began})
            if not np.isfinite(level.x).all():
                raise NotFinite("x is not finite")
            state = completed(mesh, level, past[0], work, quadrature)
        with one_blas_thread():
            guard.check(state)
        memory.add(n, level)
        yield state, level


@contextmanager
def failures(t: float) -> Iterator[None]:
    """What goes wrong in here ends the run by name, at time t."""
    try:
        yield
    except NotFinite as error:
        raise Diverged(str(error), t) from error
    except (ArithmeticError, RuntimeError, np.linalg.LinAlgError) as error:
        raise SolverFailure(str(error), t) from error


def started(initial: State, level: Level) -> State:
    """The State at t = 0: what the start of the scheme lacks is exact."""
    own = {name: getattr(level, name) for name in given_by(level) if name != "v"}
    return replace(initial, **own, own_v=level.v)


def given_by(level: Level) -> tuple[str, ...]:
    """The quantities that a level has."""
    return tuple(name for name in OFFERS if getattr(level, name) is not None)


def check_offers(scheme: Plugin, problem: Problem, level: Level) -> None:
    """BadInput unless the level has what the scheme offers, neither less nor more."""
    given = given_by(level)
    if set(given) != set(scheme.offers):
        raise BadInput(
            f"scheme {problem.options.name!r}: it offers {', '.join(scheme.offers)}, "
            f"and its step gives {', '.join(given)}"
        )


def check_level(problem: Problem, level: Level, t: float) -> None:
    """BadInput unless it is a Level at t, with H and V (N,) and x, nu, z and v (N, 3)."""
    who = f"scheme {problem.options.name!r}"
    if not isinstance(level, Level):
        raise BadInput(f"{who}: gives {level!r}, must be a Level")
    if level.t != t:
        raise BadInput(f"{who}: gives a level at t = {level.t!r}, must be at {t!r}, which it got")
    for name in given_by(level):
        N, shape = len(problem.initial.x), np.shape(getattr(level, name))
        wanted = (N,) if name in ("H", "V") else (N, 3)
        if shape != wanted:
            raise BadInput(f"{who}: its {name} has shape {shape}, must be {wanted}")
