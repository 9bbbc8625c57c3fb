"""A user's own triangulation: read through trimesh, and refused unless it is a closed surface.

Nothing is repaired; but vertices at the very same place are one (STL knows no other way to say
so), and vertices of no face are left out.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from esfem.common.bad_input import BadInput
from esfem.common.files import reading
from esfem.meshes.soundness import crossing_pairs, enclosed_volume, point, segments_meet
from esfem.solver.mesh import Integers
from esfem.solver.reference_element import Array

FORMATS = (".stl", ".ply", ".obj")
LEAST_ALTITUDE = 1e-6  # of a face, relative to its longest side
LARGEST = 1e6  # coordinates


def read_triangulation(path: Path) -> tuple[Array, Integers]:
    """Vertices (V, 3) and faces (E, 3) of a file, checked.

    Raises
    ------
    BadInput
        Naming the file, what is wrong with it, where, and what is allowed.
    """
    if path.suffix.lower() not in FORMATS:
        raise BadInput(f"{path}: the ending must be one of {', '.join(FORMATS)}")
    vertices, faces = _loaded(path)
    try:
        return check_surface(*merged(vertices, faces))
    except ValueError as error:
        raise BadInput(f"{path}: {error}") from error


def _loaded(path: Path) -> tuple[Array, Integers]:
    import trimesh  # slow to load

    with reading(path), open(path, "rb"):
        pass
    try:
        mesh = trimesh.load_mesh(path, process=False)
        return np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
    except Exception as error:  # the readers of trimesh raise whatever happens to them
        raise BadInput(f"{path}: no triangulation can be read from it: {error}") from error


def merged(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """Vertices at the same place made one, and those of no face left out."""
    if len(faces) == 0:
        raise ValueError("has no faces")
    if not np.isfinite(vertices).all():
        raise ValueError("a coordinate is not a finite number")
    if np.abs(vertices).max() > LARGEST:
        raise ValueError(f"a coordinate exceeds {LARGEST:g}")
    places, faces = np.unique(vertices[faces].reshape(-1, 3), axis=0, return_inverse=True)
    return places, faces.reshape(-1, 3)


def check_surface(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """The same vertices and faces, if they are one closed oriented surface.

    Raises
    ------
    ValueError
        Saying what is wrong, how often, and at which face first.
    """

    def refuse(faulty: NDArray[np.bool_], what: str, allowed: str) -> None:
        if faulty.any():
            e = int(np.argmax(faulty))
            where = point(vertices[faces[e]].mean(axis=0))
            count = f"{int(faulty.sum())} of {len(faces)} faces"
            raise ValueError(f"{what}: {count}, first face {e} at {where}; {allowed}")

    refuse(degenerate(vertices, faces), "degenerate faces", "each must have an area")
    check_edges(faces, refuse)
    check_vertex_fans(faces, refuse)
    check_one_piece(faces, refuse)
    if enclosed_volume(vertices, faces) <= 0:
        raise ValueError("faces are seen from inside: all must be counter-clockwise from outside")
    crossing = np.zeros(len(faces), dtype=bool)
    for pairs in (crossing_pairs(vertices, faces), corner_crossings(vertices, faces)):
        crossing[pairs.ravel()] = True
    refuse(crossing, "self-intersecting faces", "no face may meet another one but at a common side")
    return vertices, faces


def degenerate(vertices: Array, faces: Integers) -> NDArray[np.bool_]:
    """Whether each face has two equal corners, or nearly no height over its longest side."""
    corners = vertices[faces]
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return area <= LEAST_ALTITUDE * longest**2


def check_edges(faces: Integers, refuse: Callable[..., None]) -> None:
    """Each side belongs to two faces, which run along it in opposite directions."""
    directed = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    key = directed.min(axis=1) * (faces.max() + 1) + directed.max(axis=1)
    _, edge, count = np.unique(key, return_inverse=True, return_counts=True)
    count = count[edge].reshape(-1, 3)
    refuse((count == 1).any(axis=1), "not closed", "each side must have a face on both sides")
    refuse((count > 2).any(axis=1), "not manifold", "each side must belong to two faces")
    forward = np.bincount(edge, directed[:, 0] < directed[:, 1])
    twice = (forward[edge] != 1.0).reshape(-1, 3).any(axis=1)
    refuse(twice, "not oriented", "two faces must run along their common side in opposite senses")


def check_vertex_fans(faces: Integers, refuse: Callable[..., None]) -> None:
    """The faces around a vertex form one ring: walk around it, and count."""
    E = len(faces)
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    size = faces.max() + 1
    # The half-edge h = 3 e + i leaves corner i; the next one around that corner is the twin of
    # the half-edge before h in its face.
    order = np.argsort(start * size + end)
    twin = order[np.searchsorted((start * size + end)[order], end * size + start)]
    h = np.arange(3 * E)
    around = twin[3 * (h // 3) + (h % 3 + 2) % 3]
    ring, lowest = h.copy(), h.copy()
    for _ in range(int(np.bincount(start).max())):
        ring = around[ring]
        lowest = np.minimum(lowest, ring)
    rings = np.bincount(start[np.unique(lowest)], minlength=size)
    pinched = (rings[faces] > 1).any(axis=1)
    refuse(pinched, "not manifold at a vertex", "the faces around a vertex must form one ring")


def check_one_piece(faces: Integers, refuse: Callable[..., None]) -> None:
    """All faces hang together."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    start, end, size = faces.ravel(), faces[:, [1, 2, 0]].ravel(), faces.max() + 1
    graph = coo_array((np.ones(len(start)), (start, end)), shape=(size, size))
    pieces, piece = connected_components(graph, directed=False)
    refuse(piece[faces[:, 0]] != piece[faces[0, 0]], f"{pieces} pieces", "must be one surface")


def corner_crossings(vertices: Array, faces: Integers) -> Integers:
    """Pairs (m, 2) of faces with one common corner that meet elsewhere, too.

    Then the side of one of them opposite to that corner meets the other.
    """
    from scipy.sparse import csr_array

    E = len(faces)
    rows = np.repeat(np.arange(E), 3)
    incidence = csr_array((np.ones(3 * E), (rows, faces.ravel())))
    common = (incidence @ incidence.T).tocoo()
    one = common.data == 1.0
    first, second = common.coords[0][one], common.coords[1][one]
    shared = (faces[first][:, :, None] == faces[second][:, None, :]).any(axis=2).argmax(axis=1)
    p, q = (vertices[faces[first, (shared + s) % 3]] for s in (1, 2))
    meet = segments_meet(p, q, vertices[faces[second]])
    return np.stack([first, second], axis=1)[meet]
