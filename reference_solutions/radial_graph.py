"""Surfaces of revolution |x| = r(u), u = cos(theta), over the unit sphere, r a polynomial.

Letters: theta is the angle from the third axis, s its sine, r' the derivative by u; B = r + u r'
and L = |dy/dtheta|^2 = r^2 + s^2 r'^2. Curvatures are polynomials in u over powers of r and L, so
that neither the poles nor derivatives need care.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import Polynomial

from esfem.reference_solutions.exact import Array, Fields, closest_point_jacobian, outer

NEWTON_STEPS = 60
SQUARED_SINE = Polynomial([1.0, 0.0, -1.0])
U = Polynomial([0.0, 1.0])
E_Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class RadialGraph:
    """The surface |x| = r(x3/|x|).

    Raises
    ------
    ValueError
        If the radius is not positive everywhere.
    """

    r: Polynomial

    def __post_init__(self) -> None:
        least = self.r(np.linspace(-1.0, 1.0, 201)).min()
        if not least > 0:
            raise ValueError(f"r = {self.r}: must be positive, but is {least!r} somewhere")

    def closest_point(self, x: Array) -> Array:
        """Nearest point, (..., 3): Newton's method for the angle, from the angle of x.

        Solves (x - y) . dy/dtheta = 0 in the half-plane of x.

        Raises
        ------
        ValueError
            If a point lies so far from the surface that the iteration does not converge.
        """
        axis_distance = np.hypot(x[..., 0], x[..., 1])
        theta = np.arctan2(axis_distance, x[..., 2])
        for _ in range(NEWTON_STEPS):
            s, u = np.sin(theta), np.cos(theta)
            r, dr = self.r(u), -s * self._dr(u)
            ddr = s * s * self._ddr(u) - u * self._dr(u)
            # Components of x along e_r and e_theta.
            x_r, x_theta = axis_distance * s + x[..., 2] * u, axis_distance * u - x[..., 2] * s
            residual = (x_r - r) * dr + x_theta * r
            slope = (2.0 * x_theta - dr) * dr + (x_r - r) * ddr - x_r * r
            step = residual / slope
            theta = theta - step
            if np.max(np.abs(step), initial=0.0) < 1e-9:
                return self._point(theta, _e_rho(x))
        raise ValueError("x: a point is too far from the surface to be projected")

    def closest_point_derivative(self, x: Array) -> Array:
        """D closest_point, (..., 3, 3)."""
        y = self.closest_point(x)
        u, _, nu, t, e_phi = self._frame(y)
        d = np.einsum("...a,...a", x - y, nu)
        along, across = self._curvatures(u)
        return closest_point_jacobian(d, [(along, t), (across, e_phi)])

    def fields(self, y: Array, r_t: Polynomial) -> Fields:
        """Exact quantities at points y; V is the normal velocity when r changes at the rate r_t."""
        u, s, nu, t, e_phi = self._frame(y)
        along, across = self._curvatures(u)
        H, dH, ddH, V, dV = (F(u) for F in self._scalars(r_t))
        r, dr, L, dL = self.r(u), self._dr(u), self._L(u), self._L.deriv()(u)
        dz_along = (s**2 * ddH - u * dH - 0.5 * s**2 * dH * dL / L) / L
        dz_across = (s**2 * dr / r - u) * dH / L
        z, grad_V = ((-s * F / np.sqrt(L))[..., None] * t for F in (dH, dV))
        tt, pp = outer(t, t), outer(e_phi, e_phi)
        return Fields(
            nu=nu,
            H=H,
            V=V,
            z=z,
            S=along[..., None, None] * tt + across[..., None, None] * pp,
            grad_V=grad_V,
            grad_z=dz_along[..., None, None] * tt
            + dz_across[..., None, None] * pp
            - outer(along[..., None] * z, nu),
            laplace_H=dz_along + dz_across,
        )

    def willmore(self, points: int = 100) -> float:
        """W = pi int H^2 r L^{1/2} du by Gauss quadrature."""
        u, weight = np.polynomial.legendre.leggauss(points)
        H = sum(self._curvatures(u))
        return float(np.pi * np.sum(weight * H**2 * self.r(u) * np.sqrt(self._L(u))))

    def area(self, points: int = 100) -> float:
        """2 pi int r L^{1/2} du by Gauss quadrature."""
        u, weight = np.polynomial.legendre.leggauss(points)
        return float(2.0 * np.pi * np.sum(weight * self.r(u) * np.sqrt(self._L(u))))

    @cached_property
    def _dr(self) -> Polynomial:
        return self.r.deriv()

    @cached_property
    def _ddr(self) -> Polynomial:
        return self.r.deriv(2)

    @cached_property
    def _L(self) -> Polynomial:
        return self.r**2 + SQUARED_SINE * self._dr**2

    @cached_property
    def _B(self) -> Polynomial:
        return self.r + U * self._dr

    @cached_property
    def _N(self) -> Polynomial:
        """L^{3/2} times the curvature of the meridian."""
        r, dr, ddr = self.r, self._dr, self._ddr
        return r**2 + 2 * SQUARED_SINE * dr**2 - r * (SQUARED_SINE * ddr - U * dr)

    def _curvatures(self, u: Array) -> tuple[Array, Array]:
        """Along the meridian N / L^{3/2} and about the axis B / (r L^{1/2})."""
        L = self._L(u)
        return self._N(u) / L**1.5, self._B(u) / (self.r(u) * np.sqrt(L))

    def _scalars(self, r_t: Polynomial) -> list[Callable[[Array], Array]]:
        """H, H', H'', V, V' as functions of u; the dashes are derivatives by u."""
        r, L = self.r, self._L
        H = Quotient(self._N * r + self._B * L, 1, 3, r, L)
        V = Quotient(r * r_t, 0, 1, r, L)
        return [H, H.derivative(), H.derivative().derivative(), V, V.derivative()]

    def _frame(self, y: Array) -> tuple[Array, ...]:
        """u, s (...), nu, t, e_phi (..., 3); at a pole e_phi is any, and so serves its purpose."""
        length = np.linalg.norm(y, axis=-1)
        u, s = y[..., 2] / length, np.hypot(y[..., 0], y[..., 1]) / length
        e_rho = _e_rho(y)
        e_phi = np.stack([-e_rho[..., 1], e_rho[..., 0], e_rho[..., 2]], -1)
        nu = self._B(u)[..., None] * y / length[..., None] - self._dr(u)[..., None] * E_Z
        nu /= np.sqrt(self._L(u))[..., None]
        return u, s, nu, np.cross(e_phi, nu), e_phi

    def _point(self, theta: Array, e_rho: Array) -> Array:
        s, u = np.sin(theta), np.cos(theta)
        return self.r(u)[..., None] * (s[..., None] * e_rho + u[..., None] * E_Z)


def _e_rho(x: Array) -> Array:
    """Unit vector away from the third axis, (..., 3); on the axis, the first one."""
    axis_distance = np.hypot(x[..., 0], x[..., 1])
    on_axis = axis_distance == 0
    safe = np.where(on_axis, 1.0, axis_distance)
    first = np.where(on_axis, 1.0, x[..., 0] / safe)
    return np.stack([first, x[..., 1] / safe, 0.0 * axis_distance], -1)


@dataclass(frozen=True)
class Quotient:
    """The function E / (r^m L^{n/2}) of u, with polynomials E, r, L."""

    E: Polynomial
    m: int
    n: int
    r: Polynomial
    L: Polynomial

    def __call__(self, u: Array) -> Array:
        return self.E(u) / (self.r(u) ** self.m * self.L(u) ** (self.n / 2))

    def derivative(self) -> "Quotient":
        """(E' r L - m E r' L - n/2 E r L') / (r^{m+1} L^{n/2+1})."""
        E, r, L = self.E, self.r, self.L
        numerator = E.deriv() * r * L - self.m * E * r.deriv() * L - self.n / 2 * E * r * L.deriv()
        return Quotient(numerator, self.m + 1, self.n + 2, r, L)
