"""2.3 times the torus of radii 1, 1/2 with ripples: core z = 0.1 cos 4u, tube + 0.05 sin 4u.

Its Willmore flow stays smooth and ends at a Clifford torus. It is as large as this because there
the errors of the discrete nu and H grow like exp(13 t/R^4).
"""

from sympy import Rational, cos, sin
from sympy.abc import u, v

from esfem.reference_solutions.calculus import Parametrised

scale = Rational(23, 10)
r = Rational(1, 2) + sin(4 * u) / 20
rho = 1 + r * cos(v)
SURFACE = Parametrised(
    X=(
        scale * rho * cos(u),
        scale * rho * sin(u),
        scale * (r * sin(v) + cos(4 * u) / 10),
    ),
    genus=1,
)
