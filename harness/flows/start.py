"""Where a flow starts: the P_k mesh and the nodal x, nu, H, V, z at t = 0."""

from pathlib import Path

from rich.console import Console

from esfem.common.bad_input import BadInput
from esfem.flows.estimated_start import Start, estimated_start
from esfem.flows.flow_file import FlowFile
from esfem.meshes.library import mesh_in
from esfem.reference_solutions import SurfaceFlow
from esfem.runs.problem import initial_state
from esfem.runs.run_case import computational_mesh
from esfem.schemes.kll import scheme_of
from esfem.solver import Diverged
from esfem.solver.flow import Guard
from esfem.solver.laws import velocity_law


def start_of(flow: FlowFile, base: Path, cache: Path, console: Console) -> Start:
    """The start that a flow file asks for.

    Parameters
    ----------
    flow : the flow file.
    base : folder of the flow file, from which the path of a mesh counts.
    cache : folder of generated meshes.
    console : is told about meshes that are generated.

    Raises
    ------
    BadInput
        If there is no such mesh, or it is no closed surface, or no flow can start from it.
    """
    if flow.start.mesh is not None:
        start = estimated_start(flow, base / flow.start.mesh, console)
    else:
        start = exact_start(flow, cache, console)
    check_start(flow, start)
    return start


def check_start(flow: FlowFile, start: Start) -> None:
    """BadInput if the flow would end before its first step, without a time level to tell of."""
    scheme = scheme_of(flow.scheme, velocity_law(flow.law.name, **flow.law.parameters))
    try:
        Guard(start.mesh, start.state, scheme)
    except Diverged as stop:
        raise BadInput(
            f"[start] no flow can start there: {stop.reason}; take more vertices"
        ) from stop


def exact_start(flow: FlowFile, cache: Path, console: Console) -> Start:
    """The start on a named surface: all data are exact in the nodes."""
    solution = SurfaceFlow(flow.start.surface)
    try:
        surface = mesh_in(flow.start.surface, flow.start.vertices, cache, console.print)
    except ValueError as error:
        raise BadInput(f"[start] {error}") from error
    mesh, x = computational_mesh(surface, solution, flow.scheme.degree)
    return Start(mesh, initial_state(flow.law, x, solution), surface.digest, estimated=False)
