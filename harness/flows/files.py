"""All files that are made from the frames of a flow: for ParaView, and pictures."""

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from rich.console import Console

from harness.bad_input import BadInput
from harness.flows.evolution import Outcome
from harness.flows.flow_file import FlowFile
from harness.flows.frames import frames
from harness.flows.history import History
from harness.flows.pictures import save_energy, save_surfaces
from harness.flows.start import Start

INSTALL = "pip install 'esfem-willmore[pictures]'"
OPTIONAL = ("h5py", "vtk", "pyvista")


def check_libraries() -> None:
    """BadInput if a library is installed, but broken: better known before the flow than after."""
    for name in filter(find_spec, OPTIONAL):
        try:
            import_module(name)
        except (ImportError, OSError) as error:
            why = " ".join(str(error).split())
            raise BadInput(
                f"{name}: is installed, but cannot be imported: {why}; --no-pictures needs none"
            ) from error


def write_files(
    flow: FlowFile,
    start: Start,
    outcome: Outcome,
    history: History,
    folder: Path,
    console: Console,
) -> None:
    """Write NAME.vtkhdf, NAME.pvd with its .vtu files, surfaces.png, energy.svg and energy.pdf."""
    mesh, levels = start.mesh, outcome.framed
    if find_spec("h5py"):
        from harness.flows.vtkhdf import write_vtkhdf

        write_vtkhdf(folder / f"{flow.name}.vtkhdf", mesh, frames(folder, levels))
    if find_spec("vtkmodules"):
        from harness.flows.vtu import write_pvd

        write_pvd(folder / f"{flow.name}.pvd", mesh, frames(folder, levels))
    missing = [name for name in OPTIONAL if not find_spec(name)]
    if missing:
        told = "no files for ParaView" if "pyvista" not in missing else "pictures by matplotlib"
        console.print(f"without {', '.join(missing)}: {told}; {INSTALL}", soft_wrap=True)
    # Of a flow that stopped, the last State is shown too: where and how is the point.
    last = [] if outcome.status == "ok" else levels[-1:]
    pictured = sorted({n for n in flow.pictured if n in levels} | {*last})
    save_surfaces(folder, mesh, list(frames(folder, pictured)), flow.flow.title)
    save_energy(folder, flow, history)
