"""The torus of radii 2.5 and 1.75 with four ripples: core z = 0.25 cos 4u, tube + 0.1 sin 4u.

Its Willmore flow stays smooth and ends at a Clifford torus. It is as large as this because the
errors of the discrete nu and H grow like exp(13 t/R^4) on a Clifford torus.
"""

from sympy import Rational, cos, sin
from sympy.abc import u, v

from reference_solutions.calculus import Parametrised

r = Rational(7, 4) + sin(4 * u) / 10
rho = Rational(5, 2) + r * cos(v)
SURFACE = Parametrised(
    X=(rho * cos(u), rho * sin(u), r * sin(v) + cos(4 * u) / 4),
    genus=1,
)
