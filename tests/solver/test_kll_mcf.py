"""Mean curvature flow by equations for nu and H: longhand, defect, invariances, orders."""

import numpy as np
import pytest
from longhand import components, matrix, points_of

from esfem.reference_solutions.sphere import ShrinkingSphere
from esfem.solver import BDF
from esfem.solver.assembly import mass_matrix, stiffness_matrix
from esfem.solver.functionals import area, mesh_width
from esfem.solver.geometry import geometry
from esfem.solver.ritz import ritz_velocity
from esfem.solver.schemes.kll_mcf import reaction, start_step, step


def once(mesh, x, u, tau, ritz=True):
    return step(mesh, [x], [u], tau, BDF.of_order(1), ritz)


class TestLonghand:
    @pytest.mark.parametrize("k", [1, 2])
    def test_reaction_is_S2_times_u(self, make_rough, k):
        rough = make_rough(k)
        points = list(points_of(rough.mesh, rough.x))

        def S2(p) -> float:
            grad = p.gradient(rough.u[:, 1:])
            return float(np.sum((0.5 * (grad + grad.T)) ** 2))

        found = reaction(geometry(rough.mesh, rough.x), rough.u)
        expected = components(
            rough.mesh, points, lambda p, i, a: S2(p) * p.value(rough.u)[1 + a] * p.phi[i]
        )
        np.testing.assert_allclose(
            found[:, 1:], expected, rtol=0, atol=1e-10 * np.abs(expected).max()
        )

    def test_ritz_velocity_solves_its_equation(self, make_rough):
        """int v phi / L^2 + int grad v . grad phi, against the product V nu and its gradient."""
        rough = make_rough(1)
        V, nu = rough.w[:, 0], rough.u[:, 1:]
        points = list(points_of(rough.mesh, rough.x))
        geo = geometry(rough.mesh, rough.x)
        v = ritz_velocity(geo, mass_matrix(geo), stiffness_matrix(geo), V, nu)
        L2 = area(geo) / (4.0 * np.pi)
        K = matrix(
            rough.mesh, points, lambda p, i, j: p.phi[i] * p.phi[j] / L2 + p.grad[i] @ p.grad[j]
        )

        def entry(p, i: int, a: int) -> float:
            slope = p.gradient(V) * p.value(nu)[a] + p.value(V) * p.gradient(nu)[:, a]
            return p.value(V) * p.value(nu)[a] * p.phi[i] / L2 + slope @ p.grad[i]

        expected = components(rough.mesh, points, entry)
        np.testing.assert_allclose(K @ v, expected, rtol=0, atol=1e-10 * np.abs(expected).max())

    def test_step_solves_its_equations(self, raised, torus):
        mesh, x = raised("torus", 30, 1)
        f, tau = torus.fields(x), 1e-3
        u = np.column_stack([f.H, f.nu])
        new, v, u_new = once(mesh, x, u, tau, ritz=False)
        geo = geometry(mesh, x)
        M, A = mass_matrix(geo), stiffness_matrix(geo)
        left = M @ (u_new - u) / tau + A @ u_new
        np.testing.assert_allclose(left, reaction(geo, u), rtol=0, atol=1e-10)
        np.testing.assert_allclose(v, -u_new[:, :1] * u_new[:, 1:], rtol=0, atol=1e-14)
        np.testing.assert_allclose(new, x + tau * v, rtol=0, atol=1e-14)


class TestConsistency:
    @pytest.mark.parametrize(("k", "least", "most"), [(2, 1.9, 2.9), (3, 2.8, 3.6)])
    def test_exact_geometry_leaves_a_defect_of_order_k(self, raised, torus, k, least, most):
        """M u' + A u - f with u' = (Lap H + |S|^2 H; grad H), as V = -H, in the norm of H^-1_h."""
        from test_defect import dual_norms, slope

        h, e = [], []
        for V in (120, 240, 480, 960):
            mesh, x = raised("torus", V, k)
            geo, f = geometry(mesh, x), torus.fields(x)
            S2 = np.einsum("jab,jab->j", f.S, f.S)
            u = np.column_stack([f.H, f.nu])
            u_dot = np.column_stack([f.laplace_H + S2 * f.H, f.z])
            r = mass_matrix(geo) @ u_dot + stiffness_matrix(geo) @ u - reaction(geo, u)
            h.append(mesh_width(geo))
            e.append(np.linalg.norm(dual_norms(geo, r)))
        assert least < slope(h, e) < most


class TestInvariance:
    @pytest.mark.parametrize("ritz", [True, False])
    def test_translation(self, raised, torus, ritz):
        mesh, x = raised("torus", 30, 2)
        f, c = torus.fields(x), np.array([3.0, -2.0, 5.0])
        u = np.column_stack([f.H, f.nu])
        new, _, u_new = once(mesh, x, u, 1e-3, ritz)
        moved, _, u_moved = once(mesh, x + c, u, 1e-3, ritz)
        np.testing.assert_allclose(moved, new + c, rtol=0, atol=1e-11)
        np.testing.assert_allclose(u_moved, u_new, rtol=0, atol=1e-11)

    @pytest.mark.parametrize("ritz", [True, False])
    def test_rotation(self, raised, torus, ritz):
        mesh, x = raised("torus", 30, 2)
        f = torus.fields(x)
        R = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
        R = R * np.sign(np.linalg.det(R))
        new = once(mesh, x, np.column_stack([f.H, f.nu]), 1e-3, ritz)[0]
        turned = once(mesh, x @ R.T, np.column_stack([f.H, f.nu @ R.T]), 1e-3, ritz)[0]
        np.testing.assert_allclose(turned, new @ R.T, rtol=0, atol=1e-12)

    def test_scaling_of_length_by_two_is_one_of_time_by_four(self, raised, torus):
        """With the velocity in the nodes; the Ritz projection has a length of its own."""
        mesh, x = raised("torus", 30, 2)
        f = torus.fields(x)
        new = once(mesh, x, np.column_stack([f.H, f.nu]), 1e-3, False)[0]
        big = once(mesh, 2 * x, np.column_stack([f.H / 2, f.nu]), 4e-3, False)[0]
        np.testing.assert_allclose(big, 2 * new, rtol=0, atol=1e-12)


@pytest.mark.parametrize("q", [1, 2, 3])
def test_sphere_shrinks_with_the_order_of_its_bdf(raised, q):
    """The radius at t = 0.1, on P_3 nodes that see no error in space of this size."""
    solution = ShrinkingSphere()
    mesh, p = raised("sphere", 60, 3)
    errors = []
    for tau in (0.02, 0.01):
        states = [solution.radius_at(j * tau) for j in range(q)][::-1]
        x = [R * p for R in states]
        u = [np.column_stack([np.full(len(p), 2 / R), p]) for R in states]
        for n in range(q, round(0.1 / tau) + 1):
            new, _, u_new = step(mesh, x, u, tau, BDF.of_order(q), True)
            x, u = [new, *x[: q - 1]], [u_new, *u[: q - 1]]
            assert np.isfinite(new).all(), n
        errors.append(abs(np.linalg.norm(x[0], axis=1).mean() - solution.radius_at(0.1)))
    assert q - 0.35 < np.log2(errors[0] / errors[1]) < q + 0.6
    assert mesh_width(geometry(mesh, x[0])) < mesh_width(geometry(mesh, p))


class TestStartStep:
    @pytest.mark.parametrize("q", [2, 3, 4, 5])
    def test_has_a_local_error_of_order_q_in_tau(self, raised, q):
        """The radius and H after one step on a sphere; P_4 sees no error in space of this size."""
        solution, (mesh, p) = ShrinkingSphere(), raised("sphere", 120, 4)
        u = np.column_stack([np.full(len(p), 2.0), p])
        errors = []
        for tau in (0.08, 0.04):
            x_new, _, u_new = start_step(mesh, p, u, tau, q, ritz=True)
            R = solution.radius_at(tau)
            errors.append(
                [abs(np.linalg.norm(x_new, axis=1).mean() - R), abs(u_new[:, 0].mean() - 2 / R)]
            )
        orders = np.log2(np.divide(*errors))
        assert (q - 0.4 < orders).all() and (orders < q + 1.1).all()

    def test_of_order_two_is_a_step_of_bdf1(self, raised, torus):
        mesh, x = raised("torus", 30, 2)
        f = torus.fields(x)
        u = np.column_stack([f.H, f.nu])
        for given, wanted in zip(
            start_step(mesh, x, u, 1e-3, 2, True), once(mesh, x, u, 1e-3), strict=True
        ):
            np.testing.assert_array_equal(given, wanted)
