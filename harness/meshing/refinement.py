"""Regular refinement: fine meshes in a second, where relaxing springs would take minutes."""

from harness.meshing.stored_mesh import SurfaceMesh, committed_sizes, measured
from harness.meshing.surfaces import mesh_surface
from solver.mesh import elevate

LEAST_REFINED = 5000  # vertices; the generator makes smaller meshes within a minute
CHILDREN = ((0, 5, 4), (5, 1, 3), (4, 3, 2), (3, 4, 5))  # of a P2 element, in its nodes


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
