"""The torus of radii 1 and 0.65 whose core goes up and down five times: z + 0.3 sin 5u."""

from sympy import Rational, cos, sin
from sympy.abc import u, v

from esfem.reference_solutions.calculus import Parametrised

r = Rational(65, 100)
rho = 1 + r * cos(v)
SURFACE = Parametrised(
    X=(rho * cos(u), rho * sin(u), r * sin(v) + Rational(3, 10) * sin(5 * u)),
    genus=1,
)
