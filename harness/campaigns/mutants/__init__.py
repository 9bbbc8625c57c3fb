"""Seeded bugs: is a wrong program seen to be wrong by the verdicts, and by which study?"""

from esfem.campaigns.mutants.patching import Edit, Mutant, applied
from esfem.campaigns.mutants.registry import MUTANTS

__all__ = ["MUTANTS", "Edit", "Mutant", "applied"]
