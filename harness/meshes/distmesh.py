"""A surface DistMesh with a prescribed number of vertices, unstructured, of right topology.

Seeded points, spread by Lloyd sweeps in a dense cloud; connectivity from the parameter domain;
then springs that only push, tangential moves, projection, Delaunay flips. Letters: p parameters,
x and nu (V, 3) vertices and exact normals there.

References
----------
Persson, Strang, A simple mesh generator in MATLAB, SIAM Review 46 (2004).
"""

from collections.abc import Callable, Iterable

import numpy as np
from scipy.spatial import cKDTree

from esfem.meshes.flips import LEAST_COSINE, Edges, edges_of, flip_to_delaunay, fold_cosines
from esfem.meshes.parameters import area_elements, connect, parameter_cloud
from esfem.meshes.soundness import check_embedding, check_mesh
from esfem.meshes.surfaces import MESH_SURFACES, MeshSurface, check_vertices, mesh_surface
from esfem.meshes.triangulation import MeshQualityError, SurfaceMesh, measured
from esfem.solver.mesh import Integers, triangulation
from esfem.solver.reference_element import Array

CLOUD_POINTS_PER_VERTEX = 60
LEAST_CLOUD = 20_000
LLOYD_SWEEPS = 15
RELAX_STEPS = 300
MOVE_TOLERANCE = 1e-3  # of the shortest incident edge
OVERLENGTH = 1.2  # wished over actual mean length: the springs push
STEP = 0.2
MOMENTUM = 0.85
MOVE_CAP = 0.25  # of the shortest incident edge
FLIP_EACH_STEP_UNTIL, THEN_FLIP_EVERY = 20, 4


def sum_by_index(index: Integers, vectors: Array, count: int) -> Array:
    """Sums of the vectors (N, 3) that have the same index (N,), shape (count, 3)."""
    return np.stack([np.bincount(index, column, minlength=count) for column in vectors.T], axis=1)


def spread_points(surface: MeshSurface, vertices: int, rng: np.random.Generator) -> Array:
    """Parameters of V points of density about 1/size^2: drawn from a cloud, then Lloyd sweeps."""
    count = max(CLOUD_POINTS_PER_VERTEX * vertices, LEAST_CLOUD)
    p = parameter_cloud(surface, count, rng)
    y = surface.embed(p)
    area, size = area_elements(surface, p), surface.size(y)
    density = area / size**2
    x = y[rng.choice(count, vertices, replace=False, p=density / density.sum())]
    weight = area / size**4
    for _ in range(LLOYD_SWEEPS):
        site = np.asarray(cKDTree(x).query(y)[1])
        mass = np.bincount(site, weight, minlength=vertices)
        moment = sum_by_index(site, weight[:, None] * y, vertices)
        occupied = mass > 0
        x[occupied] = surface.project(moment[occupied] / mass[occupied, None])
    _, nearest = cKDTree(y).query(x)
    return p[nearest]


def check_topology(surface: MeshSurface, triangles: Integers, vertices: int) -> None:
    """Raise MeshQualityError unless closed, without double edges, of V vertices and right genus."""
    try:
        triangulation(triangles)
    except ValueError as error:
        raise MeshQualityError(f"first connectivity: {error}") from error
    expected = 2 * (vertices - surface.euler_characteristic)
    if len(triangles) != expected:
        raise MeshQualityError(
            f"first connectivity: {len(triangles)} triangles, must be {expected}"
        )


def push(surface: MeshSurface, x: Array, edges: Edges) -> tuple[Array, Array]:
    """Sum of the forces max(L0 - L, 0) at each vertex (V, 3), and its shortest edge (V,)."""
    bar = x[edges.a] - x[edges.b]
    L = np.linalg.norm(bar, axis=1)
    size = surface.size(surface.project((x[edges.a] + x[edges.b]) / 2))
    L0 = OVERLENGTH * size * np.sqrt((L**2).sum() / (size**2).sum())
    F = (np.maximum(L0 - L, 0.0) / L)[:, None] * bar
    ends = np.concatenate([edges.a, edges.b])
    force = sum_by_index(ends, np.concatenate([F, -F]), len(x))
    shortest = np.full(len(x), np.inf)
    np.minimum.at(shortest, ends, np.concatenate([L, L]))
    return force, shortest


def guarded_move(
    surface: MeshSurface, x: Array, nu: Array, triangles: Integers, move: Array
) -> tuple[Array, Array]:
    """Moved and projected vertices, their normals; where a triangle folds, moves shrink to 0."""
    floor = np.minimum(LEAST_COSINE, fold_cosines(x, nu, triangles))
    factor = np.ones(len(x))
    while True:
        still = factor < 0.1
        y = np.where(still[:, None], x, surface.project(x + factor[:, None] * move))
        normals = np.where(still[:, None], nu, surface.normal(y))
        folded = fold_cosines(y, normals, triangles) < floor
        folded &= ~still[triangles].all(axis=1)  # nothing left to shrink
        if not folded.any():
            return y, normals
        factor[np.unique(triangles[folded])] *= 0.5


def relax(surface: MeshSurface, x: Array, triangles: Integers) -> tuple[Array, Integers]:
    """Springs and flips until the largest move is 1e-3 of the local edge, or 300 steps."""
    nu = surface.normal(x)
    velocity = np.zeros_like(x)
    for step in range(RELAX_STEPS):
        if step < FLIP_EACH_STEP_UNTIL or step % THEN_FLIP_EVERY == 0:
            triangles = flip_to_delaunay(x, nu, triangles)
            edges = edges_of(triangles)
        force, shortest = push(surface, x, edges)
        move = MOMENTUM * velocity + STEP * force
        move -= np.einsum("va,va->v", move, nu)[:, None] * nu
        length = np.maximum(np.linalg.norm(move, axis=1), np.finfo(float).tiny)
        move *= np.minimum(1.0, MOVE_CAP * shortest / length)[:, None]
        moved, nu = guarded_move(surface, x, nu, triangles, move)
        velocity, x = moved - x, moved
        if (np.linalg.norm(velocity, axis=1) < MOVE_TOLERANCE * shortest).all():
            break
    return x, flip_to_delaunay(x, nu, triangles)


def generate_seed(surface: str, vertices: int, seed: int) -> SurfaceMesh:
    """The mesh of one seed, whatever its quality; MeshQualityError if its topology is wrong.

    Meshes of surfaces other than `MESH_SURFACES` must pass `check_mesh`, too.
    """
    exact = mesh_surface(surface)
    p = spread_points(exact, vertices, np.random.default_rng(seed))
    x, triangles = exact.embed(p), connect(exact, p)
    check_topology(exact, triangles, vertices)  # flips keep it
    x, triangles = relax(exact, x, triangles)
    if surface not in MESH_SURFACES:
        check_mesh(exact, x, triangles)
    return measured(surface, x, triangles, seed)


def generate(
    surface: str,
    vertices: int,
    seeds: Iterable[int] = range(8),
    progress: Callable[[str], None] | None = None,
) -> SurfaceMesh:
    """The best mesh of several seeds, by the least of radius ratio and curved quality.

    Parameters
    ----------
    surface : key of `MESH_SURFACES`, or a surface of `esfem.reference_solutions.surfaces`.
    vertices : the number V that the mesh will have.
    seeds : of numpy's default generator; a seed decides its mesh.
    progress : called with one line a seed.

    Raises
    ------
    ValueError
        If the surface is unknown, or ``vertices`` is no integer or below ``minimum_vertices``.
    MeshQualityError
        If no seed gives q > 0.6, angles > 30 degrees and positive curved elements; or a named
        surface is no smooth closed surface, its normals point inward, or its meshes of so many
        vertices cross themselves, fold or leave it.
    """
    check_vertices(surface, vertices)
    if surface not in MESH_SURFACES:
        try:
            check_embedding(mesh_surface(surface))
        except MeshQualityError as error:
            raise MeshQualityError(f"no mesh of {surface}, V = {vertices}: {error}") from error
    passed, failures = [], []
    for seed in seeds:
        try:
            mesh = generate_seed(surface, vertices, seed)
            mesh.check_quality()
            passed.append(mesh)
            line = f"quality {mesh.quality:.3f}, least angle {mesh.min_angle:.1f} degrees"
        except ValueError as error:  # of quality, or a point that has no projection
            line = str(error)
            failures.append(line)
        if progress is not None:
            progress(f"mesh of {surface}, V = {vertices}, seed {seed}: {line}")
    if not passed:
        reasons = "; ".join(dict.fromkeys(failures))
        raise MeshQualityError(f"no good mesh of {surface}, V = {vertices}: {reasons}")
    return max(passed, key=lambda mesh: mesh.quality)
