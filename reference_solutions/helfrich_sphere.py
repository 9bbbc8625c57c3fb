"""The sphere that spontaneous curvature makes grow to a radius of its own, or shrink to a point."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy.optimize import brentq

from esfem.reference_solutions.exact import finite, positive
from esfem.reference_solutions.sphere import RoundSphere


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
    mesh_surface: ClassVar[str] = "sphere"
    laws: ClassVar[tuple[str, ...]] = ("helfrich",)
    stationary: ClassVar[bool] = False

    def __post_init__(self) -> None:
        super().__post_init__()
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
        L = brentq(
            lambda L: self._time(L) - t,
            1.01 * lowest if H0 > 0 else lowest,
            0.0,
            xtol=1e-300,
            rtol=4 * np.finfo(float).eps,
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
