"""F1, F2, f2, g1, g2 against the longhand loops, with random u and w on a rough torus."""

import longhand
import numpy as np
import pytest

from esfem.solver import forms
from esfem.solver.geometry import geometry
from esfem.solver.laws import willmore

TERMS = ("grad_H_squared", "A_squared", "divergence", "grad_Q", "Q_H")


@pytest.fixture(params=[1, 2, 3], scope="module")
def rough(make_rough, request):
    """Module scope, for the loops are slow: geometry, fields and longhand points of degree k."""
    rough = make_rough(request.param)
    rough.geo = geometry(rough.mesh, rough.x)
    rough.points = list(longhand.points_of(rough.mesh, rough.x))
    rough.curvature = forms.curvature(rough.geo, rough.u, willmore, 0.0)
    return rough


def assert_same_dual_vector(result, expected):
    """Up to rounding of sums over about 2000 points, against the largest entry."""
    np.testing.assert_allclose(result, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


class TestLonghand:
    def test_F1(self, rough):
        expected = longhand.F1(rough.mesh, rough.points, rough.u, rough.w[:, 0])
        assert_same_dual_vector(forms.F(rough.geo, rough.curvature, rough.w)[:, 0], expected)

    def test_F2(self, rough):
        expected = longhand.F2(rough.mesh, rough.points, rough.u, rough.w[:, 1:])
        assert_same_dual_vector(forms.F(rough.geo, rough.curvature, rough.w)[:, 1:], expected)

    def test_f2(self, rough):
        expected = longhand.f2(rough.mesh, rough.points, rough.u)
        assert_same_dual_vector(forms.loads(rough.geo, rough.curvature)[0][:, 1:], expected)

    def test_g1(self, rough):
        expected = longhand.g1(rough.mesh, rough.points, rough.u)
        assert_same_dual_vector(forms.loads(rough.geo, rough.curvature)[1][:, 0], expected)

    def test_g2(self, rough):
        expected = longhand.g2(rough.mesh, rough.points, rough.u)
        assert_same_dual_vector(forms.loads(rough.geo, rough.curvature)[1][:, 1:], expected)

    def test_every_term_of_f2_is_seen(self, rough):
        """The comparison is not blind to a term: each is far larger than its tolerance."""
        terms = longhand.f2_terms(rough.mesh, rough.points, rough.u)
        assert tuple(terms) == TERMS
        largest = np.abs(sum(terms.values())).max()
        assert all(np.abs(term).max() > 1e-3 * largest for term in terms.values())


class TestStructure:
    def test_f_has_nothing_for_the_H_equation(self, rough):
        np.testing.assert_array_equal(forms.loads(rough.geo, rough.curvature)[0][:, 0], 0.0)

    def test_F_is_linear(self, rough):
        geo, c, w = rough.geo, rough.curvature, rough.w
        other = np.random.default_rng(9).standard_normal(w.shape)
        expected = 2.0 * forms.F(geo, c, w) - 3.0 * forms.F(geo, c, other)
        assert_same_dual_vector(forms.F(geo, c, 2.0 * w - 3.0 * other), expected)

    def test_F_is_symmetric(self, rough):
        geo, c, w = rough.geo, rough.curvature, rough.w
        other = np.random.default_rng(9).standard_normal(w.shape)
        left, right = np.sum(other * forms.F(geo, c, w)), np.sum(w * forms.F(geo, c, other))
        scale = np.linalg.norm(other) * np.linalg.norm(forms.F(geo, c, w))
        np.testing.assert_allclose(left, right, rtol=0, atol=1e-12 * scale)

    def test_shape_operator_is_symmetric(self, rough):
        S = rough.curvature.S
        np.testing.assert_array_equal(S, np.swapaxes(S, -1, -2))

    def test_law_is_evaluated_at_the_points_and_time(self, rough):
        def law(H, S2, x, t):
            return t * x[..., 2]

        Q = forms.curvature(rough.geo, rough.u, law, 3.0).Q
        np.testing.assert_array_equal(Q, 3.0 * rough.geo.points[..., 2])
