"""Exact start data of smooth closed surfaces, differentiated by sympy: level sets and maps."""

from reference_solutions.calculus.level_set import LevelSet
from reference_solutions.calculus.parametrised import Parametrised
from reference_solutions.exact import StartFields

Surface = LevelSet | Parametrised

__all__ = ["LevelSet", "Parametrised", "StartFields", "Surface"]
