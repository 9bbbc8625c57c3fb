"""Geometric flows of surfaces of revolution, computed on their profile curve alone.

An independent witness: one space dimension, spectral, and its own derivation of the geometry. On a
counterclockwise profile (rho(s), z(s)), g = |(rho_s, z_s)|, t = (rho_s, z_s)/g and nu = (z_s,
-rho_s)/g, and with H = kappa_1 + kappa_2 > 0 on spheres,

    kappa_1 = (rho_s z_ss - z_s rho_ss)/g^3,    kappa_2 = z_s/(g rho),
    Lap H = (rho H_s/g)_s/(g rho),              V = Lap H + Q(H, |S|^2), or V = -H.

The curve moves by V nu + T t. The tangential velocity, T_s = mean(g kappa_1 V) - g kappa_1 V, has
g_t = T_s + g kappa_1 V constant along the curve: equal arclength is kept.
Space: Fourier Galerkin with twice as many nodes as modes. Time: Radau IIA of order 5 (scipy) with
the exact Jacobian, by complex steps.

References
----------
Hou, Lowengrub & Shelley, J. Comput. Phys. 114 (1994), section 2, for T.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import Radau
from scipy.optimize import minimize_scalar

from esfem.reference_solutions.exact import Array, positive
from esfem.reference_solutions.profile_curve import (
    LARGEST_TAIL,
    Galerkin,
    Profile,
    equal_arclength,
)


@dataclass(frozen=True, eq=False)
class Geometry:
    """Quantities at the nodes of a `Galerkin` space: (nodes, ...)."""

    rho: Array
    rho_s: Array
    z_s: Array
    g: Array
    kappa_1: Array
    kappa_2: Array
    laplace_H: Array

    @property
    def H(self) -> Array:
        return self.kappa_1 + self.kappa_2

    @property
    def S2(self) -> Array:
        """|S|^2 = kappa_1^2 + kappa_2^2."""
        return self.kappa_1**2 + self.kappa_2**2


MOST_STEPS = 1000  # of the integrator between two times; smooth flows to t = 4 need 300

# V of each law, from the geometry and the spontaneous curvature H0.
VELOCITIES: dict[str, Callable[[Geometry, float], Array]] = {
    "willmore": lambda G, H0: G.laplace_H + G.S2 * G.H - G.H**3 / 2.0,
    "helfrich": lambda G, H0: G.laplace_H + G.S2 * (G.H - H0) - G.H * (G.H - H0) ** 2 / 2.0,
    "surface_diffusion": lambda G, H0: G.laplace_H,
    "mean_curvature": lambda G, H0: -G.H,
}
# The density of the energy that the flow of the law decreases, from H and H0.
DENSITIES: dict[str, Callable[[Array, float], Array]] = {
    "willmore": lambda H, H0: H**2 / 2.0,
    "helfrich": lambda H, H0: (H - H0) ** 2 / 2.0,
    "surface_diffusion": lambda H, H0: np.ones_like(H),
    "mean_curvature": lambda H, H0: np.ones_like(H),
}


def geometry(space: Galerkin, c: Array) -> Geometry:
    """Geometry of the curves with coefficients c = (rho, z), (coefficients, ...), also complex."""
    n = space.rho_waves[0].shape[1]
    rho, rho_s, rho_ss = (B @ c[:n] for B in space.rho_waves)
    _, z_s, z_ss = (B @ c[n:] for B in space.z_waves)
    g = np.sqrt(rho_s**2 + z_s**2)
    kappa_1 = (rho_s * z_ss - z_s * rho_ss) / g**3
    kappa_2 = z_s / (g * rho)
    D = space.derivative
    laplace_H = D @ (rho / g * (D @ (kappa_1 + kappa_2))) / (g * rho)
    return Geometry(rho, rho_s, z_s, g, kappa_1, kappa_2, laplace_H)


def coefficients(profile: Profile) -> Array:
    """The unknowns c = (rho, z)."""
    return np.concatenate([profile.rho, profile.z])


def coefficient_velocity(space: Galerkin, c: Array, law: str, H0: float) -> Array:
    """dc/dt of V nu + T t, shape of c."""
    G = geometry(space, c)
    V = VELOCITIES[law](G, H0)
    T = -(space.antiderivative @ (G.g * G.kappa_1 * V))
    rho_t = (V * G.z_s + T * G.rho_s) / G.g
    z_t = (-V * G.rho_s + T * G.z_s) / G.g
    fit_rho, fit_z = space.fits
    return np.concatenate([fit_rho @ rho_t, fit_z @ z_t])


def coefficient_jacobian(space: Galerkin, c: Array, law: str, H0: float) -> Array:
    """d(dc/dt)/dc by complex steps, which do not cancel: exact to round-off."""
    step = 1e-30
    shifted = c[:, None] + 1j * step * np.eye(len(c))
    return coefficient_velocity(space, shifted, law, H0).imag / step


@dataclass(frozen=True, eq=False)
class ProfileFlow:
    """A computed flow at the instants ``times``, (n,).

    Attributes
    ----------
    profiles : the curves, in arclength.
    energies : (n,) what the flow of the law decreases: W under Willmore flow, 1/2 int (H - H0)^2
        under Helfrich flow, the area under surface diffusion and mean curvature flow.
    willmore : (n,) W = 1/2 int H^2, under any law.
    areas, volumes : (n,)
    poles : (n, 2) z of the south and the north pole; (n, 0) for a ring.
    equators : (n,) the largest distance from the axis.
    """

    times: Array
    profiles: tuple[Profile, ...]
    energies: Array
    willmore: Array
    areas: Array
    volumes: Array
    poles: Array
    equators: Array

    def profile(self, i: int) -> Profile:
        """The curve at ``times[i]``: call it with s to get (rho, z)."""
        return self.profiles[i]


def measure(profile: Profile, law: str = "willmore", H0: float = 0.0) -> dict[str, Array | float]:
    """Energy of the law, W, area, volume, poles and equator of one profile."""
    space = Galerkin(profile.genus, profile.K)
    G = geometry(space, coefficients(profile))
    area_element = 2.0 * np.pi * space.weights * G.rho * G.g
    crest, step = space.s[np.argmax(G.rho)], space.s[1] - space.s[0]
    equator = minimize_scalar(
        lambda s: -float(profile(s)[0]),
        bounds=(crest - step, crest + step),
        method="bounded",
        options={"xatol": 1e-9},
    )
    return {
        "energies": area_element @ DENSITIES[law](G.H, H0),
        "willmore": area_element @ DENSITIES["willmore"](G.H, H0),
        "areas": np.sum(area_element),
        "volumes": np.pi * space.weights @ (G.rho**2 * G.z_s),
        "poles": profile(np.array([0.0, np.pi]))[1] if profile.genus == 0 else np.empty(0),
        "equators": -equator.fun,
    }


def evolve_profile(
    profile: Profile,
    law: str,
    times: Sequence[float],
    spontaneous_curvature: float = 0.0,
    resolution: int = 64,
    rtol: float = 1e-9,
) -> ProfileFlow:
    """The flow by a law from ``profile`` at time 0, at each of ``times``.

    Parameters
    ----------
    profile : the start curve, in any parameter.
    law : a key of `VELOCITIES`.
    times : increasing, the first one 0.
    spontaneous_curvature : H0, which only ``helfrich`` reads.
    resolution : the largest wave number of the series in arclength.
    rtol : local error of a time step, relative to the largest coefficient.

    Raises
    ------
    ValueError
        If an argument is out of its bounds, or the resolution leaves the start curve a long tail.
    RuntimeError
        If the steps shrink to nothing or the curve outgrows the resolution: a singularity.
    """
    if law not in VELOCITIES:
        raise ValueError(f"law = {law!r}: must be one of {', '.join(VELOCITIES)}")
    t = np.asarray(times, float)
    if t.ndim != 1 or t.size == 0 or t[0] != 0.0 or not np.all(np.diff(t) > 0.0):
        raise ValueError(f"times = {times!r}: must start with 0 and increase")
    if law != "helfrich" and spontaneous_curvature != 0.0:
        raise ValueError(f"spontaneous_curvature = {spontaneous_curvature!r}: must be 0 for {law}")
    positive(rtol=rtol)

    start = equal_arclength(profile, resolution)
    space, c = Galerkin(start.genus, resolution), coefficients(start)
    n = len(start.rho)
    profiles, first_step = [start], None
    for t_from, t_to in pairwise(t):
        c, first_step = integrate(
            space, c, (law, spontaneous_curvature), (t_from, t_to), first_step, rtol
        )
        profiles.append(Profile(start.genus, c[:n], c[n:]))
        if profiles[-1].tail > LARGEST_TAIL:
            raise RuntimeError(
                f"resolution = {resolution}: leaves a tail of {profiles[-1].tail:.1e} at t = "
                f"{t_to}, which must be at most {LARGEST_TAIL:.0e}"
            )
    measured = [measure(p, law, spontaneous_curvature) for p in profiles]
    columns = {key: np.array([m[key] for m in measured]) for key in measured[0]}
    return ProfileFlow(t, tuple(profiles), **columns)


def integrate(
    space: Galerkin,
    c: Array,
    law: tuple[str, float],
    span: tuple[float, float],
    first_step: float | None,
    rtol: float,
) -> tuple[Array, float]:
    """Coefficients at the end of ``span``, reached by a step and not by interpolation, and the
    step to go on with; RuntimeError if it is not reached in `MOST_STEPS`."""
    solver = Radau(
        lambda t, c: coefficient_velocity(space, c, *law),
        span[0],
        c,
        span[1],
        jac=lambda t, c: coefficient_jacobian(space, c, *law),
        first_step=None if first_step is None else min(first_step, span[1] - span[0]),
        rtol=rtol,
        atol=rtol * np.abs(c).max(),
    )
    for _ in range(MOST_STEPS):
        if solver.status != "running":
            break
        message = solver.step()
    else:
        raise RuntimeError(f"{MOST_STEPS} steps lead no further than t = {solver.t:.3g}")
    if solver.status == "failed":
        raise RuntimeError(f"rtol = {rtol}: not met at t = {solver.t:.6g}: {message}")
    return solver.y, solver.h_abs
