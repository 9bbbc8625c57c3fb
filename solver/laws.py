"""Velocity laws V = Lap_Gamma H + Q: a law is its nonlinear part Q(H, |S|^2, x, t).

The paper's equations for H, V, nu and z contain Q only as a whole, so another law is another Q,
passed in. Beside it stand q of the split Q = q H + r, by which the linearised reaction takes the
leading part of Q from the new time level (`solver.reaction`), and the `Energy` that the unforced
flow of the law decreases.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from inspect import signature
from typing import Literal, TypeVar

import numpy as np

from esfem.solver.functionals import area, helfrich_energy, willmore_energy
from esfem.solver.geometry import Geometry
from esfem.solver.reference_element import Array

Entry = TypeVar("Entry")


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
        return with_split(law)
    return VelocityLaw(lambda H, S2, x, t: law(H, S2, x, t) + f(x, t), with_split(law).q)


def velocity_law(name: str, **parameters: float) -> VelocityLaw:
    """The law of that name with its parameters bound.

    Raises
    ------
    ValueError
        If there is no such law; the message lists those there are.
    """
    return _of_name(name, LAWS).bound(**parameters)


@dataclass(frozen=True)
class Energy:
    """What the flow of a law decreases where nothing forces it.

    ``value`` takes the geometry and the nodal H (N,) of a discrete surface. W is without dimension,
    as is a Helfrich energy with H0 times a length; an area is a length squared. ``symbol`` is W for
    1/2 int H^2 itself, A for the area, E for what is neither.

    ``dissipated`` is the field of a State with dE/dt = -int |field|^2: V, for the L2 gradient flow
    of E has dE/dt = -int V^2; but z = grad H of surface diffusion, for d area/dt = int H V, which
    with V = Lap H is -int |grad H|^2.
    """

    name: str
    symbol: str
    formula: str
    tex: str
    value: Callable[[Geometry, Array], float]
    dissipated: Literal["V", "z"] = "V"

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


def _area(dissipated: Literal["V", "z"]) -> Energy:
    return Energy("area", "A", "int 1", r"\int 1", lambda geo, H: area(geo), dissipated)


# Of each law, that of second order too: called with the parameters of the law.
ENERGIES: dict[str, Callable[..., Energy]] = {
    "willmore": _willmore_energy,
    "helfrich": _helfrich_energy,
    "surface_diffusion": partial(_area, dissipated="z"),
    "mean_curvature": partial(_area, dissipated="V"),
}


def energy_of(name: str, **parameters: float) -> Energy:
    """The energy of the law of that name and these parameters.

    Raises
    ------
    ValueError
        If there is no such law; the message lists those there are.
    """
    return _of_name(name, ENERGIES)(**parameters)


def _of_name(name: str, table: Mapping[str, Entry]) -> Entry:
    """The entry of that name; ValueError that lists what there is."""
    if name not in table:
        raise ValueError(f"law name = {name!r}: must be one of {', '.join(table)}")
    return table[name]
