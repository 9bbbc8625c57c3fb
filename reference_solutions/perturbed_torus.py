"""The Clifford torus, perturbed along an eigenmode of the linearised Willmore flow."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from esfem.reference_solutions import jets
from esfem.reference_solutions.clifford_modes import decaying_modes
from esfem.reference_solutions.exact import Array, Fields, length_of, outer, positive
from esfem.reference_solutions.laws import check_unforced
from esfem.reference_solutions.torus import Torus

NEWTON_STEPS = 60
POINTS = 96  # around, of quadratures


@dataclass(frozen=True)
class PerturbedCliffordTorus:
    """X + eps(t) psi(theta) cos(m phi) nu over the Clifford torus X, eps = amplitude e^{-rate t}.

    psi is the decaying mode number ``branch`` of angular number ``m``, with ``max |psi| = 1``; its
    rate is 17.2643 for m = 0, 2.38372 and 17.8876 for m = 2, all over scale^4. To first order in
    eps this solves Willmore flow. The surface at t = 0 and all its ``fields`` are exact for every
    amplitude, except that V is the normal velocity of this family; the velocity which the law gives
    the surface is `laws.velocity` of the fields. Trajectories move along the normals of the
    unperturbed torus, which differs from normal motion to second order.

    Raises
    ------
    ValueError
        If ``scale`` is not a positive finite number, not ``|amplitude| <= scale/10``, ``m`` is not
        0 or 2 or ``branch`` not 0 or 1.
    """

    scale: float = 1.0
    amplitude: float = 0.01
    m: int = 2
    branch: int = 0
    name: ClassVar[str] = "perturbed_clifford_torus"
    title: ClassVar[str] = "perturbed Clifford torus"
    mesh_surface: ClassVar[str] = "clifford_torus"
    laws: ClassVar[tuple[str, ...]] = ("willmore",)
    stationary: ClassVar[bool] = False
    always_exact: ClassVar[bool] = False
    reference: ClassVar[str] = "exact"
    measures: ClassVar[tuple[str, ...]] = ("decay",)
    latest_time: ClassVar[float] = np.inf

    def __post_init__(self) -> None:
        positive(scale=self.scale)
        if not abs(self.amplitude) <= 0.1 * self.scale:
            raise ValueError(f"amplitude = {self.amplitude!r}: must have |amplitude| <= scale/10")
        if self.m not in (0, 2):
            raise ValueError(f"m = {self.m!r}: must be 0 or 2")
        if self.branch not in (0, 1):
            raise ValueError(f"branch = {self.branch!r}: must be 0 or 1")

    @property
    def torus(self) -> Torus:
        """The torus that is perturbed."""
        return Torus(self.scale, self.scale / np.sqrt(2.0))

    @property
    def decay_rate(self) -> float:
        """The mode decays like exp(-decay_rate t)."""
        return decaying_modes(self.m)[self.branch][0] / self.scale**4

    @property
    def relative_amplitude(self) -> float:
        """|amplitude| as a part of the larger radius."""
        return abs(self.amplitude) / self.scale

    @property
    def law_parameters(self) -> dict[str, float]:
        return {}

    def amplitude_at(self, t: float) -> float:
        """eps(t)."""
        return self.amplitude * np.exp(-self.decay_rate * t)

    def mode(self, theta: Array, phi: Array) -> Array:
        """psi(theta) cos(m phi), (...)."""
        return self._mode_jet(theta, phi, 0)[0, 0]

    def mode_amplitude(self, x: Array, weights: Array | float = 1.0) -> float:
        """The amplitude eps of the mode in the shape of nodes x (N, 3).

        Weighted least squares for the distances from the unperturbed torus by the mode and the
        eight neutral ones, along which a computed torus drifts: translations, rotations, dilation
        and conformal maps. ``weights`` (N,) may be the lumped masses.
        """
        y = self.torus.closest_point(x)
        nu = self.torus.fields(y).nu
        distance = np.einsum("na,na->n", x - y, nu)
        x_nu = np.einsum("na,na->n", y, nu)
        rotations = np.cross(y, nu)[:, :2]
        conformal = 2.0 * y[:, :2] * x_nu[:, None] - (y**2).sum(-1)[:, None] * nu[:, :2]
        own = self.mode(*self._angles(y))
        modes = np.column_stack([nu, rotations, x_nu, conformal, own])
        root = np.sqrt(np.broadcast_to(weights, distance.shape))
        return float(np.linalg.lstsq(root[:, None] * modes, root * distance)[0][-1])

    def forcing(self, law: str, parameters: Mapping[str, float]) -> None:
        check_unforced(self.name, self.laws, self.law_parameters, law, parameters)

    def trajectories(self, p: Array) -> Callable[[float], Array]:
        theta, phi = self._angles(p)
        return lambda t: self._jet(theta, phi, t, 0)[0, 0]

    def closest_point(self, x: Array, t: float) -> Array:
        """Newton's method for the angles, from those of x: (x - X) . dX/dangle = 0."""
        theta, phi = self._angles(x)
        for _ in range(NEWTON_STEPS):
            X = self._jet(theta, phi, t, 2)
            d = x - X[0, 0]
            X1, X2 = X[1, 0], X[0, 1]
            g1, g2 = (d * X1).sum(-1), (d * X2).sum(-1)
            h11 = (X1 * X1 - 2.0 * d * X[2, 0]).sum(-1)
            h12 = (X1 * X2 - d * X[1, 1]).sum(-1)
            h22 = (X2 * X2 - 2.0 * d * X[0, 2]).sum(-1)
            det = h11 * h22 - h12**2
            step = np.stack([h22 * g1 - h12 * g2, h11 * g2 - h12 * g1]) / det
            theta, phi = theta + step[0], phi + step[1]
            if np.max(np.abs(step), initial=0.0) < 1e-9:
                return self._jet(theta, phi, t, 0)[0, 0]
        raise ValueError("x: a point is too far from the surface to be projected")

    def closest_point_derivative(self, x: Array, t: float) -> Array:
        """(I + d S)^-1 (I - nu nu^T), (..., 3, 3)."""
        y = self.closest_point(x, t)
        nu, dual, _ = jets.frame(self._jet(*self._angles(y), t, 2))
        S, nu = jets.gradient(dual, nu)[0, 0], nu[0, 0]
        d = np.einsum("...a,...a", x - y, nu)
        D = np.linalg.inv(np.eye(3) + d[..., None, None] * S) - outer(nu, nu)
        return 0.5 * (D + np.swapaxes(D, -1, -2))

    def fields(self, y: Array, t: float) -> Fields:
        theta, phi = self._angles(y)
        X = self._jet(theta, phi, t, 4)
        nu, dual, _ = jets.frame(X)
        nu_0 = _torus_normal(theta, phi, 4)
        rate = -self.decay_rate * self.amplitude_at(t)
        V = rate * jets.multiply(self._mode_jet(theta, phi, 4), jets.dot(nu, nu_0))
        S = jets.gradient(dual, nu)
        H = np.einsum("...aa->...", S)
        z = jets.gradient(dual, H)
        grad_z = jets.gradient(dual, z)[0, 0]
        S = S[0, 0]
        return Fields(
            nu=nu[0, 0],
            H=H[0, 0],
            V=V[0, 0],
            z=z[0, 0],
            S=0.5 * (S + np.swapaxes(S, -1, -2)),
            grad_V=jets.gradient(dual, V)[0, 0],
            grad_z=grad_z,
            laplace_H=np.einsum("...aa->...", grad_z),
        )

    @cached_property
    def length(self) -> float:
        area = jets.frame(self._jet(*_grid(POINTS), 0.0, 2))[2]
        return length_of(float(np.sum(area[0, 0]) * (2.0 * np.pi / POINTS) ** 2))

    def willmore(self, t: float, points: int = POINTS) -> float:
        """W = 1/2 int H^2 by the trapezoidal rule in both angles."""
        nu, dual, area = jets.frame(self._jet(*_grid(points), t, 2))
        H = np.einsum("...aa->...", jets.gradient(dual, nu)[0, 0])
        return float(0.5 * np.sum(H**2 * area[0, 0]) * (2.0 * np.pi / points) ** 2)

    def _angles(self, x: Array) -> tuple[Array, Array]:
        """theta, phi (...) of the closest point on the unperturbed torus."""
        axis_distance = np.hypot(x[..., 0], x[..., 1])
        theta = np.arctan2(x[..., 2], axis_distance - self.scale)
        return theta, np.arctan2(x[..., 1], x[..., 0])

    def _mode_jet(self, theta: Array, phi: Array, order: int) -> Array:
        coefficients = decaying_modes(self.m)[self.branch][1]
        k = np.arange(len(coefficients))
        used = np.flatnonzero(coefficients)
        waves = np.exp(1j * np.asarray(theta)[..., None] * k[used])
        derivatives = [
            (waves @ (coefficients * (1j * k) ** j)[used]).real for j in range(order + 1)
        ]
        return jets.separable(derivatives, _cosine(self.m, phi, order))

    def _jet(self, theta: Array, phi: Array, t: float, order: int) -> Array:
        """The jet (order+1, order+1, ..., 3) of the surface in theta, phi."""
        core = self.torus.R * _revolved([1.0] + [0.0] * order, [0.0] * (order + 1), phi)
        tube = self.amplitude_at(t) * self._mode_jet(theta, phi, order)
        tube[0, 0] += self.torus.r
        return core + jets.multiply(tube[..., None], _torus_normal(theta, phi, order))


def _grid(points: int) -> tuple[Array, Array]:
    """theta, phi (points, points), equidistant around."""
    angle = 2.0 * np.pi * np.arange(points) / points
    theta, phi = np.meshgrid(angle, angle, indexing="ij")
    return theta, phi


def _cosine(m: int, angle: Array, order: int, shift: float = 0.0) -> list[Array]:
    """cos(m angle + shift) and its derivatives by the angle."""
    angle = np.asarray(angle)
    return [m**j * np.cos(m * angle + shift + 0.5 * j * np.pi) for j in range(order + 1)]


def _torus_normal(theta: Array, phi: Array, order: int) -> Array:
    """The jet of cos(theta) e_rho + sin(theta) e_3."""
    return _revolved(_cosine(1, theta, order), _cosine(1, theta, order, -0.5 * np.pi), phi)


def _revolved(rho: jets.Derivatives, height: jets.Derivatives, phi: Array) -> Array:
    """The jet of (rho cos phi, rho sin phi, height) from derivatives of rho and height by theta."""
    n = len(rho) - 1
    c, s = _cosine(1, phi, n), _cosine(1, phi, n, -0.5 * np.pi)
    one = [np.ones_like(c[0])] + [np.zeros_like(c[0])] * n
    return np.stack(
        [jets.separable(rho, c), jets.separable(rho, s), jets.separable(height, one)], axis=-1
    )
