"""The linearly implicit BDF scheme on a round sphere: a recursion for R, H and V.

On radial fields x = R omega, nu = omega (projected), H and V constant and z = 0, the scheme without
error in space is

    V^n = Q* + f(t_n),   delta H / tau = -|S|^2 V*,   delta R / tau = V^n,   |S|^2 = 2/R_ext^2,

where Q* = Q(H_ext, |S|^2), and V* = V^n if the reaction is implicit, V_ext if it is extrapolated.
If it is linearised, V* = V^n and Q* = Q(H_ext, |S|^2) + q (H^n - H_ext) with Q = q H + r.

Its errors are multiples of omega and of 1, the H^1 norms of which on a sphere of radius r are
sqrt(4 pi (r^2 / L^2 + 2)) and sqrt(4 pi) r / L, with the unit of length L: the sizes of the errors
that a program measures are known.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from esfem.reference_solutions import laws
from esfem.reference_solutions.sphere import RoundSphere

# Q + f, and q, from H, |S|^2 and t.
Speed = Callable[[float, float, float], tuple[float, float]]
REACTIONS = ("implicit", "extrapolated", "linearised")


@dataclass(frozen=True)
class Radial:
    """Radius, mean curvature and velocity at a time level."""

    R: float
    H: float
    V: float


@dataclass(frozen=True)
class RadialRun:
    """BDF q with step tau on a round sphere whose solution is known, from 0 to steps tau.

    Each of the first q steps is made of ``first_steps`` smaller ones.

    Raises
    ------
    ValueError
        If the reaction is not one of `REACTIONS`.
    """

    solution: RoundSphere
    law: str
    parameters: Mapping[str, float]
    q: int
    tau: float
    steps: int
    self_started: bool
    reaction: str
    first_steps: int = 1

    def __post_init__(self) -> None:
        if self.reaction not in REACTIONS:
            raise ValueError(f"reaction = {self.reaction!r}: must be one of {', '.join(REACTIONS)}")

    def levels(self) -> list[tuple[float, Radial]]:
        """All times and levels; those that have less than q before them exact or self-started."""
        m, divided = self.first_steps, min(self.q, self.steps)
        fine = self._extended([_exact(self.solution, 0.0)], self.tau / m, m * divided)
        whole = self._extended(fine[::m], self.tau, self.steps)
        return [(n / m * self.tau, s) for n, s in enumerate(fine)] + [
            (n * self.tau, s) for n, s in enumerate(whole) if n > divided
        ]

    def _extended(self, levels: list[Radial], tau: float, steps: int) -> list[Radial]:
        """Levels at 0, tau, ..., steps tau, of which the first are given."""
        force = self.solution.forcing(self.law, self.parameters)

        def speed(H: float, S2: float, t: float) -> tuple[float, float]:
            Q, q = (float(part(self.law, self.parameters, H, S2)) for part in (laws.Q, laws.q))
            return Q if force is None else Q + float(force(np.zeros((1, 3)), t)[0]), q

        levels = list(levels)
        for n in range(len(levels), steps + 1):
            t = n * tau
            if n >= self.q:
                levels.append(_step(levels[: -self.q - 1 : -1], t, tau, speed, self.reaction))
            elif self.self_started:
                levels.append(_start(levels[-1], self.q, t, tau, speed))
            else:
                levels.append(_exact(self.solution, t))
        return levels

    def errors(self, length: float | None = None) -> dict[str, float]:
        """Those of x, v, H and V in L-infinity(0,T; H^1), without those in space.

        The unit of length in H^1 is by default that of the solution, the radius at t = 0.
        """
        L = self.solution.length if length is None else length
        found = {"x": 0.0, "v": 0.0, "H": 0.0, "V": 0.0}
        for t, s in self.levels():
            exact = _exact(self.solution, t)
            r = exact.R
            of_normal, of_one = (
                np.sqrt(4.0 * np.pi * (r**2 / L**2 + 2.0)),
                np.sqrt(4.0 * np.pi) * r / L,
            )
            now = {
                "x": abs(s.R - r) * of_normal,
                "v": abs(s.V - exact.V) * of_normal,
                "H": abs(s.H - exact.H) * of_one,
                "V": abs(s.V - exact.V) * of_one,
            }
            found = {name: max(found[name], now[name]) for name in found}
        return found


def _exact(solution: RoundSphere, t: float) -> Radial:
    r = solution.radius_at(t)
    return Radial(r, 2.0 / r, solution.velocity_at(t))


def _step(past: Sequence[Radial], t: float, tau: float, speed: Speed, reaction: str) -> Radial:
    """BDF q from the last q levels, newest first: delta(zeta) = sum_l (1 - zeta)^l / l, and
    extrapolation by (1 - (1 - zeta)^q) / zeta."""
    back, q = Polynomial([1.0, -1.0]), len(past)
    delta = sum((back**l / l for l in range(1, q + 1)), Polynomial([0.0])).coef
    gamma = (1.0 - back**q).coef[1:]
    R, H, V = (np.array([getattr(s, name) for s in past]) for name in "RHV")
    S2, H_ext = 2.0 / (gamma @ R) ** 2, gamma @ H
    Q, slope = speed(H_ext, S2, t)
    # H^n = (-tau |S|^2 V* - sum_j delta_j H^{n-j}) / delta_0
    known = -(delta[1:] @ H) / delta[0]
    if reaction == "linearised":
        V_new = (Q + slope * (known - H_ext)) / (1.0 + slope * tau * S2 / delta[0])
    else:
        V_new = Q
    V_star = gamma @ V if reaction == "extrapolated" else V_new
    return Radial(
        R=(tau * V_new - delta[1:] @ R) / delta[0],
        H=known - tau * S2 * V_star / delta[0],
        V=V_new,
    )


def _start(state: Radial, q: int, t: float, tau: float, speed: Speed) -> Radial:
    """A step of order q: implicit BDF1 with m = 1..q substeps, extrapolated in tau/m to zero."""
    found = np.zeros(3)
    for m in range(1, q + 1):
        s = state
        for i in range(1, m + 1):
            s = _step([s], t - tau + i * tau / m, tau / m, speed, "implicit")
        weight = np.prod([m / (m - l) for l in range(1, q + 1) if l != m])
        found += weight * np.array([s.R, s.H, s.V])
    return Radial(*map(float, found))
