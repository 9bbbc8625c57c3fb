"""The perturbed sphere |x| = 1 + 0.2 P2(z/|x|), with P2(t) = (3 t^2 - 1)/2."""

from functools import partial

from sympy import sqrt
from sympy.abc import x, y, z

from esfem.reference_solutions.calculus import LevelSet
from esfem.reference_solutions.profile_curve import perturbed_sphere_profile

r = sqrt(x**2 + y**2 + z**2)
radius = 1 + (3 * z**2 / r**2 - 1) / 10
SURFACE = LevelSet(
    phi=r - radius,
    start=(radius * x, radius * y, radius * z),
    profile=partial(perturbed_sphere_profile, 0.2, 2),
)
