"""Distances between points on a computed surface and an exact surface of revolution, both ways.

By symmetry, the distance of a point to a surface of revolution is that of its (rho, z) to the
profile curve. The other way there is no symmetry to use: the exact surface is sampled in space.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from esfem.reference_solutions.exact import Array
from esfem.reference_solutions.profile_curve import Profile, nodes


@dataclass(frozen=True)
class ProfileDistance:
    """Largest and mean distance from points to a profile's surface, and from that surface."""

    maximum_to_profile: float
    mean_to_profile: float
    maximum_from_profile: float
    mean_from_profile: float


def profile_distance(
    x: Array,
    profile: Profile,
    axis: int = 2,
    surface: Callable[[Array], Array] | None = None,
    weights: Array | None = None,
    samples: int = 20000,
) -> ProfileDistance:
    """Distances between points x and the surface of revolution of ``profile``.

    *To* the profile is exact to round-off. *From* the profile is the distance of ``samples`` points
    spread evenly over the exact surface to the nearest of the points: about half their spacing at
    least, so it finds missing parts and no small errors. With ``surface`` it is the distance to
    that.

    Parameters
    ----------
    x : (N, 3) points.
    axis : index of the coordinate along the axis of revolution.
    surface : takes points (n, 3) to their distances (n,) from the surface that x lie on.
    weights : (N,) the points' weights in ``mean_to_profile``, say areas; equal without them.

    Raises
    ------
    ValueError
        If an argument has the wrong shape or is out of its bounds.
    """
    x = np.asarray(x, float)
    if x.ndim != 2 or x.shape[1] != 3 or len(x) == 0 or not np.all(np.isfinite(x)):
        raise ValueError(f"x = array of shape {x.shape}: must be finite points (N, 3)")
    if axis not in (0, 1, 2):
        raise ValueError(f"axis = {axis!r}: must be 0, 1 or 2")
    if weights is not None and (np.shape(weights) != (len(x),) or np.min(weights) < 0.0):
        raise ValueError(f"weights = shape {np.shape(weights)}: must be {len(x)} numbers >= 0")
    x = np.roll(x, 2 - axis, axis=1)
    to = distance_to_curve(np.hypot(x[:, 0], x[:, 1]), x[:, 2], profile)
    y = surface_samples(profile, samples)
    if surface is None:
        back = np.asarray(cKDTree(x).query(y)[0])
    else:
        back = surface(np.roll(y, axis - 2, axis=1))
    return ProfileDistance(
        float(to.max()),
        float(np.average(to, weights=weights)),
        float(back.max()),
        float(back.mean()),
    )


def distance_to_curve(rho: Array, z: Array, profile: Profile) -> Array:
    """Distance of points (rho, z), each (N,), to the curve: dense samples, then Newton's method.

    Where the distance is no minimum in s at a sample (beyond a centre of curvature), its second
    derivative, g^2 + d . c_ss, is replaced by g^2; the better of sample and iterate counts. For
    points about as near to two branches the samples may choose the wrong one, an error of the order
    of their spacing squared, and none near the curve.
    """
    dense = nodes(profile.genus, max(1024, 16 * profile.K))
    sampled, nearest = cKDTree(np.stack(profile(dense), -1)).query(np.stack([rho, z], -1))
    s = dense[np.asarray(nearest)]
    for _ in range(4):
        d = np.stack(profile(s)) - np.stack([rho, z])
        c_s, c_ss = np.stack(profile(s, 1)), np.stack(profile(s, 2))
        g2 = np.sum(c_s**2, 0)
        second = g2 + np.sum(d * c_ss, 0)
        s = s - np.sum(d * c_s, 0) / np.where(second > 0.1 * g2, second, g2)
    return np.minimum(sampled, np.hypot(*(np.stack(profile(s)) - np.stack([rho, z]))))


def surface_samples(profile: Profile, n: int) -> Array:
    """n points (n, 3) of equal shares of area about the third axis, on a golden-angle spiral."""
    s = nodes(profile.genus, max(4096, 16 * profile.K))
    area = np.cumsum(profile(s)[0] * np.hypot(*profile(s, 1)))
    s = np.interp((np.arange(n) + 0.5) / n, area / area[-1], s + 0.5 * (s[1] - s[0]))
    angle = np.arange(n) * np.pi * (3.0 - np.sqrt(5.0))
    rho, z = profile(s)
    return np.stack([rho * np.cos(angle), rho * np.sin(angle), z], -1)
