"""One linearly implicit BDF step of the paper's system: from the history to the next State."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Literal

import numpy as np

from esfem.solver.bdf import BDF, combine
from esfem.solver.block_system import BlockSystem
from esfem.solver.direct import factored
from esfem.solver.geometry import geometry
from esfem.solver.krylov import NotFinite
from esfem.solver.laws import AnyLaw, willmore
from esfem.solver.mesh import Mesh
from esfem.solver.reaction import REACTIONS, Known
from esfem.solver.reference_element import Array
from esfem.solver.ritz import ritz_velocity
from esfem.solver.system import assembled


@dataclass(frozen=True)
class Work:
    """What a step cost: GMRES iterations and seconds by part."""

    iterations: int
    seconds: dict[str, float]


@dataclass(frozen=True)
class State:
    """The unknowns at time t: nodal x, nu, z (N, 3) and H, V (N,); v where it is not V nu."""

    t: float
    x: Array
    nu: Array
    H: Array
    V: Array
    z: Array
    work: Work = field(default_factory=lambda: Work(0, {}), compare=False)
    own_v: Array | None = field(default=None, compare=False)

    @property
    def u(self) -> Array:
        """u = (H; nu), (N, 4)."""
        return np.column_stack([self.H, self.nu])

    @property
    def w(self) -> Array:
        """w = (V; z), (N, 4)."""
        return np.column_stack([self.V, self.z])

    @property
    def v(self) -> Array:
        """v = V nu, (N, 3), unless the scheme has another one.  Paper: eq:matrix-form-v."""
        return self.V[:, None] * self.nu if self.own_v is None else self.own_v


@dataclass(frozen=True)
class Scheme:
    """The scheme of Kovacs, Li and Lubich with its options.

    Attributes
    ----------
    bdf : the time discretisation.
    law : Q of the velocity law V = Lap H + Q.
    project : after each step, nu is made of length 1 and z tangential, z - (z . nu) nu; and the
        extrapolated normal is normalised (section 7.1). "nu" leaves z alone.
    theta : add the correction of section 3.4: exact nodal w initially (the theorem's scheme).
    tolerance : of the Krylov iteration, relative to w, in the norm of (L V, z).
    slack : it may stop earlier, at this fraction of an estimate of the error in time of w_ext; 0 is
        never, 0.01 saves an iteration or two and changes errors in time by less than 1 %.
    quadrature_degree : exactness of the quadrature, 2k + 2 if None.
    velocity : "interpolated", v = V nu in the nodes, or "ritz", its `ritz_velocity`.
    reaction : how F w and the leading part of Q are taken, see `esfem.solver.reaction`;
        "extrapolated" is the linearly implicit method of the paper's experiments. To "linearised" a
        law that is a plain function Q, without its split, has q = 0.

    Raises
    ------
    ValueError
        If there is no reaction of that name.
    """

    bdf: BDF = BDF.TABLE[1]
    law: AnyLaw = willmore
    project: bool | Literal["nu"] = True
    theta: bool = False
    tolerance: float = 1e-10
    slack: float = 0.0
    quadrature_degree: int | None = None
    velocity: Literal["interpolated", "ritz"] = "interpolated"
    reaction: str = "implicit"

    def __post_init__(self) -> None:
        if self.reaction not in REACTIONS:
            raise ValueError(f"reaction = {self.reaction!r}: must be one of {', '.join(REACTIONS)}")


def correction(mesh: Mesh, initial: State, scheme: Scheme) -> Array:
    """theta = M(x0) w0 + A(x0) u0 - g(x0, u0), dual (N, 4), or zero.  Paper: vartheta."""
    if not scheme.theta:
        return np.zeros((mesh.node_count, 4))
    on = assembled(mesh, initial.x, initial.u, scheme.law, initial.t, scheme.quadrature_degree)
    return on.M @ initial.w + on.A @ initial.u - on.g


def consistent_w(mesh: Mesh, initial: State, scheme: Scheme) -> Array:
    """w (N, 4) of M w = g - A u at the start: what the scheme without theta makes of x and u."""
    on = assembled(mesh, initial.x, initial.u, scheme.law, initial.t, scheme.quadrature_degree)
    return factored(on.M)(on.g - on.A @ initial.u)


def step(
    mesh: Mesh,
    block: BlockSystem,
    history: Sequence[State],
    t: float,
    tau: float,
    scheme: Scheme,
    theta: Array,
) -> State:
    """The State at t from the last q States, newest first, at t - tau, t - 2 tau, ...

    Older States, if there are, only help to guess u and w where the Krylov iteration starts.

    Solves, with everything assembled on Gamma_h[x_ext], c = delta_0 / tau, and w* and H* of the
    reaction (`esfem.solver.reaction`; L H = int q H phi_j stands in the V-equation alone),

        c M u - A w = F w* + f - M (1/tau) sum_{j>=1} delta_j u^{n-j}
          A u + M w = g + L (H* - H_ext) + theta
        x^n = (tau v^n - sum_{j>=1} delta_j x^{n-j}) / delta_0,   v^n = V^n nu^n.

    Raises
    ------
    NotFinite
        If something assembled is not.
    ArithmeticError
        If the factorisation or the Krylov iteration fails.
    """
    delta, gamma = [float(d) for d in scheme.bdf.delta], [float(g) for g in scheme.bdf.gamma]
    past = list(history)[: scheme.bdf.order]
    started = perf_counter()
    x_ext = combine(gamma, [s.x for s in past])
    u_ext = combine(gamma, [s.u for s in past])
    w_ext = combine(gamma, [s.w for s in past])
    if scheme.project:  # differs: the paper projects after the step, here the extrapolation too
        u_ext = np.column_stack([u_ext[:, 0], unit(u_ext[:, 1:])])
    u_past = combine(delta[1:], [s.u for s in past])
    x_past = combine(delta[1:], [s.x for s in past])

    on = assembled(mesh, x_ext, u_ext, scheme.law, t, scheme.quadrature_degree)
    a, b = on.f - on.M @ u_past / tau, on.g + theta
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise NotFinite("f, g or theta on the extrapolated surface is not finite")
    prepared = perf_counter()

    reaction = REACTIONS[scheme.reaction]
    block.renew(delta[0] / tau, on.M, on.A, reaction.older_factors)
    renewed = perf_counter()

    known = Known(u_ext, w_ext, history, scheme.tolerance, scheme.slack, block.unit)
    solution = reaction.solve(block, on, a, b, known)
    solved = perf_counter()

    H, nu, V, z = solution.u[:, 0], solution.u[:, 1:], solution.w[:, 0], solution.w[:, 1:]
    # differs: the projected normal moves the surface, so that v of the State is its velocity.
    nu, z = projected(nu, z, scheme.project)
    v, own_v = V[:, None] * nu, None
    if scheme.velocity == "ritz":
        geo = geometry(mesh, x_ext, scheme.quadrature_degree)
        v = own_v = ritz_velocity(geo, on.M, on.A, V, nu)
    x = (tau * v - x_past) / delta[0]
    seconds = {
        "assembly": prepared - started,
        "factorisation": renewed - prepared,
        "krylov": solved - renewed,
        "rest": perf_counter() - solved,
    }
    return State(t, x, nu, H, V, z, Work(solution.iterations, seconds), own_v)


def projected(nu: Array, z: Array, project: bool | Literal["nu"] = True) -> tuple[Array, Array]:
    """nu / |nu| and z - (z . nu) nu nodewise; "nu" leaves z alone.  Paper: section 7.1."""
    if not project:
        return nu, z
    nu = unit(nu)
    return nu, z if project == "nu" else z - np.einsum("ja,ja->j", z, nu)[:, None] * nu


def unit(nu: Array) -> Array:
    """nu / |nu| nodewise, (N, 3)."""
    return nu / np.linalg.norm(nu, axis=1, keepdims=True)
