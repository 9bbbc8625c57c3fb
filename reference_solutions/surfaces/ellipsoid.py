"""The prolate ellipsoid x^2 + y^2 + z^2/4 = 1, 2:1:1, its long axis the third."""

from functools import partial

from sympy.abc import x, y, z

from esfem.reference_solutions.calculus import LevelSet
from esfem.reference_solutions.profile_curve import spheroid_profile

SURFACE = LevelSet(
    phi=x**2 + y**2 + z**2 / 4 - 1,
    start=(x, y, 2 * z),
    profile=partial(spheroid_profile, 1.0, 2.0),
)
