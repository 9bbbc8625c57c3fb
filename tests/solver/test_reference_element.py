"""The P_k basis and the quadrature: what a Lagrange basis is, and what a rule promises."""

from itertools import pairwise
from math import factorial

import numpy as np
import pytest

from esfem.solver.reference_element import DEGREES, lattice, reference_element, tabulate

each_degree = pytest.mark.parametrize("k", DEGREES)
POINTS = np.random.default_rng(0).dirichlet(np.ones(3), size=20)[:, 1:]
# A few roundings of numbers of size one; the P_4 basis has coefficients up to about 100.
ROUNDING = {"rtol": 0, "atol": 1e-12}


def monomials(k: int) -> list[tuple[int, int]]:
    return [(a, b) for a in range(k + 1) for b in range(k + 1 - a)]


def quadrature_errors(rule, m: int) -> list[float]:
    """Relative errors on r^p s^(m-p), whose integral is p! (m-p)! / (m+2)!."""
    r, s = rule.points.T
    exact = [factorial(p) * factorial(m - p) / factorial(m + 2) for p in range(m + 1)]
    sums = [rule.weights @ (r**p * s ** (m - p)) for p in range(m + 1)]
    return [abs(a / b - 1) for a, b in zip(sums, exact, strict=True)]


class TestBasis:
    @each_degree
    def test_has_as_many_functions_as_monomials(self, k):
        assert lattice(k).shape == (len(monomials(k)), 2)

    @each_degree
    def test_sums_to_one(self, k):
        phi, _ = tabulate(k, POINTS)
        np.testing.assert_allclose(phi.sum(axis=1), 1.0, **ROUNDING)

    @each_degree
    def test_is_nodal(self, k):
        phi, _ = tabulate(k, lattice(k))
        np.testing.assert_allclose(phi, np.eye(len(phi)), **ROUNDING)

    @each_degree
    def test_reproduces_polynomials(self, k):
        phi, _ = tabulate(k, POINTS)
        for a, b in monomials(k):
            nodal = lattice(k)[:, 0] ** a * lattice(k)[:, 1] ** b
            np.testing.assert_allclose(
                phi @ nodal, POINTS[:, 0] ** a * POINTS[:, 1] ** b, **ROUNDING
            )

    @each_degree
    def test_derivatives_are_those_of_polynomials(self, k):
        _, dphi = tabulate(k, POINTS)
        r, s = POINTS.T
        for a, b in monomials(k):
            nodal = lattice(k)[:, 0] ** a * lattice(k)[:, 1] ** b
            exact = [a * r ** max(a - 1, 0) * s**b, b * r**a * s ** max(b - 1, 0)]
            np.testing.assert_allclose(dphi @ nodal, np.stack(exact, axis=1), **ROUNDING)

    @each_degree
    def test_lattice_is_equispaced(self, k):
        """Each node once: k times the lattice are the integers i, j >= 0 with i + j <= k."""
        integers = k * lattice(k)
        np.testing.assert_allclose(integers, np.rint(integers), **ROUNDING)
        assert {tuple(node) for node in np.rint(integers).astype(int)} == set(monomials(k))

    @each_degree
    def test_nodes_are_vertices_then_edges_then_interior(self, k):
        r, s = lattice(k).T
        zeros = np.isclose([1 - r - s, r, s], 0.0, rtol=0, atol=1e-14)  # barycentric coordinates
        assert list(zeros.sum(axis=0)) == [2] * 3 + [1] * 3 * (k - 1) + [0] * (
            (k - 1) * (k - 2) // 2
        )
        for edge in range(3):  # edge i lies opposite to vertex i
            assert zeros[edge, 3 + edge * (k - 1) : 3 + (edge + 1) * (k - 1)].all()


class TestQuadrature:
    @each_degree
    def test_default_is_exact_to_2k_plus_2(self, k):
        for m in range(2 * k + 3):
            assert max(quadrature_errors(reference_element(k), m)) < 1e-13  # rounding

    @pytest.mark.parametrize("exactness", range(1, 17))
    def test_exact_to_its_degree(self, exactness):
        rule = reference_element(2, exactness)
        for m in range(exactness + 1):
            assert max(quadrature_errors(rule, m)) < 1e-13

    @pytest.mark.parametrize("exactness", range(1, 17))
    def test_not_exact_beyond_its_degree(self, exactness):
        rule = reference_element(2, exactness)
        assert max(quadrature_errors(rule, exactness + 1)) > 1e-6

    @each_degree
    def test_points_lie_inside_and_weights_are_positive(self, k):
        rule = reference_element(k)
        assert (rule.weights > 0).all()
        assert (np.column_stack([rule.points, 1 - rule.points.sum(axis=1)]) > 0).all()

    def test_finer_rules_have_more_points(self):
        counts = [len(reference_element(1, m).weights) for m in (2, 6, 10, 14)]
        assert all(a < b for a, b in pairwise(counts))


class TestTables:
    @each_degree
    def test_values_are_the_basis_at_the_quadrature_points(self, k):
        element = reference_element(k)
        phi, dphi = tabulate(k, element.points)
        np.testing.assert_array_equal(element.phi, phi)
        np.testing.assert_array_equal(element.dphi, dphi)

    @each_degree
    def test_mass_table_holds_products_of_values(self, k):
        element = reference_element(k)
        n = len(element.nodes)
        for p, row in enumerate(element.mass_table.T):
            expected = np.outer(element.phi[p], element.phi[p])
            np.testing.assert_allclose(row.reshape(n, n), expected, rtol=1e-14, atol=0)

    @each_degree
    def test_stiffness_table_contracts_with_the_inverse_metric(self, k):
        """Column (rs, p) times (G00, G01, G11) is grad phi_i . G grad phi_j for any symmetric G."""
        element = reference_element(k)
        n, G = len(element.nodes), np.array([[2.0, 0.7], [0.7, 3.0]])
        table = element.stiffness_table.reshape(n, n, 3, len(element.weights))
        for p, entries in enumerate(table.transpose(3, 2, 0, 1)):
            expected = element.dphi[p].T @ G @ element.dphi[p]
            contracted = np.tensordot([G[0, 0], G[0, 1], G[1, 1]], entries, axes=1)
            np.testing.assert_allclose(contracted, expected, **ROUNDING)


class TestBadInput:
    @pytest.mark.parametrize("wrong", [0, 5, -1, 2.5, "2"])
    @pytest.mark.parametrize("function", [lattice, reference_element])
    def test_degree_out_of_range_is_refused(self, function, wrong):
        with pytest.raises(ValueError, match=rf"degree = {wrong!r}: must be one of \(1, 2, 3, 4\)"):
            function(wrong)

    @pytest.mark.parametrize("wrong", [0, -2])
    def test_quadrature_degree_below_one_is_refused(self, wrong):
        with pytest.raises(ValueError, match=f"quadrature_degree = {wrong}: must be at least 1"):
            reference_element(2, wrong)
