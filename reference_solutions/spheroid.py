"""The spheroid x1^2/a^2 + x2^2 + x3^2 = 1 about the first axis, as a surface.

Letters: D = diag(c, 1, 1) with c = 1/a^2, g = |D x| = |grad phi| / 2 for the level-set function phi
= x.Dx - 1, and tau = grad_Gamma x1 = e1 - nu1 nu. All scalars depend on x1 alone, and tau vanishes
at the poles (+-a, 0, 0) where the direction of the meridian is lost: the formulas need no frame.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from esfem.reference_solutions import laws
from esfem.reference_solutions.exact import Array, Fields, outer, positive

NEWTON_STEPS = 60


@dataclass(frozen=True)
class Spheroid:
    """The surface x1^2/a^2 + x2^2 + x3^2 = 1, with principal curvatures c/g^3 and 1/g.

    The first is that of the meridian, the second that about the axis.

    Raises
    ------
    ValueError
        If ``a`` is not a positive finite number.
    """

    a: float = 1.0

    def __post_init__(self) -> None:
        positive(a=self.a)

    @property
    def c(self) -> float:
        """1/a^2."""
        return self.a**-2

    @property
    def D(self) -> Array:
        """The diagonal of the quadratic form."""
        return np.array([self.c, 1.0, 1.0])

    def closest_point(self, x: Array) -> Array:
        """y = (1 + s D)^-1 x with s = d/g, where y.Dy = 1; (..., 3).

        y.Dy - 1 is convex and decreasing in s, and not negative where one of its two terms alone
        makes up 1: Newton's method from there rises monotonically to the root.

        Raises
        ------
        ValueError
            If a point lies so far inside that the iteration does not converge.
        """
        c, X = self.c, c_order(x)
        u, w = c * X[0] ** 2, X[1] ** 2 + X[2] ** 2
        s = np.maximum((np.sqrt(u) - 1.0) / c, np.sqrt(w) - 1.0)
        for _ in range(NEWTON_STEPS):
            m, n = 1.0 / (1.0 + s * c), 1.0 / (1.0 + s)
            U, W = u * m**2, w * n**2
            step = (U + W - 1.0) / (2.0 * (U * m * c + W * n))
            s = s + step
            # Quadratic convergence: the error left is about the square of the step.
            if np.max(np.abs(step), initial=0.0) < 1e-9:
                return x / (1.0 + s[..., None] * self.D)
        raise ValueError(f"x: a point is too far from the spheroid a = {self.a!r} to be projected")

    def closest_point_derivative(self, x: Array) -> Array:
        """D closest_point = (I - nu nu^T) / (1 + d/g) + beta tau tau^T, (..., 3, 3).

        This is sum_i t_i t_i^T / (1 + d kappa_i), for |tau|^2 = (x2^2 + x3^2) / g^2 divides the
        difference 1/g - c/g^3 of the curvatures: beta = d (1-c) / (g (1 + d/g)(1 + d c/g^3)).
        """
        y = self.closest_point(x)
        g, nu, tau = self._normal(y)
        d = np.einsum("...a,...a", x - y, nu)
        across, along = 1.0 + d / g, 1.0 + d * self.c / g**3
        beta = d * (1.0 - self.c) / (g * across * along)
        tangential = np.eye(3) - outer(nu, nu)
        return tangential / across[..., None, None] + outer(beta[..., None] * tau, tau)

    def fields(self, y: Array, rate: float = 0.0) -> Fields:
        """Exact quantities at points y; V is the normal velocity when a changes at that rate."""
        c, (g, nu, tau) = self.c, self._normal(y)
        H, dH, ddH, laplace_H = self._curvature(y[..., 0], g)
        V, dV = self._velocity(y[..., 0], g, rate)
        # D = I + (c - 1) e1 e1^T seen by the tangent plane; exactly symmetric as it stands.
        S = np.eye(3) - outer(nu, nu) + (c - 1.0) * outer(tau, tau)
        S /= g[..., None, None]
        # z = dH tau, and d_a tau_b = -(S e1)_a nu_b - nu1 S_ab.
        grad_z = (ddH[..., None] * tau)[..., :, None] * tau[..., None, :]
        grad_z -= outer(dH[..., None] * S[..., 0], nu)
        grad_z -= (dH * nu[..., 0])[..., None, None] * S
        return Fields(
            nu=nu,
            H=H,
            V=V,
            z=dH[..., None] * tau,
            S=S,
            grad_V=dV[..., None] * tau,
            grad_z=grad_z,
            laplace_H=laplace_H,
        )

    def forcing(
        self,
        law: str,
        parameters: Mapping[str, float],
        x: Array,
        rate: float = 0.0,
        scale: float = 1.0,
    ) -> Array:
        """f = V - Lap H - Q with the formulas of `fields`, taken as they are off the surface.

        It is that of the surface enlarged by ``scale``, at the points scale x.
        """
        X = c_order(x)
        g = np.sqrt((self.c * X[0]) ** 2 + X[1] ** 2 + X[2] ** 2)
        H, _, _, laplace_H = self._curvature(X[0], g)
        S2 = g**-2 + self.c**2 * g**-6
        V = scale * self._velocity(X[0], g, rate)[0]
        Q = laws.Q(law, parameters, H / scale, S2 / scale**2)
        return V - laplace_H / scale**3 - Q

    def willmore(self) -> float:
        """W = pi (2 a F + 14/3 + 4c/3), where F = asinh(k)/k, k^2 = c - 1 (asin if negative).

        The integral of pi H^2 g over -a < x1 < a, for 2 pi g dx1 is the area of a band.
        """
        k = np.sqrt(abs(self.c - 1.0))
        F = 1.0 if k == 0 else (np.arcsinh(k) if self.c > 1 else np.arcsin(k)) / k
        return np.pi * (2.0 * self.a * F + (14.0 + 4.0 * self.c) / 3.0)

    def _normal(self, y: Array) -> tuple[Array, Array, Array]:
        """g (...), nu and tau (..., 3)."""
        Dy = y * self.D
        g = np.sqrt(np.einsum("...a,...a", Dy, Dy))
        nu = Dy / g[..., None]
        tau = -nu[..., :1] * nu
        # 1 - nu1^2 without cancellation near the poles.
        tau[..., 0] = nu[..., 1] ** 2 + nu[..., 2] ** 2
        return g, nu, tau

    def _curvature(self, x1: Array, g: Array) -> tuple[Array, Array, Array, Array]:
        """H, its first and second derivative by x1, and Lap_Gamma H; all (...).

        H = q^{-1/2} + c q^{-3/2} with q = g^2 = 1 + e x1^2, e = c^2 - c; and for functions F(x1)
        Lap F = F'' |tau|^2 - F' H nu1, where |tau|^2 = 1 - nu1^2 and nu1 = c x1 / g.
        """
        c = self.c
        e, i = c * c - c, 1.0 / g
        j = i * i
        H = i * (1.0 + c * j)
        H_q = -0.5 * i * j * (1.0 + 3.0 * c * j)
        H_qq = 0.75 * i * j * j * (1.0 + 5.0 * c * j)
        dH = 2.0 * e * x1 * H_q
        ddH = 2.0 * e * (H_q + 2.0 * e * x1**2 * H_qq)
        nu1 = c * x1 * i
        return H, dH, ddH, ddH * (1.0 - nu1**2) - dH * H * nu1

    def _velocity(self, x1: Array, g: Array, rate: float) -> tuple[Array, Array]:
        """V = a' x1^2 / (a^3 g) = -phi_t / |grad phi| and its derivative by x1; both (...)."""
        c = self.c
        factor = rate * self.a**-3
        return factor * x1**2 / g, factor * x1 * (2.0 - (c * c - c) * x1**2 / g**2) / g


def c_order(x: Array) -> Array:
    """The components as three contiguous arrays: (..., 3) -> (3, ...)."""
    return np.ascontiguousarray(np.moveaxis(x, -1, 0))
