"""The flow: start-up, the loop over the time levels, and the guards that end a run by name."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from solver.bdf import BDF, combine, extrapolation_weights
from solver.block_system import BlockSystem, NotFinite
from solver.functionals import willmore_energy
from solver.geometry import geometry, interpolate
from solver.mesh import Mesh
from solver.reference_element import Array
from solver.scheme import Scheme, State, correction, projected, step
from solver.threads import one_blas_thread

ENERGY_LIMIT = 1000.0  # a run whose Willmore energy exceeds this multiple of its start has diverged
REMEMBERED = 6  # States kept to guess the next w; more only collect rounding
FORGETS_EVERY = 20  # levels, after which a flow depends on its States alone
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
    tau: float,
    steps: int,
    start: Callable[[float], State] | None = None,
    backend: str | None = None,
    past: Sequence[State] = (),
) -> Iterator[State]:
    """Yield the States at t_n = t_0 + n tau, n = 0..steps, the initial one included.

    To go on with a flow that was interrupted after a `resumable` level n, give the same arguments
    and as ``past`` the last `remembered` States it had yielded. Then the States at n+1..steps
    follow, to the last bit those of a flow that was not interrupted: nothing else is carried from
    step to step, for theta and the guards follow from ``initial``.

    Parameters
    ----------
    mesh, initial : the P_k mesh, and nodal x, nu, H, V, z at t_0.  V and z matter for theta and as
        a first guess.
    scheme : the method, see `solver.scheme.Scheme`.
    tau, steps : step size > 0 and number of steps >= 1.
    start : gives the exact State at a time, for the q - 1 start values of BDF q.  Without it the
        method starts itself by extrapolation of BDF1 (`extrapolated_start`), of the same order q.
    backend : of the direct solver, see `solver.symmetric_solver`.
    past : States at t_n, t_{n-1}, ..., newest first.

    Raises
    ------
    ValueError
        If tau or steps is out of range, or ``past`` not what is needed.
    Diverged
        When a value is not finite, an element is degenerate or inverted, or the energy exceeds
        `ENERGY_LIMIT` times its start.
    SolverFailure
        When the factorisation or GMRES fails.

    Examples
    --------
    README, "From Python", has a run that works as it stands.
    """
    if not (np.isfinite(tau) and tau > 0):
        raise ValueError(f"tau = {tau!r}: must be a positive finite number")
    if steps < 1:
        raise ValueError(f"steps = {steps!r}: must be at least 1")
    block = BlockSystem(mesh.pattern, backend)
    theta = correction(mesh, initial, scheme)
    guard = Guard(mesh, initial, scheme)

    def time(n: int) -> float:
        return initial.t + n * tau

    depth = remembered(scheme.bdf.order)
    history: deque[State] = deque(past[:depth] or [initial], maxlen=depth)
    latest = round((history[0].t - initial.t) / tau)
    if past:
        check_past(past, latest, depth)
    else:
        yield initial
    for n in range(latest + 1, steps + 1):
        try:
            with one_blas_thread():
                if n >= scheme.bdf.order:
                    state = step(mesh, block, history, time(n), tau, scheme, theta)
                elif start is not None:
                    state = start(time(n))
                else:
                    state = extrapolated_start(mesh, block, history[0], time(n), tau, scheme, theta)
        except NotFinite as error:
            raise Diverged(str(error), time(n)) from error
        except ArithmeticError as error:
            raise SolverFailure(str(error), time(n)) from error
        with one_blas_thread():
            guard.check(state)
        history.appendleft(state)
        if resumable(n):
            block.forget()
        yield state


def remembered(order: int) -> int:
    """How many of the last States a step of the BDF of that order depends on."""
    return max(order, REMEMBERED)


def resumable(n: int) -> bool:
    """Whether the States up to level n are all that the levels after it depend on.

    Older factors are carried from step to step, and dropped after these levels, interrupted or not.
    """
    return n >= 0 and n % FORGETS_EVERY == 0


def check_past(past: Sequence[State], n: int, depth: int) -> None:
    """ValueError unless these States, newest first, determine the levels after n."""
    needed = min(n + 1, depth)
    if not resumable(n):
        raise ValueError(f"past: a flow cannot be resumed after level {n}")
    if len(past) < needed:
        raise ValueError(f"past: {len(past)} States given, {needed} needed after level {n}")


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


class Guard:
    """Looks at each State and raises `Diverged` when it means nothing any more.

    A class because it remembers the energy at the start.
    """

    def __init__(self, mesh: Mesh, initial: State, scheme: Scheme) -> None:
        self._mesh, self._quadrature_degree = mesh, scheme.quadrature_degree
        self._limit = ENERGY_LIMIT * self._energy(initial)

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
