"""Where a flow starts: the P_k mesh and the nodal x, nu, H, V, z at t = 0.

On a named surface all data are exact. On a user's triangulation they come from local fits, blended:
a node with barycentric coordinates l_1, l_2, l_3 in its triangle is the mean, with these weights,
of its lifts onto the jets of the three corners (`esfem.flows.osculating_jets`); nu and H are the
means of those of the three graphs. V and z are what the scheme makes of x, nu and H. On an edge two
jets count, from both sides the same. The vertices stay where they are.
"""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console

from esfem.common.bad_input import BadInput
from esfem.flows.flow_file import FlowFile
from esfem.flows.osculating_jets import Jets, fit_jets
from esfem.meshes.library import mesh_in
from esfem.meshes.soundness import point
from esfem.meshes.user_mesh import read_triangulation
from esfem.reference_solutions.calculus.curvature import normal_and_shape
from esfem.runs.problem import initial_state
from esfem.runs.run_case import computational_mesh
from esfem.schemes.kll import scheme_of
from esfem.solver import Diverged, Mesh, State, triangulation
from esfem.solver.flow import Guard
from esfem.solver.geometry import geometry, interpolate
from esfem.solver.laws import velocity_law
from esfem.solver.mesh import Integers
from esfem.solver.reference_element import Array, lattice, tabulate
from esfem.solver.scheme import consistent_w, unit


@dataclass(frozen=True)
class Start:
    """The P_k mesh, the State at t = 0 in its nodes, and a hash of where both come from.

    ``estimated`` tells that nu, H, V and z are no data of a smooth surface but estimates from a
    triangulation, so that no order of convergence can be claimed.
    """

    mesh: Mesh
    state: State
    digest: str
    estimated: bool


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
    solution, vertices = flow.solution, flow.start.vertices
    assert vertices is not None  # as of every named surface
    try:
        surface = mesh_in(solution.surface, vertices, cache, console.print)
    except ValueError as error:
        raise BadInput(f"[start] {error}") from error
    mesh, x = computational_mesh(surface, solution, flow.scheme.degree)
    return Start(mesh, initial_state(flow.law, x, solution), surface.digest, estimated=False)


def estimated_start(flow: FlowFile, path: Path, console: Console) -> Start:
    """The start that the file of a triangulation gives.

    Raises
    ------
    BadInput
        If the file is no closed oriented surface, or too coarse to estimate its curvature.
    """
    vertices, faces = read_triangulation(path)
    vertices = flow.start.scale * vertices
    try:
        mesh, state = estimated_state(vertices, faces, flow)
    except ValueError as error:
        raise BadInput(f"{path}: {error}") from error
    console.print(
        f"{path.name}: V = {len(vertices)}, {len(faces)} faces, Euler characteristic "
        f"{mesh.euler_characteristic}; nu, H, z and V are estimated by local fits, "
        "so that no order claim applies",
        soft_wrap=True,
    )
    content = np.ascontiguousarray(vertices).tobytes() + np.ascontiguousarray(faces).tobytes()
    return Start(mesh, state, hashlib.sha256(content).hexdigest(), estimated=True)


def estimated_state(vertices: Array, faces: Integers, flow: FlowFile) -> tuple[Mesh, State]:
    """The P_k mesh over a triangulation, and the State at t = 0.

    x, nu and H are estimates; V and z are those that the scheme makes of them (`consistent_w`). As
    functions these are rough, but they fit the equations: from estimates of V and z the first
    extrapolated step would jump.
    """
    jets = fit_jets(vertices, faces)
    mesh, x, weights = raised(vertices, faces, jets, flow.scheme.degree)
    nu, H = blended_fields(jets, x, *weights)
    state = State(0.0, x, unit(nu), H, np.zeros_like(H), np.zeros_like(x))
    check_elements(mesh, state)
    law = velocity_law(flow.law.name, **flow.law.parameters)
    w = consistent_w(mesh, state, scheme_of(flow.scheme, law))
    return mesh, replace(state, V=w[:, 0], z=w[:, 1:])


def raised(
    vertices: Array, faces: Integers, jets: Jets, degree: int
) -> tuple[Mesh, Array, tuple[Integers, Array]]:
    """The P_k mesh, its nodes (N, 3), and of each the jets (N, 3) and weights (N, 3) it is made of.

    Raised one degree at a time, as `esfem.solver.mesh.elevate` does, for the same reason.
    """
    mesh, x = triangulation(faces), vertices
    for k in range(1, degree + 1):
        finer = triangulation(faces, k)
        corners, weights = barycentric(finer)
        phi, _ = tabulate(mesh.degree, lattice(k))
        nodes = np.empty((finer.node_count, 3))
        nodes[finer.cells] = phi @ x[mesh.cells]
        mesh, x = finer, blend([jets.lifted(at, nodes) for at in corners.T], weights)
    return mesh, x, (corners, weights)


def barycentric(mesh: Mesh) -> tuple[Integers, Array]:
    """Of each node the corners (N, 3) of a triangle that holds it, and its coordinates (N, 3)."""
    reference = lattice(mesh.degree)
    coordinates = np.column_stack([1.0 - reference.sum(axis=1), reference])
    corners = np.empty((mesh.node_count, 3), dtype=np.int64)
    weights = np.empty((mesh.node_count, 3))
    for i, node in enumerate(mesh.cells.T):
        corners[node], weights[node] = mesh.triangles, coordinates[i]
    return corners, weights


def blend(parts: list[Array], weights: Array) -> Array:
    """sum_i weights_i parts_i, nodewise, of parts (N,) or (N, 3)."""
    return sum(
        w.reshape(-1, *[1] * (p.ndim - 1)) * p for p, w in zip(parts, weights.T, strict=True)
    )


def blended_fields(jets: Jets, x: Array, corners: Integers, weights: Array) -> tuple[Array, Array]:
    """nu (N, 3), not of unit length, and H (N,) in nodes x."""
    nu, H = zip(*(graph_fields(jets, at, x) for at in corners.T), strict=True)
    return blend(list(nu), weights), blend(list(H), weights)


def graph_fields(jets: Jets, at: Integers, x: Array) -> tuple[Array, Array]:
    """The same of the graphs of the jets ``at`` (N,), as level sets height - f(a, b) = 0."""
    y = jets.local(at, x)
    f = jets.derivatives(at, y[:, 0], y[:, 1], 2)
    nu, S = normal_and_shape(height_derivatives(f, 1), height_derivatives(f, 2))
    return np.einsum("pra,rp->pa", jets.frame[at], nu), np.einsum("aap->p", S)


def height_derivatives(f: Array, order: int) -> Array:
    """All derivatives of that order of height - f(a, b), (3, ..., 3, N)."""
    result = np.zeros((3,) * order + f.shape[2:])
    for index in np.ndindex(*(2,) * order):
        ones = sum(index)
        result[index] = -f[order - ones, ones]
    if order == 1:
        result[2] = 1.0
    return result


def check_elements(mesh: Mesh, state: State) -> None:
    """ValueError unless all curved elements look to the side of nu_h."""
    geo = geometry(mesh, state.x)
    along = np.einsum("epa,epa->ep", geo.normal, interpolate(geo, state.nu)).min(axis=1)
    if not along.min() > 0:
        e = int(np.argmin(along))
        where = point(state.x[mesh.triangles[e]].mean(axis=0))
        raise ValueError(
            f"too coarse: the curved element over face {e} at {where} is folded; "
            "refine the triangulation there, or take a lower degree"
        )
