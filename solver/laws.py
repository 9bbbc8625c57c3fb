"""Velocity laws V = Lap_Gamma H + Q: a law is its nonlinear part Q(H, |S|^2, x, t), nothing else.

The paper's equations for H, V, nu and z contain Q only as a whole, so another law is another Q,
passed in.  Beside it stands the `Energy` that the unforced flow of the law decreases.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from solver.functionals import area, helfrich_energy, willmore_energy
from solver.geometry import Geometry
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


@dataclass(frozen=True)
class Energy:
    """What the flow of a law decreases where nothing forces it.

    ``value`` takes the geometry and the nodal H (N,) of a discrete surface. W is without dimension,
    as is a Helfrich energy with H0 times a length; an area is a length squared. ``symbol`` is W for
    1/2 int H^2 itself, A for the area, E for what is neither.
    """

    name: str
    symbol: str
    formula: str
    tex: str
    value: Callable[[Geometry, Array], float]

    def __str__(self) -> str:
        return f"{self.name} {self.symbol} = {self.formula}"


def _willmore_energy() -> Energy:
    tex = r"\frac{1}{2} \int H^2"
    return Energy("Willmore energy", "W", "1/2 int H^2", tex, willmore_energy)


def _helfrich_energy(spontaneous_curvature: float) -> Energy:
    H0 = f"{spontaneous_curvature:g}"
    return Energy(
        "Helfrich energy",
        "E",
        f"1/2 int (H - H0)^2 with H0 = {H0}",
        rf"\frac{{1}}{{2}} \int (H - H_0)^2, \; H_0 = {H0}",
        partial(helfrich_energy, spontaneous_curvature=spontaneous_curvature),
    )


def _area() -> Energy:
    return Energy("area", "A", "int 1", r"\int 1", lambda geo, H: area(geo))


# Of each law, that of second order too: called with the parameters of the law.
ENERGIES: dict[str, Callable[..., Energy]] = {
    "willmore": _willmore_energy,
    "helfrich": _helfrich_energy,
    "surface_diffusion": _area,
    "mean_curvature": _area,
}


def energy_of(name: str, **parameters: float) -> Energy:
    """The energy of the law of that name and these parameters.

    Raises
    ------
    ValueError
        If there is no such law; the message lists those there are.
    """
    if name not in ENERGIES:
        raise ValueError(f"law name = {name!r}: must be one of {', '.join(ENERGIES)}")
    return ENERGIES[name](**parameters)
