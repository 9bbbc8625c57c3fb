"""The red blood cell z^2 = w (1 - 0.7 w^2)^2 with w = 1 - (x^2 + y^2)/4."""

from sympy import Rational
from sympy.abc import x, y, z

from esfem.reference_solutions.calculus import LevelSet
from esfem.reference_solutions.profile_curve import red_blood_cell_profile

w = 1 - (x**2 + y**2) / 4
SURFACE = LevelSet(
    phi=z**2 - w * (1 - Rational(7, 10) * w**2) ** 2,
    start=(2 * x, 2 * y, z * (1 - Rational(7, 10) * (x**2 + y**2 - 1) ** 2)),
    profile=red_blood_cell_profile,
)
