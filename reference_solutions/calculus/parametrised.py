"""Closed surfaces given by a map X of the unit sphere, or of two periodic angles.

Points of the surface are known by their parameters p (c, n), the axis of the points last; Newton's
method moves them by the two local parameters of `local_jets`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from esfem.reference_solutions.calculus import fundamental_forms
from esfem.reference_solutions.calculus.embedded_area import embedded_area
from esfem.reference_solutions.calculus.generated import derivatives
from esfem.reference_solutions.calculus.level_set import PARAMETERS
from esfem.reference_solutions.calculus.local_jets import angle_jet, sphere_frame, sphere_jet
from esfem.reference_solutions.calculus.start_fields import (
    NEWTON_STEPS,
    STEP_LEFT,
    TOO_FAR,
    check_finite,
    check_map,
    lost,
    pointwise,
    spread_parameters,
)
from esfem.reference_solutions.exact import Array, StartFields
from esfem.reference_solutions.profile_curve import Profile

LONGEST_STEP = 0.3  # of Newton's method, in the parameters


@dataclass(frozen=True, eq=False)
class Parametrised:
    """The closed surface X(unit sphere), or X(u, v) with period 2 pi in each.

    Parameters
    ----------
    X : three sympy expressions of sympy.abc. Genus 0: in x, y, z, the point of the unit sphere, and
        smooth about it; outside goes to outside. Genus 1: in u, v; X_u x X_v points outward.
    genus : 0 or 1.
    profile : makes the profile curve of a surface of revolution about the third axis.

    Raises
    ------
    ValueError
        If the genus is neither 0 nor 1, or ``X`` is not three expressions.
    """

    X: tuple[sympy.Expr, sympy.Expr, sympy.Expr]
    genus: int = 0
    profile: Callable[[], Profile] | None = None

    def __post_init__(self) -> None:
        check_map("X", self.X, self.genus)

    def embed(self, p: Array) -> Array:
        """Parameters (..., 3) of unit length, or (..., 2), to points (..., 3) of the surface."""
        return pointwise(lambda p: (self._X(p, 0)[0],), p)[0]

    @cached_property
    def area(self) -> float:
        """The area, by `embedded_area`."""
        return embedded_area(self.embed, self.genus)

    def closest_point(self, x: Array) -> Array:
        """The nearest point of the surface, (..., 3).

        Raises
        ------
        ValueError
            If a point lies so far away that the iteration does not converge, or ends at a point
            that is not even locally the nearest.
        """
        return pointwise(lambda x: (self._X(self._parameters(x), 0)[0],), x)[0]

    def normal_and_shape(self, y: Array) -> tuple[Array, Array]:
        """nu (..., 3) and S (..., 3, 3) at points of the surface."""

        def both(y: Array) -> tuple[Array, ...]:
            return fundamental_forms.normal_and_shape(self.jet(self._parameters(y), 2))

        nu, S = pointwise(both, y)
        return nu, S

    def fields(self, y: Array) -> StartFields:
        """The exact quantities at points y (..., 3) of the surface."""
        return self.fields_at(pointwise(lambda y: (self._parameters(y),), y)[0])

    def fields_at(self, p: Array) -> StartFields:
        """The exact quantities at parameters (..., 3) of unit length, or (..., 2)."""
        return StartFields(*pointwise(lambda p: fundamental_forms.all_fields(self.jet(p, 4)), p))

    def jet(self, p: Array, order: int) -> Array:
        """The jet (order+1, order+1, 3, n) of X about parameters (c, n)."""
        D = self._X(p, order)
        return angle_jet(D, order) if self.genus == 1 else sphere_jet(p, D, order)

    @cached_property
    def _samples(self) -> tuple[Array, cKDTree]:
        """Parameters (N, c) spread over the surface, and a tree of their points."""
        p = spread_parameters(self.genus)
        return p, cKDTree(self.embed(p))

    def _X(self, p: Array, order: int) -> Array:
        """X and its derivatives in the order of `indices`, (indices, 3, n)."""
        return derivatives(self.X, PARAMETERS[self.genus], order)(*p)

    def _moved(self, p: Array, step: Array) -> Array:
        """The parameters p (c, n) moved by local ones, (2, n)."""
        if self.genus == 1:
            return p + step
        e1, e2 = sphere_frame(p)
        moved = p + step[0] * e1 + step[1] * e2
        return moved / np.sqrt((moved * moved).sum(0))

    def _parameters(self, x: Array) -> Array:
        """Parameters (c, n) of the nearest points, by Newton's method from the nearest sample.

        Where |x - X|^2 is not convex, the terms of second derivatives are left out.
        """
        samples, tree = self._samples
        check_finite(x)
        p = samples[tree.query(x.T)[1]].T
        for _ in range(NEWTON_STEPS):
            g, h11, h12, h22, convex = distance_derivatives(x, self.jet(p, 2))
            det = h11 * h22 - h12**2
            step = np.stack([h22 * g[0] - h12 * g[1], h11 * g[1] - h12 * g[0]]) / det
            left = np.sqrt((step * step).sum(0))
            p = self._moved(p, step * np.minimum(1.0, LONGEST_STEP / np.maximum(left, 1e-300)))
            if not np.any(left >= STEP_LEFT):
                break
        nearest = convex & (left < STEP_LEFT)
        if not nearest.all():
            raise lost("x", x, np.where(nearest, 0.0, np.inf), TOO_FAR)
        return p


def distance_derivatives(
    x: Array, X: Array
) -> tuple[Array, Array, Array, Array, NDArray[np.bool_]]:
    """Half |x - X|^2 by the parameters: minus its gradient, its second derivatives, convexity."""
    d = x - X[0, 0]
    X1, X2 = X[1, 0], X[0, 1]
    metric = [(s * t).sum(0) for s, t in ((X1, X1), (X1, X2), (X2, X2))]
    bend = [(d * second).sum(0) for second in (2.0 * X[2, 0], X[1, 1], 2.0 * X[0, 2])]
    h11, h12, h22 = (m - b for m, b in zip(metric, bend, strict=True))
    convex = (h11 > 0) & (h11 * h22 > h12**2)
    h11, h12, h22 = (np.where(convex, h, m) for h, m in zip((h11, h12, h22), metric, strict=True))
    return np.stack([(d * X1).sum(0), (d * X2).sum(0)]), h11, h12, h22, convex
