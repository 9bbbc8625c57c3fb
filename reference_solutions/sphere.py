"""The round sphere: stationary under Willmore flow, W = 8 pi for every radius."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from reference_solutions.exact import Array, Fields, outer, positive


@dataclass(frozen=True)
class StationarySphere:
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
    law: ClassVar[str] = "willmore"
    stationary: ClassVar[bool] = True

    def __post_init__(self) -> None:
        positive(radius=self.radius)

    @property
    def scale(self) -> float:
        return self.radius

    def trajectory(self, p: Array, t: float) -> Array:
        return p

    def closest_point(self, x: Array, t: float) -> Array:
        return self.radius * x / np.linalg.norm(x, axis=-1, keepdims=True)

    def closest_point_derivative(self, x: Array, t: float) -> Array:
        length = np.linalg.norm(x, axis=-1)[..., None, None]
        return self.radius / length * (np.eye(3) - outer(x, x) / length**2)

    def fields(self, y: Array, t: float) -> Fields:
        R = self.radius
        nu = y / R
        zero = np.zeros_like(y[..., 0])
        return Fields(
            nu=nu,
            H=zero + 2.0 / R,
            V=zero,
            z=np.zeros_like(y),
            S=(np.eye(3) - outer(nu, nu)) / R,
            grad_V=np.zeros_like(y),
            grad_z=np.zeros((*y.shape, 3)),
        )

    def energy(self, t: float) -> float:
        return 8.0 * np.pi
