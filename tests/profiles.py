"""Profile curves of surfaces of revolution, for tests."""

from reference_solutions.profile_curve import (
    perturbed_sphere_profile,
    spheroid_profile,
    torus_profile,
)

SHAPES = {
    "perturbed_sphere": perturbed_sphere_profile(0.2, 2),
    "pear": perturbed_sphere_profile(0.2, 3),
    "spheroid": spheroid_profile(1.0, 1.5),
    "torus": torus_profile(1.0, 0.6),
    "perturbed_torus": torus_profile(1.0, 0.5, 0.05, 3),
}
