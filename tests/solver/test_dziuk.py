"""Dziuk's algorithm: a gradient flow, its longhand, its defect, its invariances."""

import numpy as np
import pytest
from longhand import components, matrix, points_of

from esfem.reference_solutions import StationarySphere
from esfem.solver.assembly import mass_matrix, stiffness_matrix
from esfem.solver.functionals import mesh_width
from esfem.solver.geometry import Geometry, geometry
from esfem.solver.schemes.dziuk import applied, bending, curvature_vector, step, stretching

each_degree = pytest.mark.parametrize("k", [1, 2, 3])


def energy(mesh, x: np.ndarray) -> float:
    """1/2 int |w_h|^2."""
    geo = geometry(mesh, x)
    w = curvature_vector(geo, x)
    return 0.5 * float(np.sum(w * (mass_matrix(geo) @ w)))


def descent(geo: Geometry, w: np.ndarray) -> np.ndarray:
    """-dW_h = 1/2 int |w|^2 div phi + B(w, phi), dual (N, 3): right of M v = -dW_h."""
    return 0.5 * applied(stretching(geo, w), w) + applied(bending(geo), w)


class TestDescent:
    @each_degree
    def test_is_minus_the_derivative_of_the_discrete_energy(self, make_rough, k):
        """By central differences along random directions, on a rough surface."""
        rough = make_rough(k)
        geo = geometry(rough.mesh, rough.x)
        along = descent(geo, curvature_vector(geo, rough.x))
        rng, eps = np.random.default_rng(7), 1e-6
        for direction in rng.standard_normal((3, *rough.x.shape)):
            up, down = (energy(rough.mesh, rough.x + s * eps * direction) for s in (1, -1))
            # The energy is rough: third derivatives are large, so differences agree to 1e-5.
            assert (up - down) / (2 * eps) == pytest.approx(-np.sum(along * direction), rel=1e-4)

    @each_degree
    def test_energy_falls_along_it(self, make_rough, k):
        rough = make_rough(k)
        geo = geometry(rough.mesh, rough.x)
        along = descent(geo, curvature_vector(geo, rough.x))
        length = 1e-6 / np.abs(along).max()
        assert energy(rough.mesh, rough.x + length * along) < energy(rough.mesh, rough.x)


class TestLonghand:
    @pytest.mark.parametrize("k", [1, 2])
    def test_bending_is_the_form_of_the_paper(self, make_rough, k):
        """grad w . grad phi + div w div phi - D(phi) grad x . grad w, in components."""
        rough = make_rough(k)
        points, w = list(points_of(rough.mesh, rough.x)), rough.u[:, 1:]

        def entry(p, i: int, b: int) -> float:
            grad_w, grad_x = p.gradient(w), p.gradient(rough.x)
            grad_phi = np.zeros((3, 3))
            grad_phi[:, b] = p.grad[i]
            D = grad_phi + grad_phi.T
            return (
                np.sum(grad_w * grad_phi)
                + np.trace(grad_w) * np.trace(grad_phi)
                - np.sum((D @ grad_x) * grad_w)
            )

        expected = components(rough.mesh, points, entry)
        B = applied(bending(geometry(rough.mesh, rough.x)), w)
        np.testing.assert_allclose(B, expected, rtol=0, atol=1e-10 * np.abs(expected).max())

    def test_stretching_tests_the_divergence(self, make_rough):
        rough = make_rough(1)
        points, w, y = list(points_of(rough.mesh, rough.x)), rough.u[:, 1:], rough.w[:, 1:]
        expected = components(
            rough.mesh, points, lambda p, i, b: (p.value(w) @ p.value(y)) * p.grad[i][b]
        )
        found = applied(stretching(geometry(rough.mesh, rough.x), w), y)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())

    def test_step_solves_its_two_equations(self, raised):
        mesh, x = raised("torus", 30, 1)
        points, tau = list(points_of(mesh, x)), 1e-4
        geo = geometry(mesh, x)
        w = curvature_vector(geo, x)
        new, w_new = step(geo, x, w, tau, None)
        M = matrix(mesh, points, lambda p, i, j: p.phi[i] * p.phi[j])
        A = matrix(mesh, points, lambda p, i, j: p.grad[i] @ p.grad[j])
        np.testing.assert_allclose(M @ w_new, -A @ new, rtol=0, atol=1e-10)
        right = (
            applied(bending(geo), w_new)
            + applied(stretching(geo, w), w_new)
            - 0.5 * applied(stretching(geo, w), w)
        )
        scale = np.abs(right).max()
        np.testing.assert_allclose(M @ (new - x) / tau, right, rtol=0, atol=1e-9 * scale)


class TestConsistency:
    @pytest.mark.parametrize(("k", "least", "most"), [(2, 1.7, 2.9), (3, 2.6, 3.6)])
    def test_exact_geometry_leaves_a_defect_of_order_k(self, raised, torus, k, least, most):
        """M v - descent with w = -H nu and v = V nu of a moving torus, in the norm of H^-1_h."""
        from test_defect import dual_norms, slope

        h, e = [], []
        for V in (120, 240, 480, 960):
            mesh, x = raised("torus", V, k)
            geo, f = geometry(mesh, x), torus.fields(x)
            w, v = -f.H[:, None] * f.nu, f.V[:, None] * f.nu
            h.append(mesh_width(geo))
            e.append(np.linalg.norm(dual_norms(geo, mass_matrix(geo) @ v - descent(geo, w))))
        assert least < slope(h, e) < most


class TestInvariance:
    def test_translation(self, raised):
        mesh, x = raised("torus", 30, 2)
        y = x + np.array([3.0, -2.0, 5.0])
        new = step(geometry(mesh, x), x, curvature_vector(geometry(mesh, x), x), 1e-5, None)[0]
        moved = step(geometry(mesh, y), y, curvature_vector(geometry(mesh, y), y), 1e-5, None)[0]
        np.testing.assert_allclose(moved - y, new - x, rtol=0, atol=1e-9)

    def test_rotation(self, raised):
        mesh, x = raised("torus", 30, 2)
        R = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
        R = R * np.sign(np.linalg.det(R))
        new = step(geometry(mesh, x), x, curvature_vector(geometry(mesh, x), x), 1e-5, None)[0]
        y = x @ R.T
        turned = step(geometry(mesh, y), y, curvature_vector(geometry(mesh, y), y), 1e-5, None)[0]
        np.testing.assert_allclose(turned, new @ R.T, rtol=0, atol=1e-9)

    def test_scaling_of_length_by_two_is_one_of_time_by_sixteen(self, raised):
        mesh, x = raised("torus", 30, 2)
        new = step(geometry(mesh, x), x, curvature_vector(geometry(mesh, x), x), 1e-5, None)[0]
        y = 2 * x
        big = step(geometry(mesh, y), y, curvature_vector(geometry(mesh, y), y), 16e-5, None)[0]
        np.testing.assert_allclose(big, 2 * new, rtol=0, atol=1e-9)


def test_forcing_moves_the_sphere_along_its_normal(raised):
    """v = f n where the energy is at rest, up to the error in space."""
    mesh, x = raised("sphere", 240, 2)
    geo, tau = geometry(mesh, x), 1e-6
    w = curvature_vector(geo, x)
    f = np.full(geo.dA.shape, 0.5)
    rested, pushed = (step(geo, x, w, tau, force)[0] for force in (None, f))
    speed = np.einsum("ja,ja->j", pushed - rested, StationarySphere().fields(x, 0.0).nu) / tau
    # The step is implicit, so that tau times a stiffness of size 1e4 takes away some of the push.
    assert np.median(speed) == pytest.approx(0.5, rel=0.02)


def test_curvature_vector_is_minus_H_nu(raised):
    """On the unit sphere w -> -2 x."""
    mesh, x = raised("sphere", 240, 2)
    w = curvature_vector(geometry(mesh, x), x)
    assert np.sqrt(np.mean((w + 2 * x) ** 2)) < 0.02


def test_stiffness_and_bending_agree_on_normal_fields_of_a_plane_direction(raised):
    """B kills constants: translations cost nothing."""
    mesh, x = raised("torus", 30, 2)
    B = bending(geometry(mesh, x))
    constant = np.ones_like(x) * [1.0, -2.0, 0.5]
    size = np.abs(stiffness_matrix(geometry(mesh, x)) @ x).max()
    np.testing.assert_allclose(applied(B, constant), 0.0, rtol=0, atol=1e-11 * max(size, 1.0))
