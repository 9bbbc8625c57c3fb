"""Experimental orders: arithmetic on planted data."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from esfem.judging.eoc import fit_order, rates

UNEQUAL = np.array([1.0, 0.6, 0.45, 0.2, 0.11])
# Logarithms of numbers of order one: a few units in the last place over log ratios above 0.1.
ROUNDING = dict(rtol=0, atol=1e-12)


@pytest.mark.parametrize("order", [-1.5, 0.0, 1.0, 2.0, 3.7])
def test_rates_of_a_pure_power_are_its_order_at_unequal_ratios(order):
    np.testing.assert_allclose(rates(UNEQUAL, 3.0 * UNEQUAL**order), order, **ROUNDING)


def test_rates_of_growing_errors_are_negative():
    assert (rates([0.4, 0.2, 0.1], [1.0, 2.0, 5.0]) < 0).all()


def test_rate_is_taken_with_the_true_ratio():
    # A factor 4 at h -> h/8 is order 2/3, not 2.
    np.testing.assert_allclose(rates([0.8, 0.1], [4.0, 1.0]), 2.0 / 3.0, **ROUNDING)


@pytest.mark.parametrize("bad", [np.nan, np.inf, 0.0])
def test_pairs_with_an_unusable_error_have_no_rate(bad):
    observed = rates([0.8, 0.4, 0.2, 0.1], [1.0, bad, 0.25, 0.0625])
    assert np.isnan(observed[:2]).all()
    np.testing.assert_allclose(observed[2], 2.0, **ROUNDING)


@given(
    order=st.floats(-2, 6),
    constant=st.floats(1e-3, 1e3),
    ratios=st.lists(st.floats(0.3, 0.9), min_size=2, max_size=6),
)
def test_fit_recovers_a_pure_power(order, constant, ratios):
    h = np.cumprod([1.0, *ratios])
    fit = fit_order(h, constant * h**order)
    assert fit.order == pytest.approx(order, abs=1e-9)  # conditioning: log ratios down to 0.1
    assert fit.constant == pytest.approx(constant, rel=1e-8)
    assert fit.uncertainty < 1e-9


def test_fit_uncertainty_is_that_of_the_textbook_regression():
    from scipy.stats import linregress

    h = UNEQUAL
    e = h**2 * np.array([1.1, 0.9, 1.05, 0.97, 1.02])
    expected = linregress(np.log(h), np.log(e))
    fit = fit_order(h, e)
    assert fit.order == pytest.approx(expected.slope, abs=1e-12)
    assert fit.uncertainty == pytest.approx(expected.stderr, rel=1e-10)


def test_fit_of_two_levels_has_no_uncertainty():
    fit = fit_order([0.2, 0.1], [4.0, 1.0])
    assert fit.order == pytest.approx(2.0, abs=1e-12)
    assert np.isnan(fit.uncertainty)


@pytest.mark.parametrize("function", [rates, fit_order])
@pytest.mark.parametrize("h", [[0.1, 0.2], [0.2, 0.2], [0.2, -0.1], [0.2, np.nan]])
def test_mesh_widths_must_decrease(function, h):
    with pytest.raises(ValueError, match="strictly decreasing"):
        function(h, [1.0, 0.5])


@pytest.mark.parametrize("function", [rates, fit_order])
def test_lengths_must_agree(function):
    with pytest.raises(ValueError, match="one length"):
        function([0.4, 0.2, 0.1], [1.0, 0.5])


@pytest.mark.parametrize("bad", [np.nan, np.inf, 0.0, -1.0])
def test_fit_refuses_unusable_errors(bad):
    with pytest.raises(ValueError, match="positive and finite"):
        fit_order([0.4, 0.2, 0.1], [1.0, bad, 0.1])


def test_fit_needs_two_levels():
    with pytest.raises(ValueError, match="two levels"):
        fit_order([0.1], [1.0])
