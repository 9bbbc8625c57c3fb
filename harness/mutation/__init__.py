"""Seeded bugs: is a wrong program seen to be wrong by the verdicts, and by which study?"""

from harness.mutation.patching import Edit, Mutant, applied
from harness.mutation.registry import MUTANTS

__all__ = ["MUTANTS", "Edit", "Mutant", "applied"]
