"""Unstructured triangulations of exact surfaces with a prescribed number of vertices."""

from esfem.meshes.distmesh import generate
from esfem.meshes.library import (
    committed_mesh_path,
    committed_sizes,
    mesh_in,
    meshes_of,
    surface_mesh,
)
from esfem.meshes.surfaces import MESH_SURFACES, MeshSurface, check_vertices, mesh_surface
from esfem.meshes.triangulation import MeshQualityError, SurfaceMesh

__all__ = [
    "MESH_SURFACES",
    "MeshQualityError",
    "MeshSurface",
    "SurfaceMesh",
    "check_vertices",
    "committed_mesh_path",
    "committed_sizes",
    "generate",
    "mesh_in",
    "mesh_surface",
    "meshes_of",
    "surface_mesh",
]
