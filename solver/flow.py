"""The flow: start-up, the loop over the time levels, and the guards that end a run by name."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from esfem.solver.bdf import BDF, combine, extrapolation_weights
from esfem.solver.block_system import BlockSystem
from esfem.solver.functionals import length, willmore_energy
from esfem.solver.geometry import geometry, interpolate
from esfem.solver.krylov import NotFinite
from esfem.solver.levels import Levels, Memory
from esfem.solver.mesh import Mesh
from esfem.solver.reference_element import Array
from esfem.solver.scheme import Scheme, State, correction, projected, step
from esfem.solver.threads import one_blas_thread

ENERGY_LIMIT = 1000.0  # a run whose Willmore energy exceeds this multiple of its start has diverged
REMEMBERED = 6  # States kept to guess the next w; more only collect rounding
FORGETS_EVERY = 20  # levels, after which a flow depends on its States alone
# Where the linear algebra of a step fails, the flow has blown up, and no solver is to blame, if
BLOW_UP = 10.0  # the Willmore energy or the speed exceeds this multiple of the start, or
LEAP = 0.1  # a node moves in a step by this part of L = sqrt(area / 4 pi) at the start
AREA_LIMIT = 1e-10  # an area element below this multiple of the mean one is degenerate


class Diverged(ArithmeticError):
    """The discrete flow means nothing any more; ``t`` is the time level at which it was noticed."""

    def __init__(self, reason: str, t: float) -> None:
        super().__init__(f"diverged at t = {t:g}: {reason}")
        self.reason, self.t = reason, t


class SolverFailure(ArithmeticError):
    """The linear algebra of a step failed; ``t`` is the time level that could not be reached."""

    def __init__(self, reason: str, t: float) -> None:
        super().__init__(f"solver failure at t = {t:g}: {reason}")
        self.reason, self.t = reason, t


def evolve(
    mesh: Mesh,
    initial: State,
    scheme: Scheme,
    levels: Levels,
    start: Callable[[float], State] | None = None,
    backend: str | None = None,
    past: Sequence[State] = (),
) -> Iterator[State]:
    """Yield the States at all levels, the initial one included.

    A level that has q levels at equal distances before it (`Levels.history`) is made by BDF q, one
    that has fewer by ``start`` or by `extrapolated_start`.

    To go on with a flow that was interrupted after a `resumable` level n, give the same arguments
    and as ``past`` the States that it had yielded at the levels that later ones depend on
    (`Levels.needed`, with the depth `remembered`). Then the States after level n follow, to the
    last bit those of a flow that was not interrupted: nothing else is carried from step to step,
    for theta and the guards follow from ``initial``.

    Parameters
    ----------
    mesh, initial : the P_k mesh, and nodal x, nu, H, V, z at t_0.  V and z matter for theta and as
        a first guess.
    scheme : the method, see `esfem.solver.scheme.Scheme`.
    levels : the time levels; level 0 is at the time of ``initial``.
    start : gives the exact State at a time, for the q - 1 start values of BDF q.  Without it the
        method starts itself by extrapolation of BDF1 (`extrapolated_start`), of the same order q.
    backend : of the direct solver, see `esfem.solver.symmetric_solver`.
    past : States of earlier levels, newest first.

    Raises
    ------
    ValueError
        If the levels do not begin at ``initial``, or ``past`` is not what is needed.
    Diverged
        When a value is not finite, an element is degenerate or inverted, or the energy exceeds
        `ENERGY_LIMIT` times its start; and when the factorisation or GMRES fails in a step from
        States that have blown up (`Guard.blown_up`).
    SolverFailure
        When the factorisation or GMRES fails in a step from sane States.

    Examples
    --------
    README, "From Python", has a run that works as it stands.
    """
    if levels.t(0) != initial.t:
        raise ValueError(f"initial: is at t = {initial.t!r}, level 0 at {levels.t(0)!r}")
    block = BlockSystem(
        mesh.pattern, backend, length(geometry(mesh, initial.x, scheme.quadrature_degree))
    )
    theta = correction(mesh, initial, scheme)
    guard = Guard(mesh, initial, scheme)
    q = scheme.bdf.order
    memory: Memory[State] = Memory(levels, remembered(q))
    if past:
        latest = resumed(memory, levels, past)
    else:
        latest = 0
        memory.add(0, initial)
        yield initial
    for n in range(latest + 1, levels.steps + 1):
        t, tau, history = levels.t(n), levels.step(n), memory.before(n)
        try:
            with one_blas_thread():
                if len(history) >= q:
                    state = step(mesh, block, history, t, tau, scheme, theta)
                elif start is not None:
                    state = start(t)
                else:
                    state = extrapolated_start(mesh, block, history[0], t, tau, scheme, theta)
        except NotFinite as error:
            raise Diverged(str(error), t) from error
        except ArithmeticError as error:
            reason = guard.blown_up(extrapolated_state(history, t, q), tau)
            if reason is not None:
                raise Diverged(f"{reason}, and the step fails: {error}", t) from error
            raise SolverFailure(str(error), t) from error
        with one_blas_thread():
            guard.check(state)
        memory.add(n, state)
        if resumable(n):
            block.forget()
        yield state


def remembered(order: int) -> int:
    """How many States before it a step of the BDF of that order depends on."""
    return max(order, REMEMBERED)


def resumable(n: int) -> bool:
    """Whether the States up to level n are all that the levels after it depend on.

    Older factors are carried from step to step, and dropped after these levels, interrupted or not.
    """
    return n >= 0 and n % FORGETS_EVERY == 0


def resumed(memory: Memory[State], levels: Levels, past: Sequence[State]) -> int:
    """The level after which a flow goes on; the States of the past are in the memory then.

    Raises
    ------
    ValueError
        If they are too few, not those of the levels that are needed, or do not determine the rest.
    """
    n = levels.at(past[0].t)
    if not resumable(n):
        raise ValueError(f"past: a flow cannot be resumed after level {n}")
    memory.restore(n, past)
    for i, state in memory.items():
        if state.t != levels.t(i):
            raise ValueError(f"past: a State at t = {state.t!r} given for {levels.t(i)!r}")
    return n


def extrapolated_start(
    mesh: Mesh, block: BlockSystem, state: State, t: float, tau: float, scheme: Scheme, theta: Array
) -> State:
    """One step of order q from a single State: BDF1 with m = 1..q substeps, extrapolated.

    The reaction is implicit, whatever that of the scheme: with w of the last level on the right,
    the first substep, from the exact w, is no member of an expansion in powers of tau / m.

    See `solver.bdf.extrapolation_weights`; x, nu, ... of the results are combined, nu projected.
    """
    euler = replace(scheme, bdf=BDF.of_order(1), reaction="implicit")
    q = scheme.bdf.order
    results = []
    for m in range(1, q + 1):
        s = state
        for i in range(1, m + 1):
            s = step(mesh, block, [s], state.t + i * tau / m, tau / m, euler, theta)
        results.append(s)
    weights = extrapolation_weights(q)
    x, nu, H, V, z = (
        combine(weights, [getattr(s, name) for s in results]) for name in ("x", "nu", "H", "V", "z")
    )
    nu, z = projected(nu, z, scheme.project)
    own_v = None if results[-1].own_v is None else combine(weights, [s.v for s in results])
    return State(t, x, nu, H, V, z, results[-1].work, own_v)


def speed(state: State) -> float:
    """max |V| of the nodes."""
    return float(np.abs(state.V).max())


def extrapolated_state(history: Sequence[State], t: float, order: int) -> State:
    """The State at t by extrapolation of the last ones, newest first, as the step of BDF of that
    order, or of fewer of them, takes it."""
    past = list(history)[:order]
    gamma = [float(g) for g in BDF.of_order(len(past)).gamma]
    x, nu, H, V, z = (
        combine(gamma, [getattr(s, name) for s in past]) for name in ("x", "nu", "H", "V", "z")
    )
    return State(t, x, nu, H, V, z)


class Guard:
    """Looks at each State and raises `Diverged` when it means nothing any more.

    A class because it remembers energy, length and speed at the start.

    Parameters
    ----------
    mesh, initial, scheme : of the flow.
    power : the law makes velocities of curvatures to this power.
    """

    def __init__(self, mesh: Mesh, initial: State, scheme: Scheme, power: int = 3) -> None:
        self._mesh, self._quadrature_degree = mesh, scheme.quadrature_degree
        self._start = self._energy(initial)
        self._limit = ENERGY_LIMIT * self._start
        self._length = L = length(geometry(mesh, initial.x, scheme.quadrature_degree))
        self._speed = max(speed(initial), L**-power)  # surfaces at rest have none

    def blown_up(self, state: State, tau: float) -> str | None:
        """Why a step of size tau from a State is not to be expected to succeed; None if it is sane.

        It means nothing by itself; or its energy exceeds `BLOW_UP` times that of the start, or its
        speed as many times that of the start or of a sphere of that area; or its nodes leap by
        `LEAP` of the size of the start. No unit enters.
        """
        try:
            energy = self._energy(state)
        except Diverged as stop:
            return f"{stop.reason} where the step starts"
        if energy > BLOW_UP * self._start:
            return f"Willmore energy {energy:.3g} exceeds {BLOW_UP * self._start:.3g}"
        if speed(state) > BLOW_UP * self._speed:
            return f"max |V| = {speed(state):.3g} exceeds {BLOW_UP * self._speed:.3g}"
        leap = tau * speed(state) / self._length
        if leap > LEAP:
            return f"a node moves by {leap:.2g} of the size of the surface in a step"
        return None

    def _energy(self, state: State) -> float:
        for name in ("x", "nu", "H", "V", "z"):
            if not np.isfinite(getattr(state, name)).all():
                raise Diverged(f"{name} is not finite", state.t)
        geo = geometry(self._mesh, state.x, self._quadrature_degree)
        area_element = geo.dA / geo.element.weights
        if area_element.min() <= AREA_LIMIT * area_element.mean():
            element = int(np.argmin(area_element.min(axis=1)))
            raise Diverged(f"element {element} is degenerate", state.t)
        along = np.einsum("epa,epa->ep", geo.normal, interpolate(geo, state.nu))
        if (along <= 0).any():
            element = int(np.argmin(along.min(axis=1)))
            raise Diverged(f"element {element} is inverted against nu_h", state.t)
        return willmore_energy(geo, state.H)

    def check(self, state: State) -> None:
        """Raise `Diverged` with the reason, or return."""
        energy = self._energy(state)
        if energy > self._limit:
            raise Diverged(f"Willmore energy {energy:.3g} exceeds {self._limit:.3g}", state.t)
