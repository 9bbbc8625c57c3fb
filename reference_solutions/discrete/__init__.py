"""What the scheme itself does where space is no matter: recursions for a few numbers."""

from esfem.reference_solutions.discrete.radial import RadialRun

__all__ = ["RadialRun"]
