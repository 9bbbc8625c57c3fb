"""X_h^l - X on the initial surface, and the total curvature of computed H and nu."""

from dataclasses import replace

import numpy as np
import pytest

from esfem.measuring.flow_map import flow_map_error
from esfem.measuring.gauss_bonnet import (
    euler_characteristic,
    gauss_bonnet_error,
    total_curvature,
)
from esfem.measuring.lift import errors, exact_state, lifted_surface
from esfem.meshes import surface_mesh
from esfem.reference_solutions import BreathingEllipsoid, CliffordTorus, StationarySphere
from esfem.runs.run_case import computational_mesh
from esfem.solver.geometry import geometry

BREATHING = BreathingEllipsoid()


def exact(solution, V, k, t):
    """The mesh, its nodes on Gamma(0), and the exact State at t."""
    mesh, p = computational_mesh(surface_mesh(solution.mesh_surface, V), solution, k)
    return mesh, p, exact_state(solution, solution.trajectories(p)(t), t)


class TestFlowMap:
    @pytest.mark.parametrize("k", [2, 3])
    def test_of_exact_nodes_is_of_order_k(self, k):
        found = []
        for V in (120, 480):
            mesh, p, state = exact(BREATHING, V, k, 0.1)
            found.append(flow_map_error(mesh, p, BREATHING, 1.0)(state))
        assert k - 0.1 < np.log2(found[0] / found[1]) < k + 0.4

    @pytest.mark.parametrize("k", [1, 2, 4])
    def test_at_the_start_is_the_error_of_the_position(self, k):
        """X = id on Gamma(0): both are then x_h - id by the same lift."""
        mesh, p, state = exact(BREATHING, 60, k, 0.0)
        x = np.hypot(*errors(lifted_surface(mesh, BREATHING, p, 0.0), state)["x"])  # L = 1
        # The differences in reference coordinates.
        assert flow_map_error(mesh, p, BREATHING, 1.0)(state) == pytest.approx(x, rel=1e-6)

    def test_of_a_moved_surface_is_the_norm_of_the_displacement(self):
        """A translation by a has the norm |a| sqrt(area), to which the error is nearly orthogonal:
        of order h^k against it, and of h^2k in the norm."""
        solution, a = StationarySphere(), np.array([0.3, -0.4, 1.2])
        mesh, p, state = exact(solution, 120, 3, 0.0)
        found = flow_map_error(mesh, p, solution, 1.0)(replace(state, x=state.x + a))
        assert found == pytest.approx(1.3 * np.sqrt(4.0 * np.pi), rel=1e-4)

    def test_a_surface_that_stays_where_it_was_is_far_off(self):
        mesh, p, start = exact(BREATHING, 120, 2, 0.0)
        error = flow_map_error(mesh, p, BREATHING, 1.0)
        moved = exact(BREATHING, 120, 2, 0.1)[2]
        assert error(replace(start, t=0.1)) > 10 * error(moved)

    def test_nodes_that_changed_their_places_are_seen(self):
        """Labels count: the surface of permuted nodes is another map of Gamma(0), not near X."""
        mesh, p, state = exact(StationarySphere(), 30, 1, 0.0)
        error = flow_map_error(mesh, p, StationarySphere(), 1.0)
        assert error(replace(state, x=-state.x)) > 5.0 > error(state)

    def test_the_unit_of_length_weighs_values_against_gradients(self):
        solution = StationarySphere()
        mesh, p, state = exact(solution, 30, 2, 0.0)
        state = replace(state, x=state.x + 1.0)
        one, two = (flow_map_error(mesh, p, solution, L)(state) for L in (1.0, 0.5))
        assert two == pytest.approx(2.0 * one, rel=1e-2)


class TestGaussBonnet:
    @pytest.mark.parametrize(("surface", "chi"), [("sphere", 2), ("clifford_torus", 0)])
    def test_the_characteristic_is_counted(self, surface, chi):
        solution = {"sphere": StationarySphere(), "clifford_torus": CliffordTorus()}[surface]
        assert euler_characteristic(exact(solution, 60, 3, 0.0)[0]) == chi

    @pytest.mark.parametrize("k", [1, 2, 3, 4])
    def test_on_a_sphere_the_error_is_that_of_the_area(self, k):
        """nu_h = x_h, so that S_h is the tangential projection, |S_h|^2 = 2, and H_h = 2."""
        mesh, p, state = exact(StationarySphere(), 60, k, 0.0)
        geo = geometry(mesh, p)
        assert total_curvature(geo, state.nu, state.H) == pytest.approx(geo.dA.sum(), rel=1e-12)

    @pytest.mark.parametrize(("k", "least"), [(1, 0.8), (2, 1.8), (3, 2.8)])
    @pytest.mark.parametrize("solution", [CliffordTorus(), BREATHING], ids=["torus", "ellipsoid"])
    def test_of_exact_nodal_values_falls_with_order_k_at_least(self, solution, k, least):
        found = []
        for V in (120, 480):
            mesh, _, state = exact(solution, V, k, 0.1)
            found.append(gauss_bonnet_error(geometry(mesh, state.x), state.nu, state.H))
        assert np.log2(found[0] / found[1]) > least

    @pytest.mark.parametrize("scale", [2.0**-10, 2.0**10])
    def test_has_no_unit(self, scale):
        mesh, p, s = exact(CliffordTorus(), 60, 2, 0.0)
        one = total_curvature(geometry(mesh, p), s.nu, s.H)
        assert total_curvature(geometry(mesh, scale * p), s.nu, s.H / scale) == one

    def test_a_normal_of_another_surface_is_seen(self):
        """On the ellipsoid the normals and H of the sphere that it was."""
        mesh, _, start = exact(BREATHING, 240, 2, 0.0)
        moved = exact(BREATHING, 240, 2, 0.1)[2]
        geo = geometry(mesh, moved.x)
        right = gauss_bonnet_error(geo, moved.nu, moved.H)
        assert gauss_bonnet_error(geo, start.nu, start.H) > 100 * right
