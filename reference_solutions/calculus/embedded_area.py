"""The area of a closed surface from its embedding alone, by spectral quadrature.

The embedding is sampled on a grid of two periodic angles; of the unit sphere these are theta, which
runs once around through both poles, and phi, so that each point is met twice. Derivatives are those
of the interpolating trigonometric polynomial: both they and the quadrature converge exponentially
for analytic surfaces.
"""

from collections.abc import Callable

import numpy as np

from esfem.reference_solutions.exact import Array

GRIDS = (64, 128, 256, 512)  # points around, in each angle
AGREEMENT = 1e-11  # of two grids, relative: the error of the finer one is far below it


def embedded_area(embed: Callable[[Array], Array], genus: int) -> float:
    """The area of the image of the unit sphere (genus 0), or of two angles of period 2 pi (1).

    Parameters
    ----------
    embed : parameters (N, 3) of unit length, or (N, 2), to points (N, 3) of the surface.

    Raises
    ------
    ValueError
        If the finest two `GRIDS` do not agree: the surface is not resolved.
    """
    before = np.inf
    for n in GRIDS:
        found = _area(embed, genus, n)
        if abs(found - before) <= AGREEMENT * found:
            return found
        before = found
    raise ValueError(f"embed: {GRIDS[-1]} points around do not resolve the surface")


def _area(embed: Callable[[Array], Array], genus: int, n: int) -> float:
    """The quadrature with n midpoints in the first angle and n in the second."""
    first = 2.0 * np.pi * (np.arange(n) + 0.5) / n
    u, v = np.meshgrid(first, 2.0 * np.pi * np.arange(n) / n, indexing="ij")
    if genus == 0:
        p = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1)
        sine, weights = np.abs(np.sin(first)), 0.5 * _sine_weights(n)
    else:
        p, sine, weights = np.stack([u, v], axis=-1), np.ones(n), np.full(n, 2.0 * np.pi / n)
    y = embed(p.reshape(-1, p.shape[-1])).reshape(n, n, 3)
    element = np.linalg.norm(np.cross(_derivative(y, 0), _derivative(y, 1)), axis=-1)
    return float(weights @ (element.sum(axis=1) / sine) * 2.0 * np.pi / n)


def _derivative(y: Array, axis: int) -> Array:
    """By one angle, of values on equidistant points around."""
    n = y.shape[axis]
    k = np.fft.rfftfreq(n, 1.0 / n)
    k[-1] = 0.0  # the sawtooth has no derivative
    shape = [1] * y.ndim
    shape[axis] = -1
    return np.fft.irfft(1j * k.reshape(shape) * np.fft.rfft(y, axis=axis), n, axis=axis)


def _sine_weights(n: int) -> Array:
    """Weights (n,) of f at the midpoints for the integral of |sin u| f(u) over the circle.

    Exact for trigonometric polynomials f: the integral of |sin u| cos(k u) is 4 / (1 - k^2) for
    even k, else 0.
    """
    u, k = 2.0 * np.pi * (np.arange(n) + 0.5) / n, np.arange(0, n // 2, 2)
    moments = np.where(k == 0, 1.0, 2.0) * 4.0 / (1.0 - k**2)
    return np.cos(np.multiply.outer(u, k)) @ moments / n
