"""The surfaces that can be meshed: `MESH_SURFACES`, and those of `reference_solutions.surfaces`."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from esfem.reference_solutions import CliffordTorus, StationarySphere
from esfem.reference_solutions.surfaces import named_surface, surface_names
from esfem.solver.reference_element import Array

SPEED_SAMPLES = 2000
MOST_VERTICES = 200_000  # the cloud from which a mesh is drawn has 60 times as many points


@dataclass(frozen=True)
class MeshSurface:
    """What the generator must know of a closed surface.

    Attributes
    ----------
    name : key in `MESH_SURFACES`, or file name of a named surface.
    genus : 0, parametrised by the unit sphere, or 1, parametrised by a periodic rectangle.
    embed : parameters (N, 3) of unit length, or (N, 2), to points (N, 3) of the surface. Preserves
        orientation: outward on S^2 goes to outward, and ``embed_u x embed_v`` points outward.
    project : points (N, 3) near the surface to their closest points on it.
    normal : the exact outward normal (N, 3) at points of the surface.
    size : wished edge lengths (N,) at points of the surface, up to a common factor.
    minimum_vertices : fewer are refused. In `MESH_SURFACES`, from here on each V tried passes the
        quality gate with 8 seeds; of named surfaces, the gate tells.
    periods : sides of the parameter rectangle, for genus 1. Its metric should be near conformal to
        the surface, for the first connectivity is Delaunay there.

    Raises
    ------
    ValueError
        If ``genus`` is not 0 or 1, or ``periods`` is not two positive numbers for genus 1 and None
        for genus 0.
    """

    name: str
    genus: int
    embed: Callable[[Array], Array]
    project: Callable[[Array], Array]
    normal: Callable[[Array], Array]
    size: Callable[[Array], Array]
    minimum_vertices: int
    periods: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.genus not in (0, 1):
            raise ValueError(f"genus = {self.genus!r}: must be 0 or 1")
        sides = () if self.periods is None else self.periods
        if len(sides) != 2 * self.genus or not all(side > 0 for side in sides):
            allowed = "two positive numbers for genus 1, None for genus 0"
            raise ValueError(f"periods = {self.periods!r}: must be {allowed}")

    @property
    def euler_characteristic(self) -> int:
        """2 - 2 genus."""
        return 2 - 2 * self.genus


def sphere_surface() -> MeshSurface:
    """The unit sphere, of uniform size."""
    sphere = StationarySphere()
    return MeshSurface(
        name="sphere",
        genus=0,
        embed=lambda p: p,
        project=lambda x: sphere.closest_point(x, 0.0),
        normal=lambda y: sphere.fields(y, 0.0).nu,
        size=lambda y: np.ones(len(y)),
        minimum_vertices=6,
    )


def clifford_torus_surface() -> MeshSurface:
    """The torus R = 1, r = 1/sqrt(2), of size (distance from the axis)^(1/2).

    Of uniform size, coarse elements invert near the axis. The parameters phi and
    v = w r/sqrt(R^2 - r^2), w = 2 atan(sqrt((R - r)/(R + r)) tan(theta/2)), are conformal: the
    metric is rho^2 (dphi^2 + dv^2).
    """
    solution = CliffordTorus()
    R, r = solution.torus.R, solution.torus.r
    aspect = r / np.sqrt(R**2 - r**2)

    def embed(p: Array) -> Array:
        phi, w = p[:, 0], p[:, 1] / aspect
        theta = 2.0 * np.arctan2(np.sqrt(R + r) * np.sin(w / 2), np.sqrt(R - r) * np.cos(w / 2))
        rho = R + r * np.cos(theta)
        return np.stack([rho * np.cos(phi), rho * np.sin(phi), r * np.sin(theta)], axis=1)

    return MeshSurface(
        name="clifford_torus",
        genus=1,
        embed=embed,
        project=lambda x: solution.closest_point(x, 0.0),
        normal=lambda y: solution.fields(y, 0.0).nu,
        size=lambda y: np.sqrt(np.hypot(y[:, 0], y[:, 1])),
        minimum_vertices=18,
        periods=(2.0 * np.pi, 2.0 * np.pi * aspect),
    )


MESH_SURFACES: dict[str, MeshSurface] = {
    "sphere": sphere_surface(),
    "clifford_torus": clifford_torus_surface(),
}


def mesh_surface(surface: str) -> MeshSurface:
    """The entry of `MESH_SURFACES` or the named surface; ValueError that lists the names."""
    if surface in MESH_SURFACES:
        return MESH_SURFACES[surface]
    names = surface_names()
    if surface not in names:
        allowed = ", ".join([*MESH_SURFACES, *names])
        raise ValueError(f"surface = {surface!r}: must be one of {allowed}")
    return named_mesh_surface(surface)


@cache
def named_mesh_surface(name: str) -> MeshSurface:
    """The surface of `esfem.reference_solutions.surfaces`, of uniform size.

    The second angle of a torus is scaled by the ratio of the mean speeds, which brings the
    parameters as near to conformal as a factor can.
    """
    surface = named_surface(name)
    aspect = 1.0
    if surface.genus == 1:
        p = np.random.default_rng(0).random((SPEED_SAMPLES, 2)) * 2.0 * np.pi
        first, second = (
            np.linalg.norm(surface.embed(p + s) - surface.embed(p - s), axis=1)
            for s in np.eye(2) * 1e-5
        )
        aspect = float(np.sqrt(np.mean(second**2) / np.mean(first**2)))
    return MeshSurface(
        name=name,
        genus=surface.genus,
        embed=surface.embed if surface.genus == 0 else lambda p: surface.embed(p / [1.0, aspect]),
        project=surface.closest_point,
        normal=lambda y: surface.normal_and_shape(y)[0],
        size=lambda y: np.ones(len(y)),
        minimum_vertices=12 if surface.genus == 0 else 18,
        periods=None if surface.genus == 0 else (2.0 * np.pi, 2.0 * np.pi * aspect),
    )


def check_vertices(surface: str, vertices: int) -> None:
    """Raise ValueError unless the surface is known and has meshes of so many vertices."""
    least = mesh_surface(surface).minimum_vertices
    if not isinstance(vertices, int | np.integer) or vertices < least:
        raise ValueError(
            f"vertices = {vertices!r}: must be an integer, at least {least}, on surface {surface}"
        )
    if vertices > MOST_VERTICES:
        raise ValueError(f"vertices = {vertices!r}: must be at most {MOST_VERTICES:,}")
