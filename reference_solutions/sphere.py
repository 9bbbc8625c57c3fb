"""Round spheres about the origin: at rest, and growing or shrinking."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy.optimize import brentq

from reference_solutions import laws
from reference_solutions.exact import Array, Fields, finite, outer, positive


class RoundSphere:
    """What all spheres of radius R(t) share; a base class, for only R and R' tell them apart.

    H = 2/R, |S|^2 = 2/R^2, V = R'(t), and the Willmore energy is 8 pi for every radius.
    """

    mesh_surface: ClassVar[str] = "sphere"
    linearised: ClassVar[bool] = False
    latest_time = np.inf

    def radius_at(self, t: float) -> float:
        """R(t)."""
        raise NotImplementedError

    def velocity_at(self, t: float) -> float:
        """R'(t)."""
        raise NotImplementedError

    @property
    def law_parameters(self) -> dict[str, float]:
        return {}

    @property
    def scale(self) -> float:
        return self.radius_at(0.0)

    def forcing(
        self, law: str, parameters: Mapping[str, float]
    ) -> Callable[[Array, float], Array] | None:
        laws.check_unforced(self.name, self.laws, self.law_parameters, law, parameters)

    def trajectories(self, p: Array) -> Callable[[float], Array]:
        return lambda t: self.radius_at(t) / self.scale * p

    def closest_point(self, x: Array, t: float) -> Array:
        return self.radius_at(t) * x / np.linalg.norm(x, axis=-1, keepdims=True)

    def closest_point_derivative(self, x: Array, t: float) -> Array:
        length = np.linalg.norm(x, axis=-1)[..., None, None]
        return self.radius_at(t) / length * (np.eye(3) - outer(x, x) / length**2)

    def fields(self, y: Array, t: float) -> Fields:
        R = self.radius_at(t)
        nu = y / R
        zero = np.zeros_like(y[..., 0])
        return Fields(
            nu=nu,
            H=zero + 2.0 / R,
            V=zero + self.velocity_at(t),
            z=np.zeros_like(y),
            S=(np.eye(3) - outer(nu, nu)) / R,
            grad_V=np.zeros_like(y),
            grad_z=np.zeros((*y.shape, 3)),
            laplace_H=zero,
        )

    def energy(self, t: float) -> float:
        return 8.0 * np.pi


@dataclass(frozen=True)
class StationarySphere(RoundSphere):
    """Sphere of radius R about the origin, at rest (paper, section 7.1).

    Raises
    ------
    ValueError
        If ``radius`` is not a positive finite number.
    """

    radius: float = 1.0
    name: ClassVar[str] = "sphere"
    title: ClassVar[str] = "stationary sphere"
    laws: ClassVar[tuple[str, ...]] = ("willmore", "surface_diffusion")
    stationary: ClassVar[bool] = True

    def __post_init__(self) -> None:
        positive(radius=self.radius)

    def radius_at(self, t: float) -> float:
        return self.radius

    def velocity_at(self, t: float) -> float:
        return 0.0

    def trajectories(self, p: Array) -> Callable[[float], Array]:
        return lambda t: p


@dataclass(frozen=True)
class LogisticSphere(RoundSphere):
    """r(t) = r0 r1 / (r1 e^{-kt} + r0 (1 - e^{-kt})): logistic growth from r0 to r1, forced.

    Solves r' = k r (1 - r/r1), with k = ``rate``.

    Raises
    ------
    ValueError
        If a parameter is not a positive finite number.
    """

    r0: float = 1.0
    r1: float = 2.0
    rate: float = 0.5
    name: ClassVar[str] = "logistic_sphere"
    title: ClassVar[str] = "sphere of logistic radius"
    laws: ClassVar[tuple[str, ...]] = tuple(laws.PARAMETERS)
    stationary: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive(r0=self.r0, r1=self.r1, rate=self.rate)

    def radius_at(self, t: float) -> float:
        decay = np.exp(-self.rate * t)
        return self.r0 * self.r1 / (self.r1 * decay - self.r0 * np.expm1(-self.rate * t))

    def velocity_at(self, t: float) -> float:
        r = self.radius_at(t)
        return r**2 * self.rate * np.exp(-self.rate * t) * (1.0 / self.r0 - 1.0 / self.r1)

    def forcing(self, law: str, parameters: Mapping[str, float]) -> Callable[[Array, float], Array]:
        laws.check(law, parameters)

        def f(x: Array, t: float) -> Array:
            """f = r' - Q(2/r, 2/r^2), the same everywhere."""
            r = self.radius_at(t)
            Q = laws.Q(law, parameters, 2.0 / r, 2.0 / r**2)
            return np.full(x.shape[:-1], self.velocity_at(t) - Q)

        return f


@dataclass(frozen=True)
class HelfrichSphere(RoundSphere):
    """Sphere under the Helfrich flow: R' = H0 (2 - H0 R) / R^2, H0 = ``spontaneous_curvature``.

    With R* = 2/H0, v = R* - R and x = v/v0 - 1, that is R = R0 - v0 x,

        H0^2 t = -v0^2 [ln(1+x) - x + x^2/2] - 2 v0 R0 [ln(1+x) - x] - R0^2 ln(1+x),

    where what would cancel for small H0 has been cancelled by hand. For H0 > 0 the radius tends to
    R*; for H0 < 0 the sphere is extinct at `latest_time`; for H0 = 0 or R0 = R* it rests.

    Raises
    ------
    ValueError
        If ``radius`` is not a positive finite number or ``spontaneous_curvature`` is not finite.
    """

    radius: float = 1.0
    spontaneous_curvature: float = 1.0
    name: ClassVar[str] = "helfrich_sphere"
    title: ClassVar[str] = "sphere with spontaneous curvature"
    laws: ClassVar[tuple[str, ...]] = ("helfrich",)
    stationary: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive(radius=self.radius)
        finite(spontaneous_curvature=self.spontaneous_curvature)

    @property
    def law_parameters(self) -> dict[str, float]:
        return {"spontaneous_curvature": self.spontaneous_curvature}

    @cached_property
    def latest_time(self) -> float:
        if self.spontaneous_curvature >= 0:
            return np.inf
        return float(self._time(np.log1p(self.radius / self._v0)))

    def radius_at(self, t: float) -> float:
        if not 0 <= t < self.latest_time:
            raise ValueError(f"t = {t!r}: must be in [0, {self.latest_time!r})")
        R0, H0 = self.radius, self.spontaneous_curvature
        if t == 0 or H0 == 0 or self._v0 == 0:
            return R0
        # L = ln(v/v0) < 0 is the unknown: dt/dL = -R^2/H0^2 has one sign, and R - R* may underflow.
        lowest = -t * H0**2 / min(R0, 2.0 / H0) ** 2 if H0 > 0 else np.log1p(R0 / self._v0)
        accuracy = {"xtol": 1e-300, "rtol": 4 * np.finfo(float).eps}
        L = brentq(
            lambda L: self._time(L) - t, 1.01 * lowest if H0 > 0 else lowest, 0.0, **accuracy
        )
        return float(R0 - self._v0 * np.expm1(L))

    def velocity_at(self, t: float) -> float:
        R, H0 = self.radius_at(t), self.spontaneous_curvature
        return H0 * (2.0 - H0 * R) / R**2

    @property
    def _v0(self) -> float:
        """R* - R0."""
        return (2.0 - self.spontaneous_curvature * self.radius) / self.spontaneous_curvature

    def _time(self, L: float) -> float:
        """t as a function of L = ln(v/v0)."""
        R0, v0, x = self.radius, self._v0, np.expm1(L)
        terms = v0**2 * _log_remainder(x, L, 2) + 2.0 * v0 * R0 * _log_remainder(x, L, 1)
        return -(terms + R0**2 * L) / self.spontaneous_curvature**2


def _log_remainder(x: float, L: float, n: int) -> float:
    """L = ln(1+x) less the first n terms of its Taylor series, to full relative accuracy."""
    if abs(x) < 0.25:
        j = np.arange(n + 1, n + 33)
        return -np.sum((-x) ** j / j)
    return L + sum((-x) ** j / j for j in range(1, n + 1))
