"""The torus with core radius 1 and six beads: its tube has the radius 0.4 + 0.1 sin 6u."""

from sympy import cos, sin
from sympy.abc import u, v

from esfem.reference_solutions.calculus import Parametrised

r = (4 + sin(6 * u)) / 10
rho = 1 + r * cos(v)
SURFACE = Parametrised(X=(rho * cos(u), rho * sin(u), r * sin(v)), genus=1)
