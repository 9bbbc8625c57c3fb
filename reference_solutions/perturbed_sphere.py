"""The perturbed sphere r = R (1 + eps P_l(cos theta)) and its linearised decay."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.polynomial import Legendre, Polynomial

from esfem.reference_solutions.exact import Array, Fields, length_of, positive
from esfem.reference_solutions.laws import check_unforced
from esfem.reference_solutions.radial_graph import RadialGraph


@dataclass(frozen=True)
class PerturbedSphere:
    """r = R (1 + eps(t) P_l(cos theta)), eps = amplitude exp(-(l-1) l (l+1) (l+2) t / R^4).

    P_l is the Legendre polynomial, l = ``degree``, theta the angle from the third axis. To first
    order in eps this solves Willmore flow and surface diffusion. The surface at t = 0 and all its
    ``fields`` are exact for every amplitude, except that V is the normal velocity of this family;
    the velocity which a law gives the surface is `laws.velocity` of the fields. Trajectories are
    radial, which differs from normal ones to second order.

    Raises
    ------
    ValueError
        If ``radius`` is not a positive finite number, not ``|amplitude| <= 0.3`` or l not 2, 3, 4.
    """

    radius: float = 1.0
    amplitude: float = 0.01
    degree: int = 2
    name: ClassVar[str] = "perturbed_sphere"
    title: ClassVar[str] = "perturbed sphere"
    mesh_surface: ClassVar[str] = "sphere"
    laws: ClassVar[tuple[str, ...]] = ("willmore", "surface_diffusion")
    stationary: ClassVar[bool] = False
    always_exact: ClassVar[bool] = False
    reference: ClassVar[str] = "exact"
    measures: ClassVar[tuple[str, ...]] = ("decay",)
    latest_time: ClassVar[float] = np.inf

    def __post_init__(self) -> None:
        positive(radius=self.radius)
        if not abs(self.amplitude) <= 0.3:
            raise ValueError(f"amplitude = {self.amplitude!r}: must have |amplitude| <= 0.3")
        if self.degree not in (2, 3, 4):
            raise ValueError(f"degree = {self.degree!r}: must be 2, 3 or 4")

    @property
    def decay_rate(self) -> float:
        """(l-1) l (l+1) (l+2) / R^4: the mode decays like exp(-decay_rate t)."""
        l = self.degree
        return (l - 1) * l * (l + 1) * (l + 2) / self.radius**4

    @property
    def relative_amplitude(self) -> float:
        """|amplitude|, a part of the radius."""
        return abs(self.amplitude)

    @property
    def law_parameters(self) -> dict[str, float]:
        return {}

    @property
    def scale(self) -> float:
        return self.radius

    @cached_property
    def length(self) -> float:
        return length_of(self.surface(0.0).area())

    def amplitude_at(self, t: float) -> float:
        """eps(t)."""
        return self.amplitude * np.exp(-self.decay_rate * t)

    def mode_amplitude(self, x: Array, weights: Array | float = 1.0) -> float:
        """The amplitude eps of P_l in the shape of nodes x (N, 3).

        Weighted least squares for |x|/R - 1 by P_0, ..., P_l: exact if these are all there is,
        whatever the nodes. ``weights`` (N,), such as the lumped masses, make it the L2 projection.
        """
        length = np.linalg.norm(x, axis=-1)
        modes = np.polynomial.legendre.legvander(x[:, 2] / length, self.degree)
        root = np.sqrt(np.broadcast_to(weights, length.shape))
        displacement = length / self.radius - 1.0
        return float(np.linalg.lstsq(root[:, None] * modes, root * displacement)[0][-1])

    def surface(self, t: float) -> RadialGraph:
        """Gamma(t)."""
        return RadialGraph(self.radius * (1.0 + self.amplitude_at(t) * self._mode))

    def forcing(self, law: str, parameters: Mapping[str, float]) -> None:
        check_unforced(self.name, self.laws, self.law_parameters, law, parameters)

    def trajectories(self, p: Array) -> Callable[[float], Array]:
        mode = self._mode(p[..., 2] / np.linalg.norm(p, axis=-1))[..., None]
        direction = p / (1.0 + self.amplitude * mode)
        return lambda t: (1.0 + self.amplitude_at(t) * mode) * direction

    def closest_point(self, x: Array, t: float) -> Array:
        return self.surface(t).closest_point(x)

    def closest_point_derivative(self, x: Array, t: float) -> Array:
        return self.surface(t).closest_point_derivative(x)

    def fields(self, y: Array, t: float) -> Fields:
        rate = -self.decay_rate * self.radius * self.amplitude_at(t)
        return self.surface(t).fields(y, rate * self._mode)

    def willmore(self, t: float) -> float:
        return self.surface(t).willmore()

    @property
    def _mode(self) -> Polynomial:
        return Legendre.basis(self.degree).convert(kind=Polynomial)
