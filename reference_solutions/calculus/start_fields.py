"""What a surface at rest offers to start from, and how its formulas run over many points."""

from collections.abc import Callable, Sequence

import numpy as np

from esfem.reference_solutions.exact import Array

CHUNK = 4096  # points at a time: their derivatives stay in the processor's cache
NEWTON_STEPS = 60
SAMPLES = 20_000  # points from which Newton's method may start
SIDE = 142  # its root
TOO_FAR = "is too far from the surface to be projected"
STEP_LEFT = 1e-9  # of the size: the error after a step of Newton's method is about its square


def pointwise(function: Callable[[Array], tuple[Array, ...]], x: Array) -> tuple[Array, ...]:
    """Apply a function of (c, n) points, the point axis last in all it returns, to points (..., c).

    Divisions by zero are left to the function, which must refuse what is not finite.

    Returns
    -------
    arrays (..., *tensor), of the shape of x without its last axis.
    """
    columns = np.ascontiguousarray(x.reshape(-1, x.shape[-1]).T, dtype=np.float64)
    n = max(columns.shape[1], 1)
    with np.errstate(all="ignore"):
        chunks = [function(columns[:, i : i + CHUNK]) for i in range(0, n, CHUNK)]
    merged = [np.concatenate(part, axis=-1) for part in zip(*chunks, strict=True)]
    return tuple(np.moveaxis(a, -1, 0).reshape(x.shape[:-1] + a.shape[:-1]) for a in merged)


def check_map(name: str, expressions: Sequence[object], genus: int) -> None:
    """Raise ValueError unless the genus is 0 or 1 and there are three expressions."""
    if genus not in (0, 1):
        raise ValueError(f"genus = {genus!r}: must be 0 or 1")
    if len(expressions) != 3:
        raise ValueError(f"{name} = {expressions!r}: must be three expressions")


def lost(name: str, x: Array, left: Array, verdict: str) -> ValueError:
    """The error that the point of x (3, n) with the largest number ``left`` (n,), or nan, is."""
    worst = np.argmax(np.nan_to_num(left, nan=np.inf))
    place = ", ".join(f"{coordinate:.4g}" for coordinate in x[:, worst])
    return ValueError(f"{name} = ({place}): {verdict}")


def check_finite(x: Array) -> None:
    """Raise ValueError unless all points x (3, n) are finite."""
    if not np.isfinite(x).all():
        raise lost("x", x, x.sum(0), "must be finite")


def spread_parameters(genus: int) -> Array:
    """About `SAMPLES` parameters: Fibonacci's sphere (N, 3), or a grid of angles (N, 2)."""
    if genus == 0:
        n = np.arange(SAMPLES) + 0.5
        height, angle = 1.0 - 2.0 * n / SAMPLES, np.pi * (1.0 + np.sqrt(5.0)) * n
        rho = np.sqrt(1.0 - height**2)
        return np.stack([rho * np.cos(angle), rho * np.sin(angle), height], axis=1)
    side = 2.0 * np.pi * np.arange(SIDE) / SIDE
    return np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1).reshape(-1, 2)
