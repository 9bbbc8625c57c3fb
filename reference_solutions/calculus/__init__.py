"""Exact start data of smooth closed surfaces, differentiated by sympy: level sets and maps."""

from esfem.reference_solutions.calculus.level_set import LevelSet
from esfem.reference_solutions.calculus.parametrised import Parametrised
from esfem.reference_solutions.exact import StartFields

Surface = LevelSet | Parametrised

__all__ = ["LevelSet", "Parametrised", "StartFields", "Surface"]
