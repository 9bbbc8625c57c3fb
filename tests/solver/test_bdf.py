"""BDF 1..5: exactness, generating polynomials, zero stability, and refusal of tampered data."""

from dataclasses import replace
from fractions import Fraction
from math import comb

import numpy as np
import pytest

from esfem.solver import BDF
from esfem.solver.bdf import ORDERS, extrapolation_weights

each_order = pytest.mark.parametrize("q", ORDERS)


def derivative_error(bdf: BDF, m: int) -> Fraction:
    """Of t^m at t = 3 with steps 1/2, in rational arithmetic."""
    t, tau = Fraction(3), Fraction(1, 2)
    approximate = sum(d * (t - j * tau) ** m for j, d in enumerate(bdf.delta)) / tau
    return approximate - (m * t ** (m - 1) if m else 0)


def extrapolation_error(bdf: BDF, m: int) -> Fraction:
    t, tau = Fraction(3), Fraction(1, 2)
    return sum(g * (t - (1 + j) * tau) ** m for j, g in enumerate(bdf.gamma)) - t**m


class TestExactness:
    @each_order
    def test_derivative_is_exact_up_to_degree_q(self, q):
        assert [derivative_error(BDF.of_order(q), m) for m in range(q + 1)] == [0] * (q + 1)

    @each_order
    def test_derivative_is_not_exact_on_degree_q_plus_1(self, q):
        assert derivative_error(BDF.of_order(q), q + 1) != 0

    @each_order
    def test_extrapolation_is_exact_up_to_degree_q_minus_1(self, q):
        assert [extrapolation_error(BDF.of_order(q), m) for m in range(q)] == [0] * q

    @each_order
    def test_extrapolation_is_not_exact_on_degree_q(self, q):
        assert extrapolation_error(BDF.of_order(q), q) != 0


class TestCoefficients:
    @each_order
    def test_delta_is_its_generating_polynomial(self, q):
        """sum_j delta_j zeta^j = sum_{l=1}^q (1 - zeta)^l / l."""
        expected = tuple(
            sum(Fraction((-1) ** j * comb(l, j), l) for l in range(1, q + 1)) for j in range(q + 1)
        )
        assert BDF.of_order(q).delta == expected

    @each_order
    def test_gamma_is_its_generating_polynomial(self, q):
        """sum_j gamma_j zeta^j = (1 - (1 - zeta)^q) / zeta."""
        expected = tuple(Fraction((-1) ** j * comb(q, j + 1)) for j in range(q))
        assert BDF.of_order(q).gamma == expected

    @each_order
    def test_order_is_its_key(self, q):
        assert BDF.of_order(q).order == q

    def test_table_holds_the_orders(self):
        assert tuple(BDF.TABLE) == ORDERS == (1, 2, 3, 4, 5)


class TestStability:
    @each_order
    def test_root_condition(self, q):
        """Roots of sum_j delta_j z^(q-j): one is 1 and simple, the others lie inside the circle."""
        roots = np.roots([float(d) for d in BDF.of_order(q).delta])
        roots = roots[np.argsort(-abs(roots))]
        # A simple root of a polynomial with coefficients of size one, to rounding.
        np.testing.assert_allclose(roots[0], 1.0, rtol=0, atol=1e-12)
        assert (abs(roots[1:]) < 0.75).all()  # BDF5: 0.71

    @each_order
    def test_stable_on_the_negative_real_axis(self, q):
        """u' = -lambda u decays however large lambda tau > 0 is: A(0)-stability."""
        delta = np.array([float(d) for d in BDF.of_order(q).delta])
        for stiffness in np.logspace(-3, 6, 40):
            polynomial = delta + np.r_[stiffness, np.zeros(q)]
            assert (abs(np.roots(polynomial)) < 1).all()


class TestExtrapolationOfEuler:
    @pytest.mark.parametrize("columns", [1, 2, 3, 4, 5])
    def test_leaves_no_power_of_the_step_below_columns(self, columns):
        """Of c_0 + c_1/m + c_2/m^2 + ... c_0 stays, and the next columns - 1 terms vanish."""
        weights = extrapolation_weights(columns)
        for power in range(columns):
            left = sum(w / m**power for m, w in enumerate(weights, start=1))
            assert left == pytest.approx(float(power == 0), abs=1e-12)
        beyond = sum(w / m**columns for m, w in enumerate(weights, start=1))
        assert abs(beyond) > 1e-3


class TestBadInput:
    @each_order
    def test_any_tampered_delta_is_refused(self, q):
        bdf = BDF.of_order(q)
        for j in range(q + 1):
            delta = list(bdf.delta)
            delta[j] += Fraction(1, 10**6)
            with pytest.raises(ValueError, match=r"delta = .*not exact on t\^0"):
                replace(bdf, delta=tuple(delta))

    @each_order
    def test_any_tampered_gamma_is_refused(self, q):
        bdf = BDF.of_order(q)
        for j in range(q):
            gamma = list(bdf.gamma)
            gamma[j] -= Fraction(1, 10**6)
            with pytest.raises(ValueError, match=r"gamma = .*not exact on t\^0"):
                replace(bdf, gamma=tuple(gamma))

    @pytest.mark.parametrize("q", [2, 3, 4, 5])
    def test_delta_of_lower_order_is_refused(self, q):
        lower = (*BDF.of_order(q - 1).delta, Fraction(0))
        with pytest.raises(ValueError, match=rf"not exact on t\^{q}, so not of order {q}"):
            replace(BDF.of_order(q), delta=lower)

    @pytest.mark.parametrize("q", [2, 3, 4, 5])
    def test_gamma_of_lower_order_is_refused(self, q):
        lower = (*BDF.of_order(q - 1).gamma, Fraction(0))
        with pytest.raises(ValueError, match=rf"gamma.*not exact on t\^{q - 1}"):
            replace(BDF.of_order(q), gamma=lower)

    @each_order
    def test_wrong_number_of_coefficients_is_refused(self, q):
        bdf = BDF.of_order(q)
        with pytest.raises(
            ValueError, match=f"delta: must have {q + 1} coefficients for order {q}"
        ):
            replace(bdf, delta=bdf.delta[:-1])

    @pytest.mark.parametrize("wrong", [0, 6, -1, 2.5, "2", None])
    def test_unknown_order_is_refused(self, wrong):
        with pytest.raises(ValueError, match=r"bdf = .*: must be one of \(1, 2, 3, 4, 5\)"):
            BDF.of_order(wrong)
