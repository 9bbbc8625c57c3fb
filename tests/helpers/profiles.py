"""Surfaces of revolution for tests: profile curves, and the Laplacian of V on a torus."""

import numpy as np

from esfem.reference_solutions.exact import positive
from esfem.reference_solutions.profile_curve import (
    Profile,
    fit_profile,
    perturbed_sphere_profile,
    spheroid_profile,
)
from esfem.reference_solutions.torus import Torus


def torus_profile(R: float, r: float, amplitude: float = 0.0, mode: int = 0) -> Profile:
    """Ring with core radius R and tube radius r + amplitude cos(mode s)."""
    positive(R=R, r=r)

    def curve(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        tube = r + amplitude * np.cos(mode * s)
        return R + tube * np.cos(s), tube * np.sin(s)

    return fit_profile(1, curve, mode + 2)


SHAPES = {
    "perturbed_sphere": perturbed_sphere_profile(0.2, 2),
    "pear": perturbed_sphere_profile(0.2, 3),
    "spheroid": spheroid_profile(1.0, 1.5),
    "torus": torus_profile(1.0, 0.6),
    "perturbed_torus": torus_profile(1.0, 0.5, 0.05, 3),
}


def laplace_V(torus: Torus, y: np.ndarray) -> np.ndarray:
    """Lap_Gamma V for the Willmore velocity V = C / rho^3, shape (...)."""
    R, r = torus.R, torus.r
    c, s, *_ = torus.frame(y)
    rho = R + r * c
    C = R * (R**2 - 2.0 * r**2) / (2.0 * r**3)
    return 3.0 * C / (r * rho) * (c / rho**3 + 3.0 * r * s**2 / rho**4)
