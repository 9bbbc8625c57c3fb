"""`esfem mesh`: make a triangulation, tell its quality, write it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from esfem.common.bad_input import BadInput
from esfem.common.console import plain_console
from esfem.common.files import whole, writing

if TYPE_CHECKING:
    from esfem.meshes import SurfaceMesh

MESH_FORMATS = (".npz", ".ply", ".obj", ".stl", ".off")


def mesh(
    surface: Annotated[
        str, typer.Argument(metavar="SURFACE", help="Name of a surface; `esfem list` tells them.")
    ],
    vertices: Annotated[int, typer.Option(help="Number of vertices.")],
    out: Annotated[
        Path | None, typer.Option(help="File to write: .npz, or .ply, .obj, .stl, .off.")
    ] = None,
) -> None:
    """Generate a triangulation of V vertices, or fetch the committed one, and tell its quality.

    Example: `esfem mesh clifford_torus --vertices 500 --out torus.ply`
    """
    from esfem.meshes import surface_mesh

    console = plain_console()
    if out is not None and out.suffix.lower() not in MESH_FORMATS:
        raise BadInput(f"--out {out}: the ending must be one of {', '.join(MESH_FORMATS)}")
    try:
        result = surface_mesh(surface, vertices, progress=console.print)
    except ValueError as error:
        raise BadInput(str(error)) from error
    console.print(
        f"{surface}: V = {len(result.vertices)}, {len(result.triangles)} triangles, "
        f"seed {result.seed}, radius ratio {result.radius_ratio:.3f}, "
        f"curved-element quality {result.curved_quality:.3f}, "
        f"least angle {result.min_angle:.1f} degrees",
    )
    if out is not None:
        _write_mesh(result, out)
        console.print(f"written to {out}", soft_wrap=True)


def _write_mesh(mesh: "SurfaceMesh", out: Path) -> None:
    """Write the mesh whole or not at all, in the format that the ending tells."""
    ending = out.suffix.lower()
    with writing(f"--out {out}"):
        if ending == ".npz":
            return mesh.save(out)
        import trimesh  # slow to load, and needed for this alone

        drawn = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
        with whole(out) as unfinished:
            drawn.export(unfinished, file_type=ending.removeprefix("."))
