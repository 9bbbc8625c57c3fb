"""Regression: stored results against a committed baseline, by order, constant and verdict."""

from esfem.campaigns.baseline.change import Change, Stored
from esfem.campaigns.baseline.compare import compare

__all__ = ["Change", "Stored", "compare"]
