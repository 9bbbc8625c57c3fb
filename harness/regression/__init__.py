"""Regression: stored results against a committed baseline, by order, constant and verdict."""

from harness.regression.change import Change, Stored
from harness.regression.compare import compare

__all__ = ["Change", "Stored", "compare"]
