"""Unstructured triangulations of exact surfaces with a prescribed number of vertices."""

from harness.meshing.distmesh import generate
from harness.meshing.library import committed_mesh_path, committed_sizes, surface_mesh
from harness.meshing.stored_mesh import MeshQualityError, SurfaceMesh
from harness.meshing.surfaces import MESH_SURFACES, MeshSurface, check_vertices, mesh_surface

__all__ = [
    "MESH_SURFACES",
    "MeshQualityError",
    "MeshSurface",
    "SurfaceMesh",
    "check_vertices",
    "committed_mesh_path",
    "committed_sizes",
    "generate",
    "mesh_surface",
    "surface_mesh",
]
