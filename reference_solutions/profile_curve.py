"""Profile curves of surfaces of revolution as trigonometric series, and the shapes to start from.

The profile (rho(s), z(s)) in the half plane rho >= 0 runs counterclockwise, so that (z_s, -rho_s)
points outward. Both topologies live on one circle of parameters:

- genus 0: s in [0, pi] from the south to the north pole, rho = sum a_k sin(ks), z = sum b_k
  cos(ks). The parities are those of a curve reflected at the axis; they make the surface smooth at
  the poles, and a full circle of s runs through the curve and its mirror image;
- genus 1: s in [0, 2 pi), rho > 0, both full Fourier series.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import eval_legendre

from esfem.reference_solutions.exact import Array, positive

SMALLEST_RESOLUTION = 8
# Bound on the last quarter of the coefficients, relative to the largest.
LARGEST_TAIL = 1e-4


def waves(k: Array, phase: Array, s: Array, order: int = 0) -> Array:
    """Derivatives of cos(k s + phase), shape (..., modes); sin(ks) has phase -pi/2."""
    return k**order * np.cos(np.multiply.outer(s, k) + phase + order * np.pi / 2.0)


def modes(genus: int, K: int) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """(k, phase) of the series of rho and of z up to wave number K; cosines come before sines."""
    k = np.arange(K + 1.0)
    cosines, sines = (k, 0.0 * k), (k[1:], 0.0 * k[1:] - np.pi / 2.0)
    if genus == 0:
        return sines, cosines
    both = np.concatenate([cosines[0], sines[0]]), np.concatenate([cosines[1], sines[1]])
    return both, both


def nodes(genus: int, n: int) -> Array:
    """Midpoints of n equal steps over the parameter interval: a pole is never a node."""
    return (np.arange(n) + 0.5) * (1.0 + genus) * np.pi / n


def fit(k: Array, phase: Array, s: Array) -> Array:
    """Matrix from values at `nodes` to coefficients of `waves`, by discrete orthogonality."""
    return np.where(k == 0, 1.0, 2.0)[:, None] / len(s) * waves(k, phase, s).T


@dataclass(frozen=True, eq=False)
class Profile:
    """A smooth profile curve; calling it with s, (...), gives (rho, z), each of the shape of s.

    Parameters
    ----------
    genus : 0 or 1, see the module's docstring.
    rho, z : coefficients of the two series, in the order of `modes`.

    Raises
    ------
    ValueError
        If genus is neither 0 nor 1, the numbers of coefficients do not fit together, the curve
        meets the axis elsewhere than at its poles, or runs clockwise.
    """

    genus: int
    rho: Array
    z: Array

    def __post_init__(self) -> None:
        if self.genus not in (0, 1):
            raise ValueError(f"genus = {self.genus!r}: must be 0 or 1")
        expected = self.K + 1 if self.genus == 0 else 2 * self.K + 1
        if len(self.z) != expected:
            raise ValueError(f"z = {len(self.z)} coefficients: must be {expected} beside rho")
        s = nodes(self.genus, 16 * (self.K + 1))
        rho, z_s = self(s)[0], self(s, 1)[1]
        if not np.all(rho > 0.0):
            raise ValueError(f"rho = {rho.min():.6g} on the profile: must be > 0 off the poles")
        if np.sum(rho**2 * z_s) <= 0.0:
            raise ValueError(f"z = {self.z!r}: the profile must run counterclockwise")

    @property
    def K(self) -> int:
        """The largest wave number."""
        return len(self.rho) if self.genus == 0 else len(self.rho) // 2

    @property
    def tail(self) -> float:
        """The largest of the last quarter of the coefficients over the largest of all, k > 0."""
        k = np.concatenate([k for k, _ in modes(self.genus, self.K)])
        c = np.abs(np.concatenate([self.rho, self.z]))
        return float(c[k > 0.75 * self.K].max() / c[k > 0].max())

    def __call__(self, s: Array, order: int = 0) -> tuple[Array, Array]:
        """(rho, z) at parameters s, or their s-derivatives of the given order."""
        of_rho, of_z = modes(self.genus, self.K)
        return waves(*of_rho, s, order) @ self.rho, waves(*of_z, s, order) @ self.z


@dataclass(frozen=True)
class Galerkin:
    """The nodes, and the matrices between coefficients and nodes, for series up to K."""

    genus: int
    K: int

    @cached_property
    def s(self) -> Array:
        return nodes(self.genus, 2 * self.K * (1 + self.genus))

    @cached_property
    def rho_waves(self) -> list[Array]:
        """Coefficients of rho -> rho, rho_s, rho_ss at the nodes."""
        return [waves(*modes(self.genus, self.K)[0], self.s, order) for order in range(3)]

    @cached_property
    def z_waves(self) -> list[Array]:
        """Coefficients of z -> z, z_s, z_ss at the nodes."""
        return [waves(*modes(self.genus, self.K)[1], self.s, order) for order in range(3)]

    @cached_property
    def fits(self) -> tuple[Array, Array]:
        """Values -> coefficients, for rho and for z."""
        of_rho, of_z = modes(self.genus, self.K)
        return fit(*of_rho, self.s), fit(*of_z, self.s)

    @cached_property
    def derivative(self) -> Array:
        """Values of f -> values of f_s, for f of the parity of z; all modes the nodes resolve."""
        _, every = modes(self.genus, 2 * self.K - 1)
        return waves(*every, self.s, 1) @ fit(*every, self.s)

    @cached_property
    def antiderivative(self) -> Array:
        """Values of f, of the parity of z -> values of the integral of f - mean(f), with mean 0."""
        _, (k, phase) = modes(self.genus, 2 * self.K - 1)
        wavy = k > 0
        k, phase = k[wavy], phase[wavy]
        return waves(k, phase - np.pi / 2.0, self.s) / k @ fit(k, phase, self.s)

    @cached_property
    def weights(self) -> Array:
        """Quadrature over the parameter interval, for integrands of the parity of rho.

        Genus 0: the integral of sin(ks) over [0, pi] is 2/k for odd k, else 0.
        """
        if self.genus == 1:
            return np.full(len(self.s), 2.0 * np.pi / len(self.s))
        (k, phase), _ = modes(0, 2 * self.K - 1)
        return np.where(k % 2 == 1, 2.0 / k, 0.0) @ fit(k, phase, self.s)


def fit_profile(genus: int, curve: Callable[[Array], tuple[Array, Array]], K: int) -> Profile:
    """The profile with wave numbers up to K fitted to a curve s -> (rho, z) on twice the nodes."""
    s = nodes(genus, 2 * K * (1 + genus))
    of_rho, of_z = modes(genus, K)
    rho, z = curve(s)
    return Profile(genus, fit(*of_rho, s) @ rho, fit(*of_z, s) @ z)


def equal_arclength(profile: Profile, resolution: int) -> Profile:
    """The same curve, its parameter proportional to arclength, with ``resolution`` wave numbers.

    Raises
    ------
    ValueError
        If the resolution is below `SMALLEST_RESOLUTION`, or leaves a tail above `LARGEST_TAIL`.
    """
    if resolution < SMALLEST_RESOLUTION:
        raise ValueError(f"resolution = {resolution}: must be at least {SMALLEST_RESOLUTION}")
    fine = nodes(1, 2048)
    (k, phase), _ = modes(1, 512)
    speed = fit(k, phase, fine) @ np.hypot(*profile(fine, 1))
    k, phase, wavy, mean = k[1:], phase[1:], speed[1:], speed[0]

    def arclength(p: Array) -> Array:
        """Length of the curve from 0 to p over the mean speed."""
        up = waves(k, phase - np.pi / 2.0, p) - waves(k, phase - np.pi / 2.0, np.zeros(1))
        return p + up @ (wavy / k) / mean

    def curve(s: Array) -> tuple[Array, Array]:
        around = np.linspace(0.0, 2.0 * np.pi, 257)
        p = np.interp(s, arclength(around), around)
        for _ in range(6):  # Newton's method, from two digits to all
            p = p - (arclength(p) - s) * mean / np.hypot(*profile(p, 1))
        return profile(p)

    even = fit_profile(profile.genus, curve, resolution)
    if even.tail > LARGEST_TAIL:
        raise ValueError(
            f"resolution = {resolution}: leaves a tail of {even.tail:.1e} in the start curve's "
            f"coefficients, which must be at most {LARGEST_TAIL:.0e}"
        )
    return even


def perturbed_sphere_profile(amplitude: float, degree: int) -> Profile:
    """r = 1 + amplitude P_degree(cos theta), theta from the north pole."""

    def curve(s: Array) -> tuple[Array, Array]:
        r = 1.0 + amplitude * eval_legendre(degree, -np.cos(s))
        return r * np.sin(s), -r * np.cos(s)

    return fit_profile(0, curve, degree + 2)


def spheroid_profile(a: float, c: float) -> Profile:
    """rho^2/a^2 + z^2/c^2 = 1: half-axes a (equator) and c (axis of revolution)."""
    positive(a=a, c=c)
    return fit_profile(0, lambda s: (a * np.sin(s), -c * np.cos(s)), 2)


def red_blood_cell_profile() -> Profile:
    """(2 cos p, (1 - 0.7 (cos^2 p - 1)^2) sin p), with p = s - pi/2 in [-pi/2, pi/2]."""
    return fit_profile(0, lambda s: (2.0 * np.sin(s), -(1.0 - 0.7 * np.cos(s) ** 4) * np.cos(s)), 6)
