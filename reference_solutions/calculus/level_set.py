"""Closed surfaces phi = 0: closest points and exact fields.

Letters: p and pp are the first and second derivatives of phi, the axis of the points, n, last.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from sympy import abc

from esfem.reference_solutions.calculus import curvature
from esfem.reference_solutions.calculus.embedded_area import embedded_area
from esfem.reference_solutions.calculus.generated import derivatives, indices
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

SPACE = (abc.x, abc.y, abc.z)
PARAMETERS = (SPACE, (abc.u, abc.v))  # of genus 0, of genus 1
PULL_STEPS = 3
NO_SURFACE = "no surface phi = 0 is found from there, or the gradient of phi vanishes"
NEARBY, LEAST_GRADIENT = 1e-3, 1e-3


def tensor_positions(order: int) -> NDArray[np.int64]:
    """Where the partial derivatives of an order stand in `indices`: integers (3, ..., 3)."""
    position = {index: m for m, index in enumerate(indices(3, order))}
    where = np.zeros((3,) * order, dtype=np.int64)
    for index in np.ndindex(where.shape):
        where[index] = position[tuple(sorted(index))]
    return where


TENSORS = [tensor_positions(order) for order in range(5)]


@dataclass(frozen=True, eq=False)
class LevelSet:
    """The closed surface phi(x, y, z) = 0 around phi < 0.

    Parameters
    ----------
    phi : sympy expression in x, y, z of sympy.abc, negative inside; its gradient does not vanish on
        the surface. It may be undefined far away.
    start : three sympy expressions of a map to the surface, or near it. Genus 0: in x, y, z, from
        the unit sphere, outside to outside. Genus 1: in u, v, of period 2 pi in each, and d_u x d_v
        points outward.
    genus : 0 or 1.
    profile : makes the profile curve of a surface of revolution about the third axis.

    Raises
    ------
    ValueError
        If the genus is neither 0 nor 1, or ``start`` is not three expressions.
    """

    phi: sympy.Expr
    start: tuple[sympy.Expr, sympy.Expr, sympy.Expr]
    genus: int = 0
    profile: Callable[[], Profile] | None = None

    def __post_init__(self) -> None:
        check_map("start", self.start, self.genus)

    def embed(self, p: Array) -> Array:
        """Parameters (..., 3) of unit length, or (..., 2), to points (..., 3) of the surface.

        Raises
        ------
        ValueError
            If Newton's method along the gradient does not take ``start`` onto the surface, or the
            gradient vanishes there.
        """
        start = derivatives(self.start, PARAMETERS[self.genus], 0)

        def pulled(p: Array) -> tuple[Array]:
            x = start(*p)[0]
            y, left = self._pull(x, NEWTON_STEPS)
            if not np.all(left < STEP_LEFT):
                raise lost("start", x, left, NO_SURFACE)
            self._check_gradient(y)
            return (y,)

        return pointwise(pulled, p)[0]

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
        return pointwise(lambda x: (self._closest(x),), x)[0]

    def normal_and_shape(self, y: Array) -> tuple[Array, Array]:
        """nu (..., 3) and S (..., 3, 3) at points of the surface."""
        nu, S = pointwise(lambda y: curvature.normal_and_shape(*self._phi(y, 2)[1:]), y)
        return nu, S

    def fields(self, y: Array) -> StartFields:
        """The exact quantities at points y (..., 3) of the surface."""
        return StartFields(*pointwise(lambda y: curvature.all_fields(*self._phi(y, 4)[1:]), y))

    def _phi(self, x: Array, order: int) -> list[Array]:
        """phi (n,) and its derivatives (3, n), (3, 3, n), ... up to an order."""
        rows = derivatives((self.phi,), SPACE, order)(*x)[:, 0]
        return [rows[where] for where in TENSORS[: order + 1]]

    def _pull(self, x: Array, steps: int) -> tuple[Array, Array]:
        """x (3, n) moved along p towards the surface, and the lengths of the last moves."""
        for _ in range(steps):
            phi, p = self._phi(x, 1)
            move = -phi / (p * p).sum(0) * p
            left = np.sqrt((move * move).sum(0))
            x = x + move
            if not np.any(left >= STEP_LEFT):
                break
        return x, left

    def _check_gradient(self, y: Array) -> None:
        """Raise ValueError where |p| is nearly 0, beside its size a little further out."""
        _, p = self._phi(y, 1)
        length = np.sqrt((p * p).sum(0))
        out = y + NEARBY * np.sqrt((y * y).sum(0).max()) * p / length
        ratio = length / np.sqrt((self._phi(out, 1)[1] ** 2).sum(0))
        if not np.all(ratio > LEAST_GRADIENT):
            raise lost("phi", y, -ratio, "its gradient vanishes on the surface")

    @cached_property
    def _samples(self) -> cKDTree:
        """Points spread over the surface."""
        return cKDTree(self.embed(spread_parameters(self.genus)))

    def _closest(self, x: Array) -> Array:
        """Newton's method from along the gradient, and where it fails, from the nearest sample."""
        y, nearest = self._newton(x, self._pull(x, PULL_STEPS)[0])
        if not nearest.all():
            far = np.flatnonzero(~nearest)
            check_finite(x)
            start = self._samples.data[self._samples.query(x[:, far].T)[1]].T
            y[:, far], nearest[far] = self._newton(x[:, far], start)
        if not nearest.all():
            raise lost("x", x, np.where(nearest, 0.0, np.inf), TOO_FAR)
        return y

    def _newton(self, x: Array, y: Array) -> tuple[Array, NDArray[np.bool_]]:
        """y with x - y = s p and phi = 0, and where it is found and locally the nearest."""
        _, p = self._phi(y, 1)
        s = ((x - y) * p).sum(0) / (p * p).sum(0)
        for _ in range(NEWTON_STEPS):
            move, ds, convex = newton_step(x - y, s, *self._phi(y, 2))
            y, s = y + move, s + ds
            left = np.sqrt((move * move).sum(0))
            if not np.any(left >= STEP_LEFT):
                break
        return y, convex & (left < STEP_LEFT)


def newton_step(
    r: Array, s: Array, phi: Array, p: Array, pp: Array
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Steps dy (3, n), ds (n,) of Newton's method for r = x - y = s p, phi = 0.

        M dy + p ds = r - s p,  p.dy = -phi,  M = I + s pp.

    On tangents M is I + d S: the third value tells where it is positive, as it is at the nearest
    point. A multiple of the second equation makes it 1 along p, for there M may be singular.
    """
    q = (p * p).sum(0)
    M = np.eye(3)[:, :, None] + s * pp
    c = (1.0 - (p * curvature.matvec(M, p)).sum(0) / q) / q
    M = M + c * curvature.outer(p, p)
    adj, det = curvature.adjugate(M)
    a = curvature.matvec(adj, r - (s + c * phi) * p)
    b = curvature.matvec(adj, p)
    p_b = (p * b).sum(0)
    ds = (det * phi + (p * a).sum(0)) / p_b
    return (a - b * ds) / det, ds, (p_b > 0) & (np.einsum("aan->n", M) > 1.0)
