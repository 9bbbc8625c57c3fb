"""Round spheres about the origin: at rest, and growing or shrinking."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from esfem.reference_solutions import laws
from esfem.reference_solutions.exact import Array, Fields, outer, positive


class RoundSphere:
    """What all spheres of radius R(t) share; a base class, for only R and R' tell them apart.

    H = 2/R, |S|^2 = 2/R^2, V = R'(t), and the Willmore energy is 8 pi for every radius.
    """

    name: ClassVar[str]
    laws: ClassVar[tuple[str, ...]]
    always_exact: ClassVar[bool] = True
    reference: ClassVar[str] = "exact"
    measures: ClassVar[tuple[str, ...]] = ()

    def radius_at(self, t: float) -> float:
        """R(t)."""
        raise NotImplementedError

    def velocity_at(self, t: float) -> float:
        """R'(t)."""
        raise NotImplementedError

    @property
    def latest_time(self) -> float:
        return np.inf

    @property
    def law_parameters(self) -> dict[str, float]:
        return {}

    @property
    def scale(self) -> float:
        return self.radius_at(0.0)

    @property
    def length(self) -> float:
        return self.scale

    def forcing(
        self, law: str, parameters: Mapping[str, float]
    ) -> Callable[[Array, float], Array] | None:
        laws.check_unforced(self.name, self.laws, self.law_parameters, law, parameters)
        return None

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

    def willmore(self, t: float) -> float:
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
    mesh_surface: ClassVar[str] = "sphere"
    laws: ClassVar[tuple[str, ...]] = ("willmore", "surface_diffusion")
    stationary: ClassVar[bool] = True
    measures: ClassVar[tuple[str, ...]] = ("growth",)

    def __post_init__(self) -> None:
        positive(radius=self.radius)

    def radius_at(self, t: float) -> float:
        return self.radius

    def velocity_at(self, t: float) -> float:
        return 0.0

    @property
    def off_constraint_rate(self) -> float:
        """8/R^4: |nu| - 1 of the paper's system grows like exp(8 t/R^4) if not normalised."""
        return 8.0 / self.radius**4

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
    mesh_surface: ClassVar[str] = "sphere"
    laws: ClassVar[tuple[str, ...]] = tuple(laws.PARAMETERS)
    stationary: ClassVar[bool] = False
    measures: ClassVar[tuple[str, ...]] = ("size_x", "size_v", "size_H", "size_V")

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
class ShrinkingSphere(RoundSphere):
    """Sphere under mean curvature flow: R' = -2/R, so R = sqrt(R0^2 - 4 t); extinct at R0^2 / 4.

    Raises
    ------
    ValueError
        If ``radius`` is not a positive finite number.
    """

    radius: float = 1.0
    name: ClassVar[str] = "shrinking_sphere"
    title: ClassVar[str] = "sphere that shrinks by its mean curvature"
    mesh_surface: ClassVar[str] = "sphere"
    laws: ClassVar[tuple[str, ...]] = (laws.MEAN_CURVATURE,)
    stationary: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive(radius=self.radius)

    @property
    def latest_time(self) -> float:
        return self.radius**2 / 4.0

    def radius_at(self, t: float) -> float:
        if not 0 <= t < self.latest_time:
            raise ValueError(f"t = {t!r}: must be in [0, {self.latest_time!r})")
        return float(np.sqrt(self.radius**2 - 4.0 * t))

    def velocity_at(self, t: float) -> float:
        return -2.0 / self.radius_at(t)
