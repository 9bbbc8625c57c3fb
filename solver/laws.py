"""Velocity laws V = Lap_Gamma H + Q: a law is its nonlinear part Q(H, |S|^2, x, t), nothing else.

The paper's equations for H, V, nu and z contain Q only as a whole, so another law is another Q,
passed in.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from solver.reference_element import Array

# Q(H, S2, x, t): H, S2 (E, Q) and x (E, Q, 3) at the quadrature points, t the time -> (E, Q).
VelocityLaw = Callable[[Array, Array, Array, float], Array]


def willmore(H: Array, S2: Array, x: Array, t: float) -> Array:
    """Q = -H^3/2 + |S|^2 H: the L2 gradient flow of 1/2 int H^2.  Paper: eq:Willmore-velocity."""
    return -0.5 * H**3 + S2 * H


def helfrich(H: Array, S2: Array, x: Array, t: float, spontaneous_curvature: float) -> Array:
    """Q = |S|^2 (H - H0) - H (H - H0)^2 / 2: the L2 gradient flow of 1/2 int (H - H0)^2."""
    excess = H - spontaneous_curvature
    return S2 * excess - 0.5 * H * excess**2


def surface_diffusion(H: Array, S2: Array, x: Array, t: float) -> Array:
    """Q = 0: the H^-1 gradient flow of the area.  Paper: SF_Eq."""
    return np.zeros_like(H)


def mean_curvature(H: Array) -> Array:
    """V = -H: the L2 gradient flow of the area, of second order: no V = Lap H + Q."""
    return -H


def forced(law: VelocityLaw, f: Callable[[Array, float], Array] | None) -> VelocityLaw:
    """The law with Q + f(x, t), f (E, Q) at the quadrature points; the law itself if f is None.

    V = Lap H + Q + f then enters the equations for H, V, nu and z consistently, by Q alone.
    """
    if f is None:
        return law
    return lambda H, S2, x, t: law(H, S2, x, t) + f(x, t)


LAWS: dict[str, Callable[..., Array]] = {
    "willmore": willmore,
    "helfrich": helfrich,
    "surface_diffusion": surface_diffusion,
}


def velocity_law(name: str, **parameters: float) -> VelocityLaw:
    """The law of that name with its parameters bound.

    Raises
    ------
    ValueError
        If there is no such law; the message lists those there are.
    """
    if name not in LAWS:
        raise ValueError(f"law name = {name!r}: must be one of {', '.join(LAWS)}")
    return partial(LAWS[name], **parameters)
