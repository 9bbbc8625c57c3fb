"""The States of a problem: from the loop of a scheme, or from its step by the loop here.

What a step lacks of a State is recovered from the surface by one method, L2 projection. On
Gamma_h[x], with the mass matrix M and the normal n of the surface itself,

    nu = m / |m|  with  M m = int n phi_j,
    H = -w . nu   with  M w = -int grad x . grad phi_j     (w = Lap x = -H nu),
    z             with  M z = int grad H phi_j,
    v = (x^n - x^{n-1}) / tau,  V = v . nu,

each only if the scheme does not offer it, from what it offers. On P_k surfaces n is of order k in
L2, so that errors of recovered quantities are one order poorer in H1 than those of unknowns.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cache, partial
from time import perf_counter

import numpy as np

from esfem.common.bad_input import BadInput
from esfem.schemes import OFFERS, Level, Plugin, Problem, named_scheme
from esfem.solver import Diverged, Levels, Memory, Mesh, Scheme, SolverFailure, State
from esfem.solver.assembly import load, mass_matrix, stiffness_matrix
from esfem.solver.direct import factored
from esfem.solver.flow import Guard
from esfem.solver.functionals import centred
from esfem.solver.geometry import geometry, gradient
from esfem.solver.krylov import NotFinite
from esfem.solver.scheme import Work, unit
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
    assert scheme.step is not None  # or it has a loop of its own
    power = 1 if problem.law is None else 3
    guard = Guard(mesh, problem.initial, Scheme(quadrature_degree=quadrature), power)
    memory: Memory[Level] = Memory(times, max(scheme.remembers(problem.options), 1))
    with failures(0.0):
        first = scheme.start(problem)
    check_level(problem, first, 0.0)
    memory.add(0, first)
    state = started(problem.initial, first)
    yield state, first
    for n in range(1, times.steps + 1):
        t, past, began = times.t(n), memory.before(n), perf_counter()
        tau = times.step(n)
        with (
            failures(t, partial(guard.blown_up, state, tau)),
            one_blas_thread(),
            np.errstate(all="ignore"),
        ):
            level = scheme.step(replace(problem, tau=tau), past, t)
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


def completed(
    mesh: Mesh, level: Level, before: Level, work: Work, quadrature: int | None = None
) -> State:
    """The State of a level, from it and the one before."""
    nu, H, V, z = level.nu, level.H, level.V, level.z
    surface = cache(lambda: geometry(mesh, level.x, quadrature))  # made if something is lacking
    inverse = cache(lambda: factored(mass_matrix(surface())))
    v = (level.x - before.x) / (level.t - before.t) if level.v is None else level.v
    if nu is None:
        nu = unit(inverse()(load(surface(), surface().normal)))
    if H is None:
        w = inverse()(-(stiffness_matrix(surface()) @ centred(level.x)))
        H = -np.einsum("ja,ja->j", w, nu)
    if V is None:
        V = np.einsum("ja,ja->j", v, nu)
    if z is None:
        z = inverse()(load(surface(), gradient(surface(), H)))
    return State(level.t, level.x, nu, H, V, z, work, v)


@contextmanager
def failures(t: float, blown_up: Callable[[], str | None] = lambda: None) -> Iterator[None]:
    """What goes wrong in here ends the run by name, at time t: not finite is diverged, and so is
    any failure if ``blown_up`` has a reason."""
    try:
        yield
    except NotFinite as error:
        raise Diverged(str(error), t) from error
    except (ArithmeticError, RuntimeError, np.linalg.LinAlgError) as error:
        reason = blown_up()
        if reason is not None:
            raise Diverged(f"{reason}, and the step fails: {error}", t) from error
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
