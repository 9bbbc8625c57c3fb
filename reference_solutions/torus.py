"""Round tori about the third axis, to start from, and the Clifford torus, at rest under Willmore
flow.

Letters: theta is the angle around the tube (0 on the outer equator), phi the angle about the axis,
rho = R + r cos(theta) the distance from the axis.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from esfem.reference_solutions import laws
from esfem.reference_solutions.exact import (
    Array,
    Fields,
    closest_point_jacobian,
    length_of,
    outer,
    positive,
)
from esfem.reference_solutions.laws import check_unforced


@dataclass(frozen=True)
class Torus:
    """Round torus of radii R > r > 0 as a surface, with its Willmore velocity in closed form.

    kappa_1 = 1/r, kappa_2 = cos(theta)/rho, and with C = R (R^2 - 2 r^2) / (2 r^3) the Willmore
    velocity is V = Lap H + Q = C / rho^3.

    Raises
    ------
    ValueError
        If a radius is not a positive finite number, or r >= R.
    """

    R: float = 1.0
    r: float = 0.6

    def __post_init__(self) -> None:
        positive(R=self.R, r=self.r)
        if self.r >= self.R:
            raise ValueError(
                f"r = {self.r!r}: must be less than R = {self.R!r}, or the torus meets itself"
            )

    def frame(self, x: Array) -> tuple[Array, ...]:
        """cos(theta), sin(theta), tube distance (...) and unit vectors nu, e_theta, e_phi (..., 3).

        All are those of the closest point of x; the last value is the distance of x from the core
        circle.
        """
        axis_distance = np.hypot(x[..., 0], x[..., 1])
        e_rho = np.stack(
            [x[..., 0] / axis_distance, x[..., 1] / axis_distance, 0.0 * axis_distance], -1
        )
        e_phi = np.stack([-e_rho[..., 1], e_rho[..., 0], e_rho[..., 2]], -1)
        tube_distance = np.hypot(axis_distance - self.R, x[..., 2])
        c, s = (axis_distance - self.R) / tube_distance, x[..., 2] / tube_distance
        e_z = np.array([0.0, 0.0, 1.0])
        nu = c[..., None] * e_rho + s[..., None] * e_z
        e_theta = -s[..., None] * e_rho + c[..., None] * e_z
        return c, s, nu, e_theta, e_phi, tube_distance

    def closest_point(self, x: Array) -> Array:
        """Nearest point of the torus, (..., 3); undefined on the axis and on the core circle."""
        *_, nu, _, _, tube_distance = self.frame(x)
        return x - (tube_distance - self.r)[..., None] * nu

    def closest_point_derivative(self, x: Array) -> Array:
        """D closest_point, (..., 3, 3)."""
        c, _, _, e_theta, e_phi, tube_distance = self.frame(x)
        kappa_phi = c / (self.R + self.r * c)
        principal = [(1.0 / self.r + 0.0 * c, e_theta), (kappa_phi, e_phi)]
        return closest_point_jacobian(tube_distance - self.r, principal)

    def fields(self, y: Array) -> Fields:
        """Exact quantities at points y of the torus; V is the Willmore velocity."""
        R, r = self.R, self.r
        c, s, nu, e_theta, e_phi, _ = self.frame(y)
        rho = R + r * c
        C = R * (R**2 - 2.0 * r**2) / (2.0 * r**3)
        g = -R * s / (r * rho**2)  # z = g e_theta
        dg = -R * (c / rho**2 + 2.0 * r * s**2 / rho**3) / r
        return Fields(
            nu=nu,
            H=1.0 / r + c / rho,
            V=C / rho**3,
            z=g[..., None] * e_theta,
            S=outer(e_theta, e_theta) / r + (c / rho)[..., None, None] * outer(e_phi, e_phi),
            grad_V=(3.0 * C * s / rho**4)[..., None] * e_theta,
            grad_z=outer(e_theta, dg[..., None] * e_theta - g[..., None] * nu) / r
            - (s * g / rho)[..., None, None] * outer(e_phi, e_phi),
            laplace_H=dg / r - s * g / rho,
        )

    @property
    def area(self) -> float:
        """4 pi^2 R r."""
        return 4.0 * np.pi**2 * self.R * self.r

    def willmore(self) -> float:
        """W = 2 pi^2 q^2 / sqrt(q^2 - 1), q = R/r."""
        q = self.R / self.r
        return 2.0 * np.pi**2 * q**2 / np.sqrt(q**2 - 1.0)


@dataclass(frozen=True)
class RoundTorus:
    """The round torus as a surface to start from: of its flow the start alone is known.

    It is no surface of equal principal curvatures anywhere, H varies, and V is not zero but for
    R^2 = 2 r^2.

    Raises
    ------
    ValueError
        As `Torus`.
    """

    R: float = 1.0
    r: float = 0.6
    name: ClassVar[str] = "torus"
    title: ClassVar[str] = "round torus, of which the start alone is known"
    mesh_surface: ClassVar[str] = "clifford_torus"
    laws: ClassVar[tuple[str, ...]] = tuple(laws.ALL)
    stationary: ClassVar[bool] = False
    always_exact: ClassVar[bool] = False
    reference: ClassVar[str] = "start"
    measures: ClassVar[tuple[str, ...]] = ()
    latest_time: ClassVar[float] = np.inf

    def __post_init__(self) -> None:
        _ = self.torus

    @property
    def torus(self) -> Torus:
        """The surface."""
        return Torus(self.R, self.r)

    @property
    def law_parameters(self) -> dict[str, float]:
        return {}

    @property
    def scale(self) -> float:
        """R: the tube of the mesh is made thinner or thicker by the projection."""
        return self.R

    @property
    def length(self) -> float:
        return length_of(self.torus.area)

    def forcing(self, law: str, parameters: Mapping[str, float]) -> None:
        laws.check(law, parameters, laws.ALL)

    def closest_point(self, x: Array, t: float = 0.0) -> Array:
        return self.torus.closest_point(x)

    def fields(self, y: Array, t: float = 0.0) -> Fields:
        return self.torus.fields(y)


@dataclass(frozen=True)
class CliffordTorus:
    """The torus R = scale, r = scale / sqrt(2) at rest, W = 4 pi^2 (paper, section 7.1).

    Raises
    ------
    ValueError
        If ``scale`` is not a positive finite number.
    """

    scale: float = 1.0
    name: ClassVar[str] = "clifford_torus"
    title: ClassVar[str] = "Clifford torus"
    mesh_surface: ClassVar[str] = "clifford_torus"
    laws: ClassVar[tuple[str, ...]] = ("willmore",)
    stationary: ClassVar[bool] = True
    always_exact: ClassVar[bool] = True
    reference: ClassVar[str] = "exact"
    measures: ClassVar[tuple[str, ...]] = ()
    latest_time: ClassVar[float] = np.inf

    def __post_init__(self) -> None:
        positive(scale=self.scale)

    @property
    def torus(self) -> Torus:
        """The surface."""
        return Torus(self.scale, self.scale / np.sqrt(2.0))

    @property
    def length(self) -> float:
        return length_of(self.torus.area)

    @property
    def law_parameters(self) -> dict[str, float]:
        return {}

    def forcing(self, law: str, parameters: Mapping[str, float]) -> None:
        check_unforced(self.name, self.laws, self.law_parameters, law, parameters)

    def trajectories(self, p: Array) -> Callable[[float], Array]:
        return lambda t: p

    def closest_point(self, x: Array, t: float) -> Array:
        return self.torus.closest_point(x)

    def closest_point_derivative(self, x: Array, t: float) -> Array:
        return self.torus.closest_point_derivative(x)

    def fields(self, y: Array, t: float) -> Fields:
        return self.torus.fields(y)

    def willmore(self, t: float) -> float:
        return 4.0 * np.pi**2
