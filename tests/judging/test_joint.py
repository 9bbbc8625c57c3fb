"""The joint fit A h^p + B tau^q over a grid."""

import numpy as np
import pytest
from judged import LADDER, TAUS, grid

from esfem.judging.joint import joint_fit


def fitted(errors, q=None, taus=TAUS):
    table = grid(errors, taus=taus)
    return joint_fit(*table[["h", "tau", "error"]].to_numpy().T, q)


@pytest.mark.parametrize(("p", "q"), [(1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (4.0, 3.0)])
def test_both_terms_are_recovered(p, q):
    fit = fitted(lambda h, tau: 0.7 * h**p + 3.0 * tau**q)
    assert (fit.A, fit.p, fit.B, fit.q) == pytest.approx((0.7, p, 3.0, q), rel=1e-5)
    assert not fit.cancels


def test_the_interval_holds_the_truth_and_widens_with_the_scatter():
    widths = []
    for size in (0.01, 0.05):
        noise = np.exp(size * np.random.default_rng(0).normal(size=len(LADDER) * len(TAUS)))
        fit = fitted(lambda h, tau, noise=noise: (h**2 + 2.0 * tau**2) * noise)
        assert fit.p_interval[0] <= 2.0 <= fit.p_interval[1]
        widths.append(np.ptp(fit.p_interval))
    assert widths[1] > 3.0 * widths[0]


@pytest.mark.parametrize(("p", "B"), [(1.0, 1.0), (2.0, 0.5), (2.0, 2.0)])
def test_terms_that_cancel_are_found_out(p, B):
    fit = fitted(lambda h, tau: np.abs(h**p - B * tau))
    assert fit.cancels


def test_two_time_steps_take_the_order_in_tau_as_given():
    fit = fitted(lambda h, tau: h**2 + 3.0 * tau**2, q=2.0, taus=(0.1, 0.05))
    assert fit.q_given and fit.q == 2.0
    assert (fit.p, fit.B) == pytest.approx((2.0, 3.0), rel=1e-5)


def test_two_time_steps_without_a_given_order_leave_the_most_to_tau():
    """B tau^2 = 0.03 and 0.0075; by q = 1 the finer one would be 0.0225."""
    fit = fitted(lambda h, tau: h**2 + 3.0 * tau**2, taus=(0.1, 0.05))
    assert fit.q_given and fit.q == 1.0
    assert fit.other_term(0.05) == pytest.approx(0.0225, rel=0.3)


def test_too_few_runs_have_no_joint_fit():
    assert fitted(lambda h, tau: h + tau, taus=(0.1,)) is None
    h, tau = np.array([1.0, 0.5, 1.0, 0.5]), np.array([1.0, 1.0, 0.5, 0.5])
    assert joint_fit(h, tau, h + tau, None) is None


def test_a_term_that_is_not_there_is_small():
    fit = fitted(lambda h, tau: h**2)
    assert fit.other_term(TAUS[0]) < 1e-6 * LADDER[-1] ** 2
