"""The ellipsoid that breathes along the first axis, moved by its normal velocity."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from esfem.reference_solutions import laws
from esfem.reference_solutions.exact import Array, Fields, positive
from esfem.reference_solutions.spheroid import NEWTON_STEPS, Spheroid, c_order


@dataclass(frozen=True)
class BreathingEllipsoid:
    """x1^2/a(t)^2 + x2^2 + x3^2 = 1, a = 1 + amplitude sin(2 pi t / period), forced.

    It moves by its normal velocity, and so its points do not keep their x2 and x3.

    Raises
    ------
    ValueError
        If ``period`` is not a positive finite number, or not ``0 < |amplitude| < 1``.
    """

    amplitude: float = 0.25
    period: float = 1.0
    name: ClassVar[str] = "breathing_ellipsoid"
    title: ClassVar[str] = "breathing ellipsoid"
    mesh_surface: ClassVar[str] = "sphere"
    laws: ClassVar[tuple[str, ...]] = tuple(laws.PARAMETERS)
    stationary: ClassVar[bool] = False
    always_exact: ClassVar[bool] = True
    reference: ClassVar[str] = "exact"
    measures: ClassVar[tuple[str, ...]] = ()
    scale: ClassVar[float] = 1.0
    latest_time: ClassVar[float] = np.inf

    def __post_init__(self) -> None:
        positive(period=self.period)
        if not 0 < abs(self.amplitude) < 1:
            raise ValueError(f"amplitude = {self.amplitude!r}: must have 0 < |amplitude| < 1")

    @property
    def length(self) -> float:
        return self.scale

    @property
    def law_parameters(self) -> dict[str, float]:
        return {}

    def spheroid(self, t: float) -> Spheroid:
        """Gamma(t)."""
        return Spheroid(1.0 + self.amplitude * np.sin(2.0 * np.pi * t / self.period))

    def rate(self, t: float) -> float:
        """a'(t)."""
        omega = 2.0 * np.pi / self.period
        return self.amplitude * omega * np.cos(omega * t)

    def trajectories(self, p: Array) -> Callable[[float], Array]:
        """X = (a sqrt(A) p1, m p2, m p3), in closed form, for |p| = 1.

        The trajectories are orthogonal to the level sets of x1^2 / (1 - rho^2) = a^2, rho^2 = x2^2
        + x3^2, whatever the speed, and so keep x1^2 + rho^2 - 2 ln rho. With b = a^2 - 1, that is
        m^2 = exp(b A p1^2); and X lies on Gamma(t), which is, divided by p1^2,

            k(A) = A - 1 + b A rho_0^2 (exp(b A p1^2) - 1) / (b A p1^2) = 0.

        k is convex and increasing, and not negative at max(1, 1/a^2): Newton's method descends from
        there monotonically.
        """
        P = c_order(p)
        u, w = P[0] ** 2, P[1] ** 2 + P[2] ** 2

        def X(t: float) -> Array:
            a = self.spheroid(t).a
            b = (a - 1.0) * (a + 1.0)
            A = np.full_like(u, max(1.0, a**-2))
            for _ in range(NEWTON_STEPS):
                v = b * A * u
                step = (A - 1.0 + w * b * A * _expm1_ratio(v)) / (1.0 + w * b * np.exp(v))
                A = A - step
                if np.max(np.abs(step), initial=0.0) < 1e-9 * a**-2:
                    break
            m = np.exp(0.5 * b * A * u)
            return np.stack([a * np.sqrt(A) * P[0], m * P[1], m * P[2]], axis=-1)

        return X

    def closest_point(self, x: Array, t: float) -> Array:
        return self.spheroid(t).closest_point(x)

    def closest_point_derivative(self, x: Array, t: float) -> Array:
        return self.spheroid(t).closest_point_derivative(x)

    def fields(self, y: Array, t: float) -> Fields:
        return self.spheroid(t).fields(y, self.rate(t))

    def forcing(self, law: str, parameters: Mapping[str, float]) -> Callable[[Array, float], Array]:
        laws.check(law, parameters)
        return lambda x, t: self.spheroid(t).forcing(law, parameters, x, self.rate(t))

    def willmore(self, t: float) -> float:
        return self.spheroid(t).willmore()


def _expm1_ratio(v: Array) -> Array:
    """(e^v - 1) / v, and 1 at 0."""
    return np.divide(np.expm1(v), v, out=np.ones_like(v), where=v != 0)
