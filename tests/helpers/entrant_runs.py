"""Runs of the comparison of schemes as if they had been computed."""

from esfem.campaigns.contest.entrant_run import EntrantRun


def made(distance=1e-3, ended="ok", energy=(10.0, 9.0, 8.0), **more):
    """A run as if it had been computed."""
    levels = {"t": [0.0, 0.1, 0.2], "quality": [0.9, 0.8, 0.85]}
    levels |= {"energy": list(energy), "own_energy": list(energy)}
    found = EntrantRun(100, 0.1, levels, seconds=[0.5, 0.5], ended=ended, **more)
    if ended == "ok":
        found.errors = {"start": {"distance": 2e-3}, "end": {"distance": distance}}
    return found
