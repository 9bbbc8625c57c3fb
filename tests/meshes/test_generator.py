"""The mesh generator: what it promises of a mesh, what is stored, and how both refuse bad input."""

import dataclasses
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from esfem.meshes import (
    MESH_SURFACES,
    SurfaceMesh,
    committed_mesh_path,
    committed_sizes,
    distmesh,
    flips,
    library,
    quality,
)
from esfem.meshes.surfaces import mesh_surface
from esfem.meshes.triangulation import CURVED_DEGREES, MeshQualityError, measured
from esfem.solver.mesh import triangulation

LADDERS = {
    "sphere": (30, 60, 120, 240, 480, 960, 1920, 3840),
    "clifford_torus": (30, 60, 120, 240, 480, 960, 1920, 3840),
    "ellipsoid": (60, 120, 240, 480, 960, 1920, 3840),
    "red_blood_cell": (60, 120, 240, 480, 960, 1920, 3840),
    "p2_sphere": (120, 240, 480, 960, 1920, 3840),
    "rippled_torus": (3000,),
}
COMMITTED = [(surface, V) for surface in LADDERS for V in committed_sizes(surface)]
EXACT_AREA = {
    "sphere": 4.0 * np.pi,
    "clifford_torus": 4.0 * np.pi**2 / np.sqrt(2.0),
    # 2 pi (1 + 2 asin(e) / e), e = sqrt(3)/2 the eccentricity.
    "ellipsoid": 2.0 * np.pi * (1.0 + 4.0 * np.pi / np.sqrt(27.0)),
    "red_blood_cell": 33.257086818,  # by independent one-dimensional spectral codes
    "p2_sphere": 12.96379802,
    "rippled_torus": 107.752410407,  # by the trapezoidal rule, tests of surfaces
}

each_surface = pytest.mark.parametrize("surface", MESH_SURFACES)
each_ladder = pytest.mark.parametrize("surface", LADDERS)
each_committed = pytest.mark.parametrize(("surface", "vertices"), COMMITTED)


@cache
def committed(surface: str, vertices: int) -> SurfaceMesh:
    return SurfaceMesh.load(committed_mesh_path(surface, vertices))


def as_trimesh(vertices, triangles) -> trimesh.Trimesh:
    return trimesh.Trimesh(vertices, triangles, process=False)


def assert_topology(vertices, triangles, surface: str) -> None:
    """Closed, oriented, connected, outward and of right genus, all as trimesh sees it."""
    mesh = as_trimesh(vertices, triangles)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert mesh.euler_number == 2 - 2 * mesh_surface(surface).genus
    assert mesh.volume > 0


def canonical(triangles) -> np.ndarray:
    """Triangles that start with their least vertex, sorted: equal for equal oriented meshes."""
    start = triangles.argmin(axis=1)[:, None]
    rotated = np.take_along_axis(triangles, (start + np.arange(3)) % 3, axis=1)
    return rotated[np.lexsort(rotated.T[::-1])]


def shaken(surface: str, vertices: int, amount: float) -> tuple[np.ndarray, ...]:
    """x, nu, triangles of a stored mesh, moved at random by ``amount`` of its mean edge."""
    exact, mesh = MESH_SURFACES[surface], committed(surface, vertices)
    noise = np.random.default_rng(5).standard_normal(mesh.vertices.shape)
    h = quality.edge_lengths(mesh.vertices, mesh.triangles).mean()
    x = exact.project(mesh.vertices + amount * h * noise)
    return x, exact.normal(x), mesh.triangles


class TestSurfaces:
    @each_surface
    def test_key_is_name(self, surface):
        assert MESH_SURFACES[surface].name == surface

    @each_surface
    def test_embedding_lies_on_surface(self, surface):
        exact = MESH_SURFACES[surface]
        y = exact.embed(distmesh.parameter_cloud(exact, 100, np.random.default_rng(0)))
        np.testing.assert_allclose(exact.project(y), y, rtol=0, atol=1e-14)  # a few roundings

    @each_surface
    def test_area_elements_integrate_to_area(self, surface):
        exact = MESH_SURFACES[surface]
        p = distmesh.parameter_cloud(exact, 40_000, np.random.default_rng(0))
        domain = 4.0 * np.pi if exact.genus == 0 else np.prod(exact.periods)
        area = domain * distmesh.area_elements(exact, p).mean()
        # Monte Carlo: on the torus rho^2 has a relative deviation 1.22: 3 sigma is 1.8 percent.
        np.testing.assert_allclose(area, EXACT_AREA[surface], rtol=0.018, atol=0)

    def test_torus_parameters_are_conformal(self):
        torus = MESH_SURFACES["clifford_torus"]
        p = distmesh.parameter_cloud(torus, 50, np.random.default_rng(0))
        eps = 1e-5
        du, dv = ((torus.embed(p + s) - torus.embed(p - s)) / (2 * eps) for s in np.eye(2) * eps)
        rho = np.hypot(*torus.embed(p)[:, :2].T)
        # Central differences err by eps^2 = 1e-10 and round-off / eps = 1e-11.
        for derivative in (du, dv):
            np.testing.assert_allclose(np.linalg.norm(derivative, axis=1), rho, rtol=0, atol=1e-8)
        np.testing.assert_allclose((du * dv).sum(axis=1), 0.0, rtol=0, atol=1e-8)
        assert ((np.cross(du, dv) * torus.normal(torus.embed(p))).sum(axis=1) > 0).all()

    @pytest.mark.parametrize("change", [{"genus": 2}, {"periods": None}, {"periods": (1.0, -1.0)}])
    def test_bad_surface_is_refused(self, change):
        with pytest.raises(ValueError, match=rf"{next(iter(change))} = .*must be"):
            dataclasses.replace(MESH_SURFACES["clifford_torus"], **change)


class TestQuality:
    # The 3-4-5 triangle: r_in = 1, r_circ = 5/2.
    vertices = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]])
    triangle = np.array([[0, 1, 2]])

    def test_radius_ratio_of_egyptian_triangle(self):
        q = quality.radius_ratios(self.vertices, self.triangle)
        np.testing.assert_allclose(q, 0.8, rtol=1e-14, atol=0)

    def test_angles_of_egyptian_triangle(self):
        expected = np.degrees([np.pi / 2, np.arctan(4 / 3), np.arctan(3 / 4)])
        angles = quality.angles(self.vertices, self.triangle)[0]
        np.testing.assert_allclose(angles, expected, rtol=1e-14, atol=0)

    @each_surface
    @pytest.mark.parametrize("k", CURVED_DEGREES)
    def test_curved_quality_tends_to_one(self, surface, k):
        exact = MESH_SURFACES[surface]
        defects = []
        for V in (480, 1920):
            mesh = committed(surface, V)
            defects.append(
                1 - quality.curved_qualities(exact, mesh.vertices, mesh.triangles, k).min()
            )
        # The area element varies by O(h^2): a quarter, but the worst elements are not similar.
        np.testing.assert_allclose(defects[1] / defects[0], 0.25, rtol=0.25, atol=0)

    @each_surface
    @pytest.mark.parametrize("k", CURVED_DEGREES)
    def test_inverted_mesh_has_negative_curved_quality(self, surface, k):
        mesh = committed(surface, 60)
        inverted = mesh.triangles[:, ::-1]
        q = quality.curved_qualities(MESH_SURFACES[surface], mesh.vertices, inverted, k)
        assert (q < 0).all()

    @pytest.mark.parametrize(
        ("field", "value"), [("radius_ratio", 0.6), ("min_angle", 30.0), ("curved_quality", 0.0)]
    )
    def test_gate_refuses_what_is_at_the_bound(self, field, value):
        mesh = dataclasses.replace(committed("sphere", 30), **{field: value})
        with pytest.raises(MeshQualityError, match=r"sphere, 30 vertices.*must exceed"):
            mesh.check_quality()


class TestCommitted:
    @each_ladder
    def test_ladder_is_complete(self, surface):
        assert set(LADDERS[surface]) <= set(committed_sizes(surface))

    def test_every_folder_is_a_ladder(self):
        folders = {path.parent.name for path in library.MESH_DIRECTORY.glob("*/*.npz")}
        assert folders == set(LADDERS)

    @each_committed
    def test_topology(self, surface, vertices):
        mesh = committed(surface, vertices)
        assert len(mesh.vertices) == vertices
        assert_topology(mesh.vertices, mesh.triangles, surface)

    @each_committed
    def test_vertices_lie_on_surface(self, surface, vertices):
        x = committed(surface, vertices).vertices
        closest = mesh_surface(surface).project(x)
        np.testing.assert_allclose(closest, x, rtol=0, atol=1e-14)  # a few roundings

    @each_committed
    def test_stored_quality_is_measured_quality(self, surface, vertices):
        mesh = committed(surface, vertices)
        again = measured(surface, mesh.vertices, mesh.triangles, mesh.seed)
        for field in ("radius_ratio", "curved_quality", "min_angle"):
            # 1e-10: round-off, also of another BLAS.
            assert getattr(again, field) == pytest.approx(getattr(mesh, field), rel=1e-10, abs=0)

    @each_committed
    def test_passes_gate(self, surface, vertices):
        committed(surface, vertices).check_quality()

    @each_committed
    def test_quality_as_trimesh_sees_it(self, surface, vertices):
        mesh = committed(surface, vertices)
        least = np.degrees(as_trimesh(mesh.vertices, mesh.triangles).face_angles.min())
        assert least > 30.0
        assert mesh.min_angle == pytest.approx(least, rel=1e-8, abs=0)  # arccos near a right angle

    @each_ladder
    def test_ladder_is_uniform(self, surface):
        """Largest diameter over h in a band of 20 percent, and no level of poor elements."""
        ratios = []
        for V in LADDERS[surface]:
            mesh = committed(surface, V)
            h = np.sqrt(4 * EXACT_AREA[surface] / (np.sqrt(3) * len(mesh.triangles)))
            ratios.append(quality.edge_lengths(mesh.vertices, mesh.triangles).max() / h)
            assert mesh.min_angle > 35.0
            assert mesh.radius_ratio > 0.8
        assert max(ratios) < 1.2 * min(ratios)

    @pytest.mark.parametrize(
        "surface",
        [pytest.param(s, marks=[pytest.mark.slow] * (min(LADDERS[s]) > 1000)) for s in LADDERS],
    )
    def test_is_what_the_generator_makes_from_its_seed(self, surface):
        coarsest = min(LADDERS[surface])
        mesh = committed(surface, coarsest)
        again = distmesh.generate_seed(surface, coarsest, mesh.seed)
        np.testing.assert_array_equal(again.triangles, mesh.triangles)
        # Relaxation contracts: a change of 1e-15 at its start was measured to become at most 6e-14.
        np.testing.assert_allclose(again.vertices, mesh.vertices, rtol=0, atol=1e-12)


class TestGenerate:
    @each_surface
    @pytest.mark.parametrize("extra", [0, 1, 13])
    def test_gives_the_vertices_asked_for(self, surface, extra):
        V = MESH_SURFACES[surface].minimum_vertices + extra
        mesh = distmesh.generate(surface, V)
        assert mesh.vertices.shape == (V, 3)
        assert_topology(mesh.vertices, mesh.triangles, surface)
        mesh.check_quality()

    @each_surface
    def test_is_deterministic(self, surface):
        first, second = (distmesh.generate(surface, 37, seeds=(3,)) for _ in range(2))
        assert first.digest == second.digest

    def test_chooses_the_best_seed(self):
        each = [distmesh.generate_seed("sphere", 20, seed) for seed in range(4)]
        best = distmesh.generate("sphere", 20, seeds=range(4))
        assert best.quality == max(mesh.quality for mesh in each)

    def test_reports_each_seed(self):
        lines = []
        distmesh.generate("sphere", 20, seeds=(4, 1), progress=lines.append)
        assert [line.split(":")[0] for line in lines] == [
            "mesh of sphere, V = 20, seed 4",
            "mesh of sphere, V = 20, seed 1",
        ]

    def test_surface_mesh_prefers_the_stored_one(self, monkeypatch):
        monkeypatch.setattr(library, "generate", lambda *_, **__: pytest.fail("generated"))
        assert library.surface_mesh("sphere", 60).digest == committed("sphere", 60).digest

    def test_surface_mesh_generates_other_sizes(self):
        assert 31 not in committed_sizes("sphere")
        assert len(library.surface_mesh("sphere", 31).vertices) == 31

    @pytest.mark.parametrize("function", [distmesh.generate, library.surface_mesh])
    def test_unknown_surface_is_refused(self, function):
        with pytest.raises(
            ValueError, match="surface = 'cube': must be one of sphere, clifford_tor"
        ):
            function("cube", 30)

    @each_surface
    @pytest.mark.parametrize("wrong", [0, -3, 5, 30.0, True, "30"])
    def test_bad_number_of_vertices_is_refused(self, surface, wrong):
        least = MESH_SURFACES[surface].minimum_vertices
        message = (
            f"vertices = {wrong!r}: must be an integer, at least {least}, on surface {surface}"
        )
        for function in (distmesh.generate, library.surface_mesh):
            with pytest.raises(ValueError, match=message):
                function(surface, wrong)

    def test_no_good_seed_says_why(self, monkeypatch):
        # No triangle has only larger angles.
        monkeypatch.setattr("esfem.meshes.triangulation.LEAST_ANGLE", 60.0)
        message = r"no good mesh of sphere, V = 20: .*least angle"
        with pytest.raises(MeshQualityError, match=message):
            distmesh.generate("sphere", 20, seeds=(0,))

    @pytest.mark.slow
    @each_surface
    def test_paper_sizes_are_reached(self, surface):
        """P_2 nodes are 4 V - 6 on a sphere and 4 V on a torus: V = 1246 gives the paper's 4978."""
        mesh = distmesh.generate(surface, 1246, seeds=(0,))
        nodes = triangulation(mesh.triangles, 2).node_count
        assert nodes == {"sphere": 4978, "clifford_torus": 4984}[surface]


class TestSteps:
    @each_surface
    def test_first_connectivity_has_right_topology(self, surface):
        exact = MESH_SURFACES[surface]
        p = distmesh.parameter_cloud(exact, 200, np.random.default_rng(1))
        assert_topology(exact.embed(p), distmesh.connect(exact, p), surface)

    @pytest.mark.parametrize(
        ("surface", "first", "message"),
        [("sphere", 1, "not closed"), ("clifford_torus", 0, "56 triangles, must be 60")],
    )
    def test_wrong_topology_is_refused(self, surface, first, message):
        triangles = committed("sphere", 30).triangles[first:]
        with pytest.raises(MeshQualityError, match=message):
            distmesh.check_topology(MESH_SURFACES[surface], triangles, 30)

    def test_edges_know_their_triangles(self):
        triangles = committed("clifford_torus", 60).triangles
        edges = flips.edges_of(triangles)
        for side, corners in (
            (edges.left, (edges.c, edges.a, edges.b)),
            (edges.right, (edges.d, edges.b, edges.a)),
        ):
            turned = np.stack(corners, axis=1)
            same = [(np.roll(turned, i, axis=1) == triangles[side]).all(axis=1) for i in range(3)]
            assert np.any(same, axis=0).all()

    @each_surface
    def test_flips_keep_topology(self, surface):
        x, nu, triangles = shaken(surface, 240, amount=0.15)
        flipped = flips.flip_to_delaunay(x, nu, triangles)
        assert (flipped != triangles).any()
        assert_topology(x, flipped, surface)
        degree = np.bincount(flipped.ravel())
        assert degree.min() >= 4
        assert degree.max() <= 9

    @each_surface
    def test_flips_make_delaunay(self, surface):
        x, nu, triangles = shaken(surface, 240, amount=0.1)
        flipped = flips.flip_to_delaunay(x, nu, triangles)
        edges = flips.edges_of(flipped)
        cot = flips.cotangent
        sums = cot(x, edges.c, edges.a, edges.b) + cot(x, edges.d, edges.a, edges.b)
        # So little shaken that no flip is refused; opposite angles sum to at most pi + round-off.
        assert sums.min() > -1e-10

    def test_flip_never_doubles_an_edge(self, monkeypatch):
        monkeypatch.setattr(flips, "DEGREES_ALLOWED", (0, 99))
        a, b, c, d = [-1, 0, 0], [1, 0, 0], [0, 0.1, 0], [0, -0.1, 0.02]
        x, nu = np.array([a, b, c, d], dtype=float), np.tile([0.0, 0.0, 1.0], (4, 1))
        # A flat tetrahedron: its edge a b is far from Delaunay, but c d exists already.
        tetrahedron = np.array([[2, 0, 1], [3, 1, 0], [0, 2, 3], [1, 3, 2]])
        edges, _ = flips.flippable(x, nu, tetrahedron, flips.edges_of(tetrahedron))
        assert len(edges) == 0

    def test_flip_is_undone(self):
        mesh = committed("sphere", 120)
        edges, worse = flips.edges_of(mesh.triangles), mesh.triangles.copy()
        a, b, c, d = edges.a[7], edges.b[7], edges.c[7], edges.d[7]
        worse[edges.left[7]], worse[edges.right[7]] = (c, a, d), (d, b, c)
        assert_topology(mesh.vertices, worse, "sphere")
        again = flips.flip_to_delaunay(mesh.vertices, mesh.vertices, worse)
        np.testing.assert_array_equal(canonical(again), canonical(mesh.triangles))

    def test_independent_edges_share_no_corner(self):
        rng = np.random.default_rng(2)
        corners = np.stack([rng.choice(50, 4, replace=False) for _ in range(40)])
        badness = rng.standard_normal(40)
        chosen = flips.independent(corners, badness, 50)
        assert len(np.unique(corners[chosen])) == 4 * chosen.sum()
        assert chosen[badness.argmin()]

    @each_surface
    def test_wild_move_folds_nothing(self, surface):
        exact, mesh = MESH_SURFACES[surface], committed(surface, 120)
        x, nu = mesh.vertices, exact.normal(mesh.vertices)
        h = quality.edge_lengths(x, mesh.triangles).mean()
        move = h * np.random.default_rng(3).standard_normal(x.shape)
        free = exact.project(x + move)
        assert flips.fold_cosines(free, exact.normal(free), mesh.triangles).min() < 0
        moved, normals = distmesh.guarded_move(exact, x, nu, mesh.triangles, move)
        assert flips.fold_cosines(moved, normals, mesh.triangles).min() >= 0.3
        assert (moved != x).any()

    def test_springs_are_in_balance(self):
        """On the octahedron the forces sum to zero and the shortest edges are sqrt(2)."""
        x = np.concatenate([np.eye(3), -np.eye(3)])
        sphere = MESH_SURFACES["sphere"]
        force, shortest = distmesh.push(sphere, x, flips.edges_of(distmesh.connect(sphere, x)))
        np.testing.assert_allclose(shortest, np.sqrt(2.0), rtol=1e-14, atol=0)
        # Four bars of length sqrt(2) that wish to be 1.2 times as long: each pushes 0.2 outward.
        np.testing.assert_allclose(force, 0.8 * x, rtol=0, atol=1e-14)


class TestFile:
    @pytest.fixture
    def mesh(self):
        return committed("clifford_torus", 30)

    def test_save_then_load_gives_the_same_mesh(self, mesh, tmp_path):
        mesh.save(tmp_path / "deep" / "mesh.npz")
        again = SurfaceMesh.load(tmp_path / "deep" / "mesh.npz")
        assert again.digest == mesh.digest
        for field in ("surface", "seed", "radius_ratio", "curved_quality", "min_angle"):
            assert getattr(again, field) == getattr(mesh, field)
        assert [file.name for file in (tmp_path / "deep").iterdir()] == ["mesh.npz"]

    def test_equal_meshes_give_equal_files(self, mesh, tmp_path):
        for name in ("a.npz", "b.npz"):
            mesh.save(tmp_path / name)
        assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()

    def test_digest_sees_each_part(self, mesh):
        vertices, triangles = mesh.vertices.copy(), mesh.triangles.copy()
        vertices[3, 1] = np.nextafter(vertices[3, 1], 2.0)
        triangles[4] = np.roll(triangles[4], 1)
        parts = {"vertices": vertices, "triangles": triangles, "surface": "sphere"}
        changed = [
            SimpleNamespace(**{**dataclasses.asdict(mesh), key: parts[key]}) for key in parts
        ]
        digests = {SurfaceMesh.digest.func(other) for other in (mesh, *changed)}
        assert len(digests) == 4

    def test_changed_vertex_is_refused(self, mesh, tmp_path):
        path = tmp_path / "changed.npz"
        vertices = mesh.vertices.copy()
        vertices[3, 1] = np.nextafter(vertices[3, 1], 2.0)
        np.savez(path, **{**dataclasses.asdict(mesh), "vertices": vertices}, digest=mesh.digest)
        with pytest.raises(ValueError, match=r"changed\.npz: digest is .*, the file says"):
            SurfaceMesh.load(path)

    def test_flipped_byte_is_refused_or_harmless(self, mesh, tmp_path):
        path = tmp_path / "flipped.npz"
        mesh.save(path)
        content, refused = path.read_bytes(), 0
        positions = range(0, len(content), 29)
        for i in positions:
            path.write_bytes(content[:i] + bytes([content[i] ^ 0x10]) + content[i + 1 :])
            try:
                assert SurfaceMesh.load(path).digest == mesh.digest  # a date
            except ValueError as error:
                assert "flipped.npz" in str(error)
                refused += 1
        assert refused > len(positions) / 2

    def test_truncated_file_is_refused(self, mesh, tmp_path):
        path = tmp_path / "short.npz"
        mesh.save(path)
        content = path.read_bytes()
        for length in (0, 3, 100, len(content) // 2, len(content) - 1):
            path.write_bytes(content[:length])
            with pytest.raises(ValueError, match=r"short\.npz: not a complete mesh file"):
                SurfaceMesh.load(path)

    def test_missing_file_is_named(self, tmp_path):
        with pytest.raises(FileNotFoundError, match="nothing"):
            SurfaceMesh.load(tmp_path / "nothing.npz")

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            (lambda m: {"surface": "cube"}, "surface = 'cube'"),
            (lambda m: {"surface": "sphere"}, "Euler characteristic is 0, must be 2"),
            (lambda m: {"vertices": m.vertices[:, :2]}, r"vertices: must have shape \(V, 3\)"),
            (lambda m: {"vertices": m.vertices * np.inf}, "vertices: must be finite"),
            (lambda m: {"vertices": np.vstack([m.vertices, m.vertices[:1]])}, "use 30 of 31"),
            (lambda m: {"triangles": m.triangles[1:]}, "not closed"),
        ],
    )
    def test_bad_mesh_is_refused(self, mesh, change, message):
        with np.errstate(invalid="ignore"), pytest.raises(ValueError, match=message):
            dataclasses.replace(mesh, **change(mesh))
