"""Seeded bugs: is a wrong program seen to be wrong by the verdicts, and by which study?"""

from harness.mutation.registry import MUTANTS
from harness.mutation.patching import Edit, Mutant, applied

__all__ = ["MUTANTS", "Edit", "Mutant", "applied"]
