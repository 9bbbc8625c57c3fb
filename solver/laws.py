"""Velocity laws V = Lap_Gamma H + Q: a law is its nonlinear part Q(H, |S|^2, x, t).

The paper's equations for H, V, nu and z contain Q only as a whole, so another law is another Q,
passed in. Beside it stands q of the split Q = q H + r, by which the linearised reaction takes the
leading part of Q from the new time level (`solver.reaction`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from inspect import signature

import numpy as np

from solver.reference_element import Array


@dataclass(frozen=True)
class VelocityLaw:
    """Q, and q of the split Q = q H + r, at the quadrature points; called, it gives Q.

    Both take H, S2 (E, Q), x (E, Q, 3) and t, and then the parameters of the law.
    """

    Q: Callable[..., Array]
    q: Callable[..., Array]

    def __call__(
        self, H: Array, S2: Array, x: Array, t: float, *args: float, **parameters: float
    ) -> Array:
        """Q (E, Q)."""
        return self.Q(H, S2, x, t, *args, **parameters)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of its parameters."""
        return tuple(signature(self.Q).parameters)[4:]

    def bound(self, **parameters: float) -> "VelocityLaw":
        """The law with these parameters."""
        return VelocityLaw(partial(self.Q, **parameters), partial(self.q, **parameters))


# Another law may be passed in as its Q alone.
AnyLaw = VelocityLaw | Callable[[Array, Array, Array, float], Array]


def with_split(law: AnyLaw) -> VelocityLaw:
    """The law itself, or that of a plain function Q, with q = 0 and r = Q."""
    if isinstance(law, VelocityLaw):
        return law
    return VelocityLaw(law, surface_diffusion_q)


def willmore_Q(H: Array, S2: Array, x: Array, t: float) -> Array:
    """Q = -H^3/2 + |S|^2 H: the L2 gradient flow of 1/2 int H^2.  Paper: eq:Willmore-velocity."""
    return -0.5 * H**3 + S2 * H


def willmore_q(H: Array, S2: Array, x: Array, t: float) -> Array:
    """q = |S|^2 - H^2/2, with r = 0."""
    return S2 - 0.5 * H**2


def helfrich_Q(H: Array, S2: Array, x: Array, t: float, spontaneous_curvature: float) -> Array:
    """Q = |S|^2 (H - H0) - H (H - H0)^2 / 2: the L2 gradient flow of 1/2 int (H - H0)^2."""
    excess = H - spontaneous_curvature
    return S2 * excess - 0.5 * H * excess**2


def helfrich_q(H: Array, S2: Array, x: Array, t: float, spontaneous_curvature: float) -> Array:
    """q = |S|^2 - (H - H0)^2/2, with r = -H0 |S|^2."""
    return S2 - 0.5 * (H - spontaneous_curvature) ** 2


def surface_diffusion_Q(H: Array, S2: Array, x: Array, t: float) -> Array:
    """Q = 0: the H^-1 gradient flow of the area.  Paper: SF_Eq."""
    return np.zeros_like(H)


def surface_diffusion_q(H: Array, S2: Array, x: Array, t: float) -> Array:
    """q = 0, with r = 0."""
    return np.zeros_like(H)


willmore = VelocityLaw(willmore_Q, willmore_q)
helfrich = VelocityLaw(helfrich_Q, helfrich_q)
surface_diffusion = VelocityLaw(surface_diffusion_Q, surface_diffusion_q)

LAWS: dict[str, VelocityLaw] = {
    "willmore": willmore,
    "helfrich": helfrich,
    "surface_diffusion": surface_diffusion,
}


def mean_curvature(H: Array) -> Array:
    """V = -H: the L2 gradient flow of the area, of second order: no V = Lap H + Q."""
    return -H


def forced(law: AnyLaw, f: Callable[[Array, float], Array] | None) -> VelocityLaw:
    """The law with Q + f(x, t), f (E, Q) at the quadrature points; the law itself if f is None.

    V = Lap H + Q + f then enters the equations for H, V, nu and z consistently, by Q alone. In the
    split, f belongs to r.
    """
    if f is None:
        return law
    return VelocityLaw(lambda H, S2, x, t: law(H, S2, x, t) + f(x, t), with_split(law).q)


def velocity_law(name: str, **parameters: float) -> VelocityLaw:
    """The law of that name with its parameters bound.

    Raises
    ------
    ValueError
        If there is no such law; the message lists those there are.
    """
    if name not in LAWS:
        raise ValueError(f"law name = {name!r}: must be one of {', '.join(LAWS)}")
    return LAWS[name].bound(**parameters)
