"""The BGN scheme: its longhand, its defect, its invariances, nodes that slide, known decay."""

import numpy as np
import pytest
from longhand import components, matrix, points_of, vector

from esfem.reference_solutions import PerturbedSphere
from esfem.solver.assembly import load, mass_matrix, stiffness_matrix
from esfem.solver.functionals import area, mesh_width, volume
from esfem.solver.geometry import geometry, interpolate
from esfem.solver.laws import surface_diffusion, willmore
from esfem.solver.schemes.bgn import nonlinear, step, weingarten


class TestLonghand:
    @pytest.mark.parametrize("k", [1, 2])
    def test_weingarten_solves_its_equation(self, make_rough, k):
        """int A . phi = -int n . div phi + int H n . phi n for phi = phi_i (e_a e_b + e_b e_a)."""
        rough = make_rough(k)
        points, H = list(points_of(rough.mesh, rough.x)), rough.u[:, 0]
        geo = geometry(rough.mesh, rough.x)
        M = matrix(rough.mesh, points, lambda p, i, j: p.phi[i] * p.phi[j])
        A = weingarten(geo, H)

        normals = {id(p): n for p, n in zip(points, geo.normal.reshape(-1, 3), strict=True)}
        for a, b in ((0, 0), (0, 1), (2, 1)):

            def entry(p, i: int, a: int = a, b: int = b) -> float:
                n = normals[id(p)]
                div = p.grad[i][a] * n[b] + p.grad[i][b] * n[a]
                return -div + p.value(H) * p.phi[i] * 2 * n[a] * n[b]

            expected = vector(rough.mesh, points, entry)
            found = M @ (A[:, a, b] + A[:, b, a])
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())

    def test_nonlinear_tests_Q_of_the_discrete_weingarten_map(self, make_rough):
        """int (|A|^2 H - H^3 / 2) phi_i, with A the nodal field of `weingarten`."""
        rough = make_rough(2)
        points, H = list(points_of(rough.mesh, rough.x)), rough.u[:, 0]
        geo = geometry(rough.mesh, rough.x)
        A = weingarten(geo, H).reshape(-1, 9)

        def entry(p, i: int) -> float:
            h = p.value(H)
            return (np.sum(p.value(A) ** 2) * h - h**3 / 2) * p.phi[i]

        expected = vector(rough.mesh, points, entry)
        found = nonlinear(geo, H, willmore, 0.0)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())

    def test_step_solves_its_two_equations(self, raised):
        mesh, x = raised("torus", 30, 1)
        geo, tau = geometry(mesh, x), 1e-3
        H = np.linspace(1.0, 2.0, len(x))
        points = list(points_of(mesh, x))
        new, H_new = step(geo, x, H, tau, willmore, 0.0)
        A = matrix(mesh, points, lambda p, i, j: p.grad[i] @ p.grad[j])
        n = geo.normal.reshape(-1, 3)
        of = {id(p): n[i] for i, p in enumerate(points)}
        left = vector(mesh, points, lambda p, i: p.phi[i] * of[id(p)] @ p.value(new - x) / tau)
        right = nonlinear(geo, H, willmore, 0.0) - A @ H_new
        np.testing.assert_allclose(left, right, rtol=0, atol=1e-9 * np.abs(right).max())
        left = components(mesh, points, lambda p, i, a: p.phi[i] * p.value(H_new) * of[id(p)][a])
        np.testing.assert_allclose(left, A @ new, rtol=0, atol=1e-9 * np.abs(left).max())


class TestConsistency:
    @pytest.mark.parametrize(("k", "least", "most"), [(2, 1.7, 3.2), (3, 2.6, 4.2)])
    def test_exact_geometry_leaves_a_defect_of_order_k(self, raised, torus, k, least, most):
        """Of both equations, with the exact V, H and x of a moving torus."""
        from test_defect import dual_norms, slope

        h, e = [], []
        for V in (120, 240, 480, 960):
            mesh, x = raised("torus", V, k)
            geo, f = geometry(mesh, x), torus.fields(x)
            A, H_n = stiffness_matrix(geo), interpolate(geo, f.H)[..., None] * geo.normal
            speed = np.sum(interpolate(geo, f.V[:, None] * f.nu) * geo.normal, axis=-1)
            first = load(geo, speed) + A @ f.H - nonlinear(geo, f.H, willmore, 0.0)
            second = load(geo, H_n) - A @ x
            h.append(mesh_width(geo))
            e.append(np.linalg.norm(dual_norms(geo, np.column_stack([first, second]))))
        assert least < slope(h, e) < most

    def test_weingarten_of_the_sphere_is_its_tangential_projection(self, raised):
        mesh, x = raised("sphere", 480, 2)
        A = weingarten(geometry(mesh, x), np.full(len(x), 2.0))
        expected = np.eye(3) - x[:, :, None] * x[:, None, :]
        assert np.sqrt(np.mean((A - expected) ** 2)) < 0.02


class TestInvariance:
    @pytest.mark.parametrize("law", [willmore, surface_diffusion])
    def test_translation(self, raised, law):
        mesh, x = raised("torus", 30, 2)
        H, c = np.linspace(1.0, 2.0, len(x)), np.array([3.0, -2.0, 5.0])
        new, H_new = step(geometry(mesh, x), x, H, 1e-4, law, 0.0)
        moved, H_moved = step(geometry(mesh, x + c), x + c, H, 1e-4, law, 0.0)
        np.testing.assert_allclose(moved, new + c, rtol=0, atol=1e-9)
        np.testing.assert_allclose(H_moved, H_new, rtol=0, atol=1e-9)

    @pytest.mark.parametrize("law", [willmore, surface_diffusion])
    def test_rotation(self, raised, law):
        mesh, x = raised("torus", 30, 2)
        R = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
        R = R * np.sign(np.linalg.det(R))
        H = np.linspace(1.0, 2.0, len(x))
        new = step(geometry(mesh, x), x, H, 1e-4, law, 0.0)[0]
        turned = step(geometry(mesh, x @ R.T), x @ R.T, H, 1e-4, law, 0.0)[0]
        np.testing.assert_allclose(turned, new @ R.T, rtol=0, atol=1e-9)

    @pytest.mark.parametrize("law", [willmore, surface_diffusion])
    def test_scaling_of_length_by_two_is_one_of_time_by_sixteen(self, raised, law):
        mesh, x = raised("torus", 30, 2)
        H = np.linspace(1.0, 2.0, len(x))
        new, H_new = step(geometry(mesh, x), x, H, 1e-4, law, 0.0)
        big, H_big = step(geometry(mesh, 2 * x), 2 * x, H / 2, 16e-4, law, 0.0)
        np.testing.assert_allclose(big, 2 * new, rtol=0, atol=1e-9)
        np.testing.assert_allclose(H_big, H_new / 2, rtol=0, atol=1e-9)


class TestSurfaceDiffusion:
    def flow(self, mesh, x, H, tau, steps):
        for _ in range(steps):
            x, H = step(geometry(mesh, x), x, H, tau, surface_diffusion, 0.0)
            yield x

    def test_area_falls_and_volume_is_kept_to_the_step(self, raised):
        """Area decreases unconditionally (BGN 2007); volume drifts like tau."""
        mesh, x = raised("torus", 120, 2)
        from esfem.reference_solutions import Torus

        H = Torus(R=1.0, r=0.6).fields(x).H
        areas, drifts = [], []
        for tau in (1e-3, 5e-4):
            found = [geometry(mesh, y) for y in self.flow(mesh, x, H, tau, round(4e-3 / tau))]
            areas.append([area(geo) for geo in found])
            drifts.append(abs(volume(found[-1]) / volume(geometry(mesh, x)) - 1.0))
        assert all(np.diff([area(geometry(mesh, x)), *a]).max() < 0 for a in areas)
        assert drifts[1] < 0.75 * drifts[0] < 1e-2

    def test_a_mode_of_the_sphere_decays_at_its_rate(self, raised):
        """exp(-24 t) for P_2: to a few per cent at this tau."""
        solution = PerturbedSphere(degree=2)
        mesh, p = raised("sphere", 240, 2)
        x = solution.closest_point(p, 0.0)
        H, tau, steps = solution.fields(x, 0.0).H, 5e-4, 20
        *_, last = self.flow(mesh, x, H, tau, steps)
        weights = mass_matrix(geometry(mesh, x)) @ np.ones(len(x))
        before, after = (solution.mode_amplitude(y, weights) for y in (x, last))
        assert -np.log(after / before) / (tau * steps) == pytest.approx(24.0, rel=0.05)


@pytest.mark.parametrize("k", [1, 2])
def test_displaced_nodes_slide_along_the_sphere(raised, k):
    """However small the time, ten steps move them ten times as far along it as off it."""
    mesh, x = raised("sphere", 120, k)
    x = x + 0.05 * np.random.default_rng(0).standard_normal(x.shape)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    new, H = x, np.full(len(x), 2.0)
    for _ in range(10):
        new, H = step(geometry(mesh, new), new, H, 1e-6, willmore, 0.0)
    radial = np.abs(np.linalg.norm(new, axis=1) - 1.0)
    assert np.median(np.linalg.norm(new - x, axis=1)) > 10 * np.median(radial)
