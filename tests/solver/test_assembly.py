"""Mass and stiffness matrices and loads: identities, and slow loops that say the same."""

import longhand
import numpy as np
import pytest
import scipy.sparse as sp

from esfem.solver.assembly import gradient_load, load, mass_matrix, stiffness_matrix
from esfem.solver.functionals import area
from esfem.solver.geometry import geometry, gradient
from esfem.solver.mesh import Mesh
from esfem.solver.reference_element import DEGREES

# Sums of some hundred terms of size one.
ROUNDING = {"rtol": 0, "atol": 1e-12}


@pytest.fixture(params=DEGREES)
def rough(make_rough, request):
    fields = make_rough(request.param)
    fields.geo = geometry(fields.mesh, fields.x)
    return fields


class TestMass:
    def test_sums_to_area(self, rough):
        assert mass_matrix(rough.geo).sum() == pytest.approx(area(rough.geo), rel=1e-13, abs=0)

    def test_is_symmetric(self, rough):
        M = mass_matrix(rough.geo)
        assert abs(M - M.T).max() < 1e-15

    def test_is_positive_definite(self, rough):
        assert np.linalg.eigvalsh(mass_matrix(rough.geo).toarray()).min() > 0

    def test_is_that_of_the_loops(self, rough):
        expected = longhand.mass(rough.mesh, list(longhand.points_of(rough.mesh, rough.x)))
        np.testing.assert_allclose(mass_matrix(rough.geo).toarray(), expected, **ROUNDING)

    def test_constant_weight_is_a_factor(self, rough):
        weighted = mass_matrix(rough.geo, 2.5 + 0 * rough.geo.dA)
        np.testing.assert_allclose(weighted.data, 2.5 * mass_matrix(rough.geo).data, **ROUNDING)

    def test_weight_counts_at_each_point(self, rough):
        weight = np.random.default_rng(0).random(rough.geo.dA.shape)
        total = mass_matrix(rough.geo, weight).sum()
        assert total == pytest.approx(np.sum(weight * rough.geo.dA), rel=1e-13, abs=0)

    def test_uses_the_pattern_of_the_mesh(self, rough):
        M, pattern = mass_matrix(rough.geo), rough.mesh.pattern
        np.testing.assert_array_equal(M.indices, pattern.indices)
        np.testing.assert_array_equal(M.indptr, pattern.indptr)


class TestStiffness:
    def test_kills_constants(self, rough):
        ones = np.ones(rough.mesh.node_count)
        np.testing.assert_allclose(stiffness_matrix(rough.geo) @ ones, 0.0, rtol=0, atol=1e-11)

    def test_is_symmetric(self, rough):
        A = stiffness_matrix(rough.geo)
        assert abs(A - A.T).max() < 1e-13

    def test_is_positive_up_to_constants(self, rough):
        eigenvalues = np.linalg.eigvalsh(stiffness_matrix(rough.geo).toarray())
        assert abs(eigenvalues[0]) < 1e-11
        assert eigenvalues[1] > 1e-3

    def test_identity_has_energy_twice_the_area(self, rough):
        """|grad x|^2 is the trace of the tangential projection."""
        energy = np.sum(rough.x * (stiffness_matrix(rough.geo) @ rough.x))
        assert energy == pytest.approx(2 * area(rough.geo), rel=1e-12, abs=0)

    def test_is_that_of_the_loops(self, rough):
        expected = longhand.stiffness(rough.mesh, list(longhand.points_of(rough.mesh, rough.x)))
        np.testing.assert_allclose(
            stiffness_matrix(rough.geo).toarray(), expected, rtol=0, atol=1e-11
        )

    def test_does_not_see_the_size(self, rough):
        large = geometry(rough.mesh, 7.0 * rough.x)
        A = stiffness_matrix(rough.geo)
        np.testing.assert_allclose(stiffness_matrix(large).data, A.data, rtol=0, atol=1e-11)


class TestLoads:
    def test_load_of_one_is_mass_times_one(self, rough):
        ones = np.ones(rough.mesh.node_count)
        expected = mass_matrix(rough.geo) @ ones
        np.testing.assert_allclose(load(rough.geo, 1 + 0 * rough.geo.dA), expected, **ROUNDING)

    @pytest.mark.parametrize("shape", [(), (1,), (3,)])
    def test_load_is_that_of_the_loops(self, rough, shape):
        g = np.random.default_rng(0).standard_normal((*rough.geo.dA.shape, *shape))
        expected = np.zeros((rough.mesh.node_count, *shape))
        Q = rough.geo.dA.shape[1]
        for count, p in enumerate(longhand.points_of(rough.mesh, rough.x)):
            for i, node in enumerate(p.nodes):
                expected[node] += p.weight * p.phi[i] * g[p.element, count % Q]
        np.testing.assert_allclose(load(rough.geo, g), expected, **ROUNDING)

    def test_gradient_load_is_that_of_the_loops(self, rough):
        G = np.random.default_rng(0).standard_normal((*rough.geo.dA.shape, 3, 2))
        expected = np.zeros((rough.mesh.node_count, 2))
        Q = rough.geo.dA.shape[1]
        for count, p in enumerate(longhand.points_of(rough.mesh, rough.x)):
            for i, node in enumerate(p.nodes):
                for a in range(3):
                    expected[node] += p.weight * p.grad[i, a] * G[p.element, count % Q, a]
        np.testing.assert_allclose(gradient_load(rough.geo, G), expected, **ROUNDING)

    def test_gradient_load_sums_to_zero(self, rough):
        """The basis sums to one, so its gradients sum to nothing."""
        G = np.random.default_rng(0).standard_normal((*rough.geo.dA.shape, 3, 3))
        total = gradient_load(rough.geo, G).sum(axis=0)
        np.testing.assert_allclose(total, 0.0, rtol=0, atol=1e-11)

    def test_gradient_load_of_gradient_is_stiffness(self, rough):
        expected = stiffness_matrix(rough.geo) @ rough.u
        result = gradient_load(rough.geo, gradient(rough.geo, rough.u))
        np.testing.assert_allclose(result, expected, rtol=0, atol=1e-11)

    def test_normal_flux_loads_nothing(self, rough):
        loaded = gradient_load(rough.geo, rough.geo.normal[..., None])
        np.testing.assert_allclose(loaded, 0.0, **ROUNDING)


class TestRenumbering:
    def test_permutes_rows_and_columns(self, rough):
        mesh, N = rough.mesh, rough.mesh.node_count
        new = np.random.default_rng(1).permutation(N)
        turned = Mesh(mesh.degree, new[mesh.cells[:, :3]], new[mesh.cells], N)
        x = np.empty_like(rough.x)
        x[new] = rough.x
        P = sp.csr_array((np.ones(N), (new, np.arange(N))), shape=(N, N))
        for matrix in (mass_matrix, stiffness_matrix):
            expected = P @ matrix(rough.geo) @ P.T
            result = matrix(geometry(turned, x))
            np.testing.assert_allclose(result.toarray(), expected.toarray(), rtol=0, atol=1e-12)
