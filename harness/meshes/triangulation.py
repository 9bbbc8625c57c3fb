"""A triangulation of an exact surface: how good it is, how it is stored.

A mesh is an npz file that carries the seed it was made from, its quality and the sha256 of its
arrays.
"""

import hashlib
import io
import zlib
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from esfem.common.files import whole
from esfem.meshes.quality import angles, curved_qualities, radius_ratios
from esfem.meshes.surfaces import mesh_surface
from esfem.solver.mesh import Integers, triangulation
from esfem.solver.reference_element import Array

CURVED_DEGREES = (2, 3, 4)
LEAST_RADIUS_RATIO = 0.6
LEAST_ANGLE = 30.0  # degrees


class MeshQualityError(ValueError):
    """A triangulation misses the quality gate of `SurfaceMesh.check_quality`."""


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """A triangulation of a surface of `MESH_SURFACES`, its seed and its quality.

    Attributes
    ----------
    surface : name.
    vertices : (V, 3) float64, on the surface.
    triangles : (E, 3) int64, closed, counter-clockwise seen from outside.
    seed : of the generator.
    radius_ratio : min over elements of 2 r_in / r_circ.
    curved_quality : min over elements and degrees k = 2, 3, 4 of `curved_qualities`.
    min_angle : degrees.

    Raises
    ------
    ValueError
        If the surface is unknown, or this is no closed oriented mesh of its genus.
    """

    surface: str
    vertices: Array
    triangles: Integers
    seed: int
    radius_ratio: float
    curved_quality: float
    min_angle: float

    def __post_init__(self) -> None:
        expected = mesh_surface(self.surface).euler_characteristic
        if self.vertices.ndim != 2 or self.vertices.shape[1] != 3:
            raise ValueError(f"vertices: must have shape (V, 3), has {self.vertices.shape}")
        if not np.isfinite(self.vertices).all():
            raise ValueError("vertices: must be finite")
        mesh = triangulation(self.triangles)
        if mesh.vertex_count != len(self.vertices):
            raise ValueError(f"triangles: use {mesh.vertex_count} of {len(self.vertices)} vertices")
        if mesh.euler_characteristic != expected:
            raise ValueError(
                f"triangles: Euler characteristic is {mesh.euler_characteristic}, "
                f"must be {expected} on {self.surface}"
            )

    @property
    def quality(self) -> float:
        """min(radius ratio, curved quality), by which the best seed is chosen."""
        return min(self.radius_ratio, self.curved_quality)

    @cached_property
    def digest(self) -> str:
        """sha256, hexadecimal, of name, zero byte and little-endian vertices and triangles."""
        vertices = np.ascontiguousarray(self.vertices, dtype="<f8").tobytes()
        triangles = np.ascontiguousarray(self.triangles, dtype="<i8").tobytes()
        return hashlib.sha256(self.surface.encode() + b"\0" + vertices + triangles).hexdigest()

    def check_quality(self) -> None:
        """Raise MeshQualityError unless q > 0.6, angles > 30 degrees, curved elements positive."""
        name = f"{self.surface}, {len(self.vertices)} vertices, seed {self.seed}"
        for quantity, value, bound in (
            ("radius ratio", self.radius_ratio, LEAST_RADIUS_RATIO),
            ("least angle", self.min_angle, LEAST_ANGLE),
            ("curved quality", self.curved_quality, 0.0),
        ):
            if not value > bound:
                raise MeshQualityError(f"{name}: {quantity} {value:.3f} must exceed {bound:g}")

    @property
    def identity(self) -> dict[str, Any]:
        """What a record says of it: surface, number of vertices and digest."""
        found = {"surface": self.surface, "vertices": len(self.vertices)}
        return {**found, "digest": self.digest}

    def save(self, path: Path) -> None:
        """Write an npz file, whole or not at all; equal meshes give equal files."""
        with whole(Path(path)) as unfinished, open(unfinished, "wb") as file:
            np.savez_compressed(file, **asdict(self), digest=self.digest)

    @classmethod
    def load(
        cls, path: Path, surface: str | None = None, vertices: int | None = None
    ) -> "SurfaceMesh":
        """Read what `save` wrote; given a surface and a number of vertices, it must be that mesh.

        Raises
        ------
        ValueError
            Naming the file, if it is damaged, its digest is not that of its arrays, or it is
            another mesh.
        """
        content = io.BytesIO(Path(path).read_bytes())
        try:
            with np.load(content, allow_pickle=False) as data:
                digest = str(data["digest"])
                mesh = cls(
                    surface=str(data["surface"]),
                    vertices=data["vertices"].astype(np.float64),
                    triangles=data["triangles"].astype(np.int64),
                    seed=int(data["seed"]),
                    radius_ratio=float(data["radius_ratio"]),
                    curved_quality=float(data["curved_quality"]),
                    min_angle=float(data["min_angle"]),
                )
        except (ValueError, LookupError, EOFError, RuntimeError, BadZipFile, zlib.error) as error:
            raise ValueError(f"{path}: not a complete mesh file: {error}") from error
        if mesh.digest != digest:
            raise ValueError(f"{path}: digest is {mesh.digest}, the file says {digest}")
        found = (mesh.surface, len(mesh.vertices))
        if found != (surface or found[0], vertices or found[1]):
            raise ValueError(
                f"{path}: is {found[0]} with V = {found[1]}, not {surface}, {vertices}"
            )
        return mesh


def measured(surface: str, vertices: Array, triangles: Integers, seed: int) -> SurfaceMesh:
    """The SurfaceMesh of given vertices (V, 3) and triangles (E, 3), its quality measured."""
    exact = mesh_surface(surface)
    curved = (curved_qualities(exact, vertices, triangles, k).min() for k in CURVED_DEGREES)
    return SurfaceMesh(
        surface=surface,
        vertices=vertices,
        triangles=triangles,
        seed=seed,
        radius_ratio=float(radius_ratios(vertices, triangles).min()),
        curved_quality=float(min(curved)),
        min_angle=float(angles(vertices, triangles).min()),
    )
