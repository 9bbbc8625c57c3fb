"""A user's own triangulation: what is refused, why, and how well nu, H, z, Lap H are estimated."""

import numpy as np
import pytest
import trimesh
from studies import SMALL_FLOW, write_varied

from esfem.common.bad_input import BadInput
from esfem.flows.flow_file import load_flow
from esfem.flows.osculating_jets import fit_jets
from esfem.flows.start import blended_fields, estimated_state, raised
from esfem.meshes import surface_mesh
from esfem.meshes.user_mesh import corner_crossings, read_triangulation
from esfem.reference_solutions import CliffordTorus, StationarySphere
from esfem.solver import BDF, Levels, Scheme, evolve
from esfem.solver.functionals import area, volume, willmore_energy
from esfem.solver.geometry import geometry
from esfem.solver.scheme import correction

OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
FACES = np.array(
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
)


def written(folder, vertices, faces, ending=".ply"):
    path = folder / f"surface{ending}"
    trimesh.Trimesh(vertices, faces, process=False).export(path)
    return path


def two(vertices, faces, shift):
    """Two copies of a surface, one moved."""
    return np.vstack([vertices, vertices + shift]), np.vstack([faces, faces + len(vertices)])


def pinched():
    """Two octahedra that share their lowest and highest corner."""
    vertices, faces = two(OCTAHEDRON, FACES, [0.0, 0.0, 2.0])
    return vertices, np.where(faces == 11, 4, faces)


def crossing():
    """A torus whose outer side is folded into its own tube and out of it on the other side."""
    mesh = surface_mesh("clifford_torus", 240)
    x = mesh.vertices.copy()
    x[:, 0] = np.where(x[:, 0] > 1.2, 1.2 - 4.0 * (x[:, 0] - 1.2), x[:, 0])
    return x, mesh.triangles


FINDINGS = {
    "a hole": ((OCTAHEDRON, FACES[:-1]), "not closed: 3 of 7 faces"),
    "one face reversed": (
        (OCTAHEDRON, np.vstack([FACES[:-1], FACES[-1:, ::-1]])),
        "not oriented: 4 of 8 faces",
    ),
    "all faces reversed": ((OCTAHEDRON, FACES[:, ::-1]), "seen from inside"),
    "a face twice": ((OCTAHEDRON, np.vstack([FACES, FACES[:1]])), "not manifold"),
    "a face without area": (
        (np.vstack([OCTAHEDRON, [[1.0, 0, 0]]]), np.vstack([FACES, [[0, 6, 2]]])),
        "degenerate faces: 1 of 9 faces, first face 8",
    ),
    "two pieces": (two(OCTAHEDRON, FACES, [5.0, 0, 0]), "2 pieces: 8 of 16 faces"),
    "two pieces that meet in a point": (pinched(), "not manifold at a vertex: 8 of 16 faces"),
    "faces that cross": (crossing(), "self-intersecting faces"),
    "no face": ((OCTAHEDRON, FACES[:0]), "no"),
    "a number that is none": ((OCTAHEDRON * np.nan, FACES), "not a finite number"),
    "far away": ((OCTAHEDRON * 1e9, FACES), "exceeds 1e+06"),
}


@pytest.mark.parametrize("name", FINDINGS)
def test_what_is_no_closed_surface_is_refused_with_the_reason(tmp_path, name):
    (vertices, faces), reason = FINDINGS[name]
    path = written(tmp_path, vertices, faces)
    with pytest.raises(BadInput, match=r"surface\.ply") as refused:
        read_triangulation(path)
    assert reason in str(refused.value)


def test_crossing_at_a_common_corner_is_seen():
    """Faces with the corner 0: the side of one opposite to it goes through the other, or not."""
    faces = np.array([[0, 1, 2], [0, 3, 4]])
    flat = [[0, 0, 0], [2, -1, 0], [2, 1, 0]]
    through, beside = ([[1, y, -1], [1, y, 1]] for y in (0.0, 1.0))
    assert len(corner_crossings(np.array(flat + through, float), faces)) == 1
    assert len(corner_crossings(np.array(flat + beside, float), faces)) == 0


@pytest.mark.parametrize("ending", [".stl", ".ply", ".obj"])
def test_every_format_gives_the_surface_back(tmp_path, ending):
    mesh = surface_mesh("clifford_torus", 120)
    x, faces = read_triangulation(written(tmp_path, mesh.vertices, mesh.triangles, ending))
    assert len(x) == 120 and len(faces) == 240
    # STL keeps single precision, OBJ eight digits.
    assert abs(np.sort(x, axis=0) - np.sort(mesh.vertices, axis=0)).max() < 1e-6


@pytest.mark.parametrize(
    "content", [b"", b"solid nothing\nendsolid\n", b"\x00\xff" * 60, b"ply\nformat ascii 1.0\n"]
)
@pytest.mark.parametrize("ending", [".stl", ".ply", ".obj"])
def test_a_damaged_file_is_bad_input(tmp_path, ending, content):
    path = tmp_path / f"damaged{ending}"
    path.write_bytes(content)
    with pytest.raises(BadInput, match="damaged"):
        read_triangulation(path)


def test_other_endings_and_missing_files_are_bad_input(tmp_path):
    with pytest.raises(BadInput, match=r"must be one of \.stl, \.ply, \.obj"):
        read_triangulation(tmp_path / "surface.vtk")
    with pytest.raises(BadInput, match="cannot be read"):
        read_triangulation(tmp_path / "absent.stl")


def test_too_coarse_a_surface_is_refused():
    with pytest.raises(ValueError, match="too coarse to estimate curvature"):
        fit_jets(OCTAHEDRON, FACES)


EXACT = {"sphere": StationarySphere(), "clifford_torus": CliffordTorus()}
# The order in h of the errors of x, nu, H with jets of degree 5, less a margin for meshes that are
# no refinements of each other.
ORDERS = {"x": (6, 0.9), "nu": (5, 0.9), "H": (4, 0.9)}


def estimation_errors(surface, vertices, degree):
    """Largest errors of the nodes and the data in them, against the exact surface."""
    exact, mesh = EXACT[surface], surface_mesh(surface, vertices)
    jets = fit_jets(mesh.vertices, mesh.triangles)
    _, x, weights = raised(mesh.vertices, mesh.triangles, jets, degree)
    nu, H = blended_fields(jets, x, *weights)
    y = exact.closest_point(x, 0.0)
    f = exact.fields(y, 0.0)
    pairs = ((x, y), (nu, f.nu), (H, f.H))
    return dict(zip(ORDERS, (np.abs(a - b).max() for a, b in pairs), strict=True))


@pytest.mark.parametrize("degree", [2, 4])
@pytest.mark.parametrize("surface", EXACT)
def test_estimates_converge_at_the_order_of_the_jets(surface, degree):
    # Near the hole of the torus a coarse mesh is not yet where its asymptotics are.
    sizes = {"sphere": (480, 1920), "clifford_torus": (960, 3840)}[surface]
    coarse, fine = (estimation_errors(surface, V, degree) for V in sizes)
    for name, (order, margin) in ORDERS.items():
        # V times four halves h.
        assert np.log2(coarse[name] / fine[name]) > order - margin, name


@pytest.mark.parametrize("vertices", [240, 960])
def test_the_first_step_is_nearly_that_of_the_implicit_reaction(tmp_path, vertices):
    """With BDF1 the reaction takes w of the start: W then differs by less than two per cent, from V
    and z of the jets by nine (V = 240) and five (960)."""
    mesh = surface_mesh("clifford_torus", vertices)
    scheme = 'bdf = 1\nproject = true\ntheta = false\nreaction = "extrapolated"'
    flow = load_flow(
        write_varied(
            tmp_path / "flow.toml",
            SMALL_FLOW,
            ('surface = "ellipsoid"\nvertices = 60', 'mesh = "torus.ply"'),
            ("bdf = 2\nproject = true\ntheta = false", scheme),
        )
    )
    computed, start = estimated_state(mesh.vertices, mesh.triangles, flow)
    # Neither estimates nor w = 0 would leave nothing to correct.
    rest = correction(computed, start, Scheme(theta=True))
    assert np.abs(rest).max() < 1e-12 * np.abs(start.w).max()
    W = {}
    for reaction in ("implicit", "extrapolated", "linearised"):
        method = Scheme(bdf=BDF.of_order(1), reaction=reaction)
        *_, last = evolve(computed, start, method, Levels.equal(0.002, 1))
        W[reaction] = willmore_energy(geometry(computed, last.x), last.H)
    for reaction in ("extrapolated", "linearised"):
        assert W[reaction] == pytest.approx(W["implicit"], rel=0.02, abs=0)


def test_the_vertices_stay_where_they_are():
    mesh = surface_mesh("clifford_torus", 240)
    jets = fit_jets(mesh.vertices, mesh.triangles)
    _, x, _ = raised(mesh.vertices, mesh.triangles, jets, 3)
    # Rounding of the way into the frame of the jet and back.
    np.testing.assert_allclose(x[:240], mesh.vertices, rtol=0, atol=1e-14)


def test_area_and_volume_of_the_raised_sphere_are_those_of_the_sphere():
    mesh = surface_mesh("sphere", 960)
    jets = fit_jets(mesh.vertices, mesh.triangles)
    raised_mesh, x, _ = raised(mesh.vertices, mesh.triangles, jets, 3)
    geo = geometry(raised_mesh, x)
    # Interpolation of degree 3 at h = 0.12: h^4 of the position.
    assert area(geo) == pytest.approx(4 * np.pi, rel=1e-5)
    assert volume(geo) == pytest.approx(4 * np.pi / 3, rel=1e-5)
