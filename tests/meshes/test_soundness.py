"""What is no smooth closed surface, or no mesh of one, is refused with its reason."""

import time
from dataclasses import replace

import numpy as np
import pytest
import sympy
from sympy import Rational, cos, sin
from sympy.abc import u, v, x, y, z

from esfem.meshes import distmesh, library, soundness, surface_mesh, surfaces
from esfem.meshes.soundness import crossing_pairs
from esfem.meshes.triangulation import MeshQualityError
from esfem.reference_solutions.calculus import LevelSet, Parametrised
from esfem.reference_solutions.surfaces import surface_names

PLANE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
ROUND = x**2 + y**2 + z**2
SHRUNK = 1 - Rational(3, 2) * (x**2 + y**2)  # negative on the equator


def torus(rho, height) -> Parametrised:
    return Parametrised((rho * cos(u), rho * sin(u), height), genus=1)


# Surface, and what is said of it.
BAD = {
    "inward": (LevelSet(1 - ROUND, (x, y, z)), "normals point inward.*negative inside"),
    "mirrored": (Parametrised((x, y, -z)), "normals point inward.*orientation"),
    "cylinder": (LevelSet(x**2 + y**2 - 1, (x, y, z)), r"start = \(0, 0, 1\): no surface"),
    "paraboloid": (LevelSet(x**2 + y**2 + z - 1, (x, y, z)), "disagree .open, folded"),
    "empty": (LevelSet(ROUND + 1, (x, y, z)), "no surface phi = 0 is found"),
    "squared": (LevelSet((ROUND - 1) ** 2, (x, y, z)), "gradient of phi vanishes"),
    "cubed": (LevelSet((ROUND - 1) ** 3, (2 * x, 2 * y, 2 * z)), "gradient vanishes"),
    "cusp": (LevelSet(x**2 + y**2 - (1 - z**2) ** 3, (x, y, z)), "gradient of phi vanishes"),
    "horn_torus": (torus(1 + cos(v), sin(v)), "not regular: .*no tangent plane"),
    "spindle_torus": (torus(Rational(1, 2) + cos(v), sin(v)), "disagree .open, folded"),
    "self_crossing": (Parametrised((SHRUNK * x, SHRUNK * y, z)), r"crosses itself: \d+ pairs"),
    "open_torus": (torus(2 + cos(v), sin(v) + u / 10), "not closed: .*not periodic"),
    "strange_symbol": (LevelSet(sympy.Symbol("a") * ROUND - 1, (x, y, z)), "holds a, but"),
}


@pytest.fixture
def bad_surface(monkeypatch):
    """Makes a surface of `BAD` known under its name."""

    def known(name: str) -> str:
        monkeypatch.setattr(surfaces, "surface_names", lambda: (name,))
        monkeypatch.setattr(surfaces, "named_surface", lambda _: BAD[name][0])
        surfaces.named_mesh_surface.cache_clear()
        return name

    yield known
    surfaces.named_mesh_surface.cache_clear()


class TestCrossings:
    @pytest.mark.parametrize(
        ("other", "meet"),
        [
            ([[0.2, 0.2, -1.0], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]], True),  # through the middle
            ([[0.2, 0.2, 0.1], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]], False),  # above
            ([[0.2, 0.2, 0.0], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]], True),  # touches
            ([[0.7, 0.7, -1.0], [0.8, 0.7, 1.0], [0.7, 0.8, 1.0]], False),  # beside
            ([[-1.0, 0.2, -1.0], [-1.0, 0.2, 1.0], [3.0, 0.2, 0.0]], True),  # is cut by its edges
        ],
    )
    def test_two_triangles(self, other, meet):
        vertices = np.vstack([PLANE, other])
        pairs = crossing_pairs(vertices, np.array([[0, 1, 2], [3, 4, 5]]))
        assert pairs.tolist() == ([[0, 1]] if meet else [])

    def test_is_seen_from_everywhere(self):
        """Rotations, order of triangles and of their corners do not matter."""
        rng = np.random.default_rng(0)
        vertices = np.vstack([PLANE, [[0.2, 0.2, -1.0], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]]])
        for _ in range(50):
            rotation, _ = np.linalg.qr(rng.standard_normal((3, 3)))
            corners = np.stack([rng.permutation(3), 3 + rng.permutation(3)])[rng.permutation(2)]
            assert len(crossing_pairs(vertices @ rotation.T, corners)) == 1

    def test_is_what_sampling_sees(self):
        """Random triangles that meet have points, dense in both, close to each other."""
        rng = np.random.default_rng(1)
        n = 24
        weights = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
        found = 0
        for _ in range(100):
            vertices = rng.random((6, 3))
            first, second = (weights @ vertices[i : i + 3] for i in (0, 3))
            gap = np.linalg.norm(first[:, None] - second, axis=2).min()
            meet = len(crossing_pairs(vertices, np.arange(6).reshape(2, 3))) > 0
            found += meet
            assert gap < 1.5 / n if meet else gap > 0  # cells of sides up to sqrt(3)/n
        assert 10 < found < 90

    @pytest.mark.parametrize("name", ["ellipsoid", "red_blood_cell", "clifford_torus"])
    def test_a_clean_mesh_has_none_and_is_seen_fast(self, name):
        mesh = surface_mesh(name, 3840)
        start = time.perf_counter()
        assert len(crossing_pairs(mesh.vertices, mesh.triangles)) == 0
        assert time.perf_counter() - start < 4.0  # 0.2 alone on the machine

    def test_two_spheres_that_overlap_cross(self):
        mesh = surface_mesh("sphere", 480)
        both = np.vstack([mesh.vertices, mesh.vertices + np.array([1.0, 0.1, 0.2])])
        triangles = np.vstack([mesh.triangles, mesh.triangles + 480])
        pairs = crossing_pairs(both, triangles)
        assert len(pairs) > 20
        assert ((pairs.min(axis=1) < len(mesh.triangles)) & (pairs.max(axis=1) >= 956)).all()
        apart = np.vstack([mesh.vertices, mesh.vertices + np.array([2.1, 0.0, 0.0])])
        assert len(crossing_pairs(apart, triangles)) == 0


class TestEmbedding:
    @pytest.mark.parametrize("name", BAD)
    def test_bad_surface_is_refused_with_reason_and_vertices(self, bad_surface, name):
        with pytest.raises(ValueError, match=f"no mesh of {name}, V = 240: .*{BAD[name][1]}"):
            surface_mesh(bad_surface(name), 240)

    @pytest.mark.parametrize("name", ["inward", "self_crossing"])
    def test_bad_surface_is_one_line_and_exit_status_2(self, bad_surface, name, esfem):
        status, _, error = esfem("mesh", bad_surface(name), "--vertices", 100)
        assert status == 2
        assert error.count("\n") == 1 and f"no mesh of {name}, V = 100" in error

    @pytest.mark.parametrize("name", surface_names())
    def test_shipped_surfaces_pass(self, name):
        soundness.check_embedding(surfaces.mesh_surface(name))


class TestMesh:
    @pytest.fixture
    def mesh(self):
        return surface_mesh("red_blood_cell", 240)

    def check(self, mesh, vertices=None, triangles=None):
        soundness.check_mesh(
            surfaces.mesh_surface(mesh.surface),
            mesh.vertices if vertices is None else vertices,
            mesh.triangles if triangles is None else triangles,
        )

    def test_clean_mesh_passes(self, mesh):
        self.check(mesh)

    def test_vertex_off_the_surface_is_refused(self, mesh):
        moved = mesh.vertices.copy()
        moved[7] *= 1.001
        with pytest.raises(MeshQualityError, match=r"vertex at .* is .* off the surface"):
            self.check(mesh, moved)

    def test_inward_mesh_is_refused(self, mesh):
        with pytest.raises(MeshQualityError, match="inward"):
            self.check(mesh, triangles=mesh.triangles[:, ::-1])

    def test_exchanged_vertices_are_refused(self, mesh):
        moved = mesh.vertices.copy()
        moved[[3, 200]] = moved[[200, 3]]
        with pytest.raises(MeshQualityError, match=r"crosses itself|not closed|inverted"):
            self.check(mesh, moved)

    def test_folded_element_is_refused(self):
        """A vertex is pulled over an edge of its ring, on the surface."""
        mesh = surface_mesh("ellipsoid", 480)
        triangle = mesh.triangles[(mesh.triangles == 0).any(axis=1)][0]
        a, b = (corner for corner in triangle if corner != 0)
        moved = mesh.vertices.copy()
        over = moved[a] + moved[b] - moved[0]
        exact = surfaces.mesh_surface("ellipsoid")
        moved[0] = exact.project(0.3 * moved[0] + 0.7 * over)
        with pytest.raises(MeshQualityError, match=r"inverted|crosses"):
            self.check(mesh, moved)

    @pytest.mark.slow
    def test_coarse_mesh_of_a_wavy_surface_is_refused(self):
        with pytest.raises(MeshQualityError, match="no good mesh of wave_torus, V = 60: "):
            distmesh.generate("wave_torus", 60, seeds=(0,))

    def test_stored_mesh_of_another_surface_is_refused(self, mesh, tmp_path, monkeypatch):
        """As if the file of the surface had been edited."""
        monkeypatch.setattr(library, "MESH_DIRECTORY", tmp_path)
        other = replace(mesh, surface="p2_sphere")
        other.save(library.committed_mesh_path("p2_sphere", 240))
        with pytest.raises(ValueError, match="is no mesh of this p2_sphere: vertex at"):
            surface_mesh("p2_sphere", 240)
