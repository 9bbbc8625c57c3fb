"""The distance to curved elements: exact on P_k surfaces, and of the order of interpolation."""

import numpy as np
import pytest

from esfem.measuring.curved_distance import distance_to_surface, lattice_surface
from esfem.measuring.location import evaluate
from esfem.meshes.library import surface_mesh
from esfem.reference_solutions import CliffordTorus, StationarySphere
from esfem.runs.run_case import computational_mesh

SPHERE, TORUS = StationarySphere(), CliffordTorus()


def curved(solution, vertices: int, k: int):
    return computational_mesh(surface_mesh(solution.mesh_surface, vertices), solution, k)


def sphere_points(n: int) -> np.ndarray:
    y = np.random.default_rng(1).standard_normal((n, 3))
    return y / np.linalg.norm(y, axis=1, keepdims=True)


class TestDistanceToSurface:
    @pytest.mark.parametrize("k", [1, 2, 3, 4])
    @pytest.mark.parametrize("solution", [SPHERE, TORUS])
    @pytest.mark.parametrize("distance", [0.0, 1e-6, 1e-2])
    def test_is_how_far_a_point_was_moved_along_the_normal(self, solution, k, distance):
        """Inside elements of the surface itself, whatever it approximates."""
        mesh, x = curved(solution, 120, k)
        rng = np.random.default_rng(0)
        cell, xi = rng.integers(0, len(mesh.cells), 400), rng.dirichlet(np.ones(3), 400)[:, 1:]
        X, dX = evaluate(mesh, x, cell, xi)
        normal = np.cross(dX[:, 0], dX[:, 1])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        found = distance_to_surface(mesh, x, X + distance * normal)
        assert (found <= distance + 2e-15).all()
        if solution is SPHERE or distance < 1e-3:  # else another element may be nearer
            np.testing.assert_allclose(found, distance, rtol=0, atol=2e-15)

    def test_over_edges_and_corners(self):
        """Outside a convex polyhedron they are the nearest: against many points of it."""
        mesh, x = curved(SPHERE, 30, 1)
        y = 1.3 * np.vstack([x, x[mesh.triangles].mean(axis=1), sphere_points(50)])
        corners = x[mesh.triangles]
        n = 120
        i, j = (a.ravel() for a in np.meshgrid(np.arange(n + 1), np.arange(n + 1)))
        i, j = i[i + j <= n] / n, j[i + j <= n] / n
        weights = np.stack([1.0 - i - j, i, j], axis=1)
        points = np.einsum("pc,eca->epa", weights, corners).reshape(-1, 3)
        brute = np.array([np.linalg.norm(points - p, axis=1).min() for p in y])
        found = distance_to_surface(mesh, x, y)
        assert (found <= brute + 1e-14).all()
        assert (found >= brute - 1e-4).all()  # (spacing 0.6 / 120)^2 over twice the distance 0.3
        np.testing.assert_allclose(found[: len(x)], 0.3, rtol=0, atol=1e-14)

    @pytest.mark.parametrize(("k", "order"), [(1, 2), (2, 4), (3, 4)])
    def test_of_the_sphere_falls_as_the_interpolation_does(self, k, order):
        """O(h^(k+1)), even k one order more: both ways alike, without a floor of the lattice."""
        y, back, to = sphere_points(2000), [], []
        for vertices in (60, 240):
            mesh, x = curved(SPHERE, vertices, k)
            back.append(distance_to_surface(mesh, x, y).max())
            to.append(np.abs(np.linalg.norm(lattice_surface(mesh, x), axis=1) - 1.0).max())
        assert order - 0.6 < np.log2(back[0] / back[1]) < order + 0.6
        np.testing.assert_allclose(back, to, rtol=0.25)
