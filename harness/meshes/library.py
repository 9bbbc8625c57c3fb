"""The triangulation of a surface with V vertices: stored, refined, or generated.

Stored meshes are the files ``harness/meshes/<surface>/V00030.npz``. Finer ones than `LEAST_REFINED`
are refined regularly, in a second, where relaxing springs would take minutes.
"""

import os
from collections.abc import Callable, Iterable
from pathlib import Path

from esfem.common.bad_input import BadInput
from esfem.common.files import writing
from esfem.meshes.distmesh import generate
from esfem.meshes.soundness import check_on_surface
from esfem.meshes.surfaces import MESH_SURFACES, check_vertices, mesh_surface
from esfem.meshes.triangulation import MeshQualityError, SurfaceMesh, measured
from esfem.solver.mesh import elevate

MESH_DIRECTORY = Path(__file__).parent
LEAST_REFINED = 5000  # vertices; the generator makes smaller meshes within a minute
CHILDREN = ((0, 5, 4), (5, 1, 3), (4, 3, 2), (3, 4, 5))  # of a P2 element, in its nodes


def check_meshes(surface: str, sizes: Iterable[int]) -> None:
    """Raise ValueError unless there is a mesh of each size, or one can be generated."""
    for vertices in sizes:
        check_vertices(surface, vertices)


def meshes_of(
    surface: str, sizes: Iterable[int], cache: Path, say: Callable[[str], None]
) -> dict[int, SurfaceMesh]:
    """The triangulations by their numbers of vertices, each as `mesh_in` has it."""
    return {vertices: mesh_in(surface, vertices, cache, say) for vertices in sizes}


def mesh_in(surface: str, vertices: int, cache: Path, say: Callable[[str], None]) -> SurfaceMesh:
    """The triangulation of so many vertices: committed, else from ``cache``, else made and kept.

    Raises
    ------
    BadInput
        If there is none, or it cannot be kept.
    """
    path = cache / surface / f"V{vertices:05d}.npz"
    committed = committed_mesh_path(surface, vertices).exists()
    with writing(path):
        if not committed and path.exists():
            try:
                return SurfaceMesh.load(path, surface, vertices)
            except ValueError as error:
                os.replace(path, path.with_suffix(".npz.damaged"))
                say(f"{error}; set aside, will be generated again")
        try:
            mesh = surface_mesh(surface, vertices, say)
        except ValueError as error:
            raise BadInput(f"mesh of {surface}, V = {vertices}: {error}") from error
        if not committed:
            mesh.save(path)
        return mesh


def surface_mesh(
    surface: str, vertices: int, progress: Callable[[str], None] | None = None
) -> SurfaceMesh:
    """The stored mesh of so many vertices, else a refinement of one, else from `generate`.

    Raises
    ------
    ValueError
        Also if the file of a named surface was changed since its mesh was stored.
    """
    path = committed_mesh_path(surface, vertices)
    if not path.exists():
        coarser = coarser_size(surface, vertices)
        if coarser is not None:
            return refined(surface_mesh(surface, coarser, progress))
        return generate(surface, vertices, progress=progress)
    mesh = SurfaceMesh.load(path, surface, vertices)
    if surface not in MESH_SURFACES:
        try:
            check_on_surface(mesh_surface(surface), mesh.vertices)
        except MeshQualityError as error:
            raise MeshQualityError(f"{path}: is no mesh of this {surface}: {error}") from error
    return mesh


def committed_mesh_path(surface: str, vertices: int) -> Path:
    """Where the stored mesh of so many vertices is, if there is one."""
    check_vertices(surface, vertices)
    return MESH_DIRECTORY / surface / f"V{vertices:05d}.npz"


def committed_sizes(surface: str) -> tuple[int, ...]:
    """The numbers of vertices of the stored meshes, ascending."""
    files = (MESH_DIRECTORY / mesh_surface(surface).name).glob("V*.npz")
    return tuple(sorted(int(file.stem[1:]) for file in files))


def coarser_size(surface: str, vertices: int) -> int | None:
    """The size whose refinement, once or more, ends at so many vertices; None if none does.

    A closed triangulation of Euler characteristic chi has 3 (V - chi) edges, and its refinement
    4 V - 3 chi vertices.  The coarsest one must be committed.
    """
    if vertices < LEAST_REFINED:
        return None
    chi = mesh_surface(surface).euler_characteristic
    coarser, rest = divmod(vertices + 3 * chi, 4)
    if rest:
        return None
    known = coarser in committed_sizes(surface)
    return coarser if known or coarser_size(surface, coarser) is not None else None


def refined(mesh: SurfaceMesh) -> SurfaceMesh:
    """Each triangle cut into four; the midpoints of the edges are moved to the surface.

    Raises
    ------
    MeshQualityError
        If the finer mesh misses the gate, which the surface may make it do where it is curved.
    """
    project = mesh_surface(mesh.surface).project
    fine, x = elevate(mesh.triangles, mesh.vertices, 2, project)
    triangles = fine.cells[:, CHILDREN].reshape(-1, 3)
    found = measured(mesh.surface, x, triangles, mesh.seed)
    found.check_quality()
    return found
