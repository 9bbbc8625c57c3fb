"""The prolate spheroid of half-axes 1, 1 and 3/2, the third."""

from functools import partial

from sympy.abc import x, y, z

from esfem.reference_solutions.calculus import Parametrised
from esfem.reference_solutions.profile_curve import spheroid_profile

SURFACE = Parametrised(X=(x, y, 3 * z / 2), profile=partial(spheroid_profile, 1.0, 1.5))
