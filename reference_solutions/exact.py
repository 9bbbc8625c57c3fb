"""What every exact solution offers, and the closest-point algebra they share."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, TypeGuard

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StartFields:
    """Exact geometric quantities at given points of a surface, without a velocity.

    With ``...`` the shape of the point array without its last axis: ``nu, z`` are (..., 3), ``H``
    is (...), ``S`` = grad nu (the shape operator, symmetric) and ``grad_z`` are (..., 3, 3). ``z``
    = grad H, and ``laplace_H`` (...) is its divergence Lap_Gamma H. Convention: ``grad_z[..., a,
    b]`` is the a-th tangential derivative of ``z_b``. `laws.velocity` gives the V that a law makes
    of them.
    """

    nu: Array
    H: Array
    z: Array
    S: Array
    grad_z: Array
    laplace_H: Array


@dataclass(frozen=True, kw_only=True)
class Fields(StartFields):
    """The exact quantities on Gamma(t), with its velocity: ``V`` (...) and ``grad_V`` (..., 3)."""

    V: Array
    grad_V: Array

    @property
    def v(self) -> Array:
        """Velocity V nu, shape (..., 3)."""
        return self.V[..., None] * self.nu

    @property
    def grad_v(self) -> Array:
        """Tangential gradient of V nu, ``d_a V nu_b + V S_ab``, shape (..., 3, 3)."""
        return outer(self.grad_V, self.nu) + self.V[..., None, None] * self.S


def enlarged(f: Fields, scale: float) -> Fields:
    """The quantities on the surface enlarged by ``scale``, which moves scale times as fast."""
    return Fields(
        nu=f.nu,
        H=f.H / scale,
        z=f.z / scale**2,
        S=f.S / scale,
        grad_z=f.grad_z / scale**3,
        laplace_H=f.laplace_H / scale**3,
        V=scale * f.V,
        grad_V=f.grad_V,
    )


class InitialSurface(Protocol):
    """A smooth closed surface Gamma(0) from which a flow starts, with its exact quantities there.

    ``mesh_surface`` names the family of meshes on which it is computed, ``scale`` the factor by
    which they are enlarged, and ``centre`` where the origin of the mesh goes then: a parameter of
    every solution (`esfem.reference_solutions.placed`). ``closest_point(x, 0)`` takes the points x
    of such a mesh exactly onto Gamma(0). ``laws`` are the names of the velocity laws with which it
    can be run. What is not ``always_exact`` is exact at t = 0 only. ``reference`` says with what a
    run is compared: the "exact" solution, the "axisymmetric" solver, the "finest" level, or nothing
    but its "start". ``measures`` names what is known of a run beside exact fields: "decay", of a
    `DecayingMode`; "growth", of the lengths of normals, at ``off_constraint_rate``; "size_x",
    "size_v", "size_H", "size_V", of errors, by `esfem.reference_solutions.discrete.RadialRun`.
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]  # its parameters
    name: ClassVar[str]
    title: ClassVar[str]
    laws: ClassVar[tuple[str, ...]]
    stationary: ClassVar[bool]
    always_exact: ClassVar[bool]
    measures: ClassVar[tuple[str, ...]]

    @property
    def reference(self) -> str:
        """With what a run is compared: "exact", "axisymmetric", "finest" or "start"."""

    @property
    def mesh_surface(self) -> str:
        """The family of meshes, a key of `esfem.meshes`."""

    @property
    def law_parameters(self) -> dict[str, float]:
        """The parameters that the law must have for this solution; {} if it asks for none."""

    @property
    def scale(self) -> float:
        """Factor from the unit mesh of ``mesh_surface`` to Gamma(0)."""

    @property
    def centre(self) -> tuple[float, float, float]:
        """Where the origin of the unit mesh lies."""

    @property
    def length(self) -> float:
        """L = sqrt(area(Gamma(0)) / 4 pi), the radius of the sphere of that area: the unit of
        length in norms that add values and gradients. Relative error below 1e-10."""

    @property
    def latest_time(self) -> float:
        """The solution exists for 0 <= t < latest_time; inf if it exists always."""

    def forcing(
        self, law: str, parameters: Mapping[str, float]
    ) -> Callable[[Array, float], Array] | None:
        """f(x, t), such that V = Lap H + Q + f on Gamma(t); None if the law needs no forcing.

        Takes points x (..., 3) near Gamma(t) to (...). Off the surface it is some smooth extension.
        ValueError if the solution cannot be run with this law.
        """

    def closest_point(self, x: Array, t: float) -> Array:
        """The point of Gamma(t) nearest to x, shape (..., 3)."""

    def fields(self, y: Array, t: float) -> StartFields:
        """The exact quantities at points y of Gamma(t)."""


class DecayingMode(Protocol):
    """A solution with a mode that decays like exp(-decay_rate t), from its parameter amplitude."""

    @property
    def amplitude(self) -> float: ...

    @property
    def decay_rate(self) -> float: ...

    @property
    def relative_amplitude(self) -> float:
        """The amplitude at t = 0 over the size of the surface."""

    def mode_amplitude(self, x: Array, weights: Array) -> float:
        """The amplitude of the mode in a surface with nodes x (N, 3)."""


def decays(solution: InitialSurface) -> TypeGuard[DecayingMode]:
    """Whether it is a decaying mode."""
    return "decay" in solution.measures


class ExactSolution(InitialSurface, Protocol):
    """An exact evolving surface Gamma(t) together with its geometric quantities.

    One that is not ``always_exact`` solves the law to first order in its amplitude.
    """

    def fields(self, y: Array, t: float) -> Fields:
        """The exact quantities at points y of Gamma(t), and the velocity there."""

    def trajectories(self, p: Array) -> Callable[[float], Array]:
        """t -> X(p, t), shape (..., 3), for labels p (..., 3) on Gamma(0): d/dt X = V nu."""

    def closest_point_derivative(self, x: Array, t: float) -> Array:
        """D closest_point at x, symmetric, shape (..., 3, 3)."""

    def willmore(self, t: float) -> float:
        """The exact Willmore energy 1/2 int H^2 of Gamma(t)."""


def length_of(area: float) -> float:
    """sqrt(area / 4 pi), the radius of the sphere of that area."""
    return float(np.sqrt(area / (4.0 * np.pi)))


def outer(a: Array, b: Array) -> Array:
    """a_i b_j over leading axes: (..., 3), (..., 3) -> (..., 3, 3)."""
    return a[..., :, None] * b[..., None, :]


def closest_point_jacobian(d: Array, principal: list[tuple[Array, Array]]) -> Array:
    """D closest_point = sum_i t_i t_i^T / (1 + d kappa_i).

    Parameters
    ----------
    d : (...) signed distance of the point to the surface, positive outside.
    principal : pairs (kappa_i (...), t_i (..., 3)): principal curvatures and unit directions at the
        closest point.

    Returns
    -------
    (..., 3, 3), symmetric.

    References
    ----------
    Demlow, SIAM J. Numer. Anal. 47 (2009), section 2.
    """
    terms = (outer(t, t) / (1.0 + d * kappa)[..., None, None] for kappa, t in principal)
    return sum(terms, np.zeros(()))


def positive(**parameters: float) -> None:
    """Raise ValueError naming the first parameter that is not a positive finite number."""
    for name, value in parameters.items():
        if not (np.isfinite(value) and value > 0):
            raise ValueError(f"{name} = {value!r}: must be a positive finite number")


def finite(**parameters: float) -> None:
    """Raise ValueError naming the first parameter that is not a finite number."""
    for name, value in parameters.items():
        if not np.isfinite(value):
            raise ValueError(f"{name} = {value!r}: must be a finite number")
