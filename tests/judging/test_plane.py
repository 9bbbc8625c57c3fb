"""The posterior over a grid of runs in h and tau: errors that add as vectors."""

import numpy as np
import pytest
from judged import LADDER, TAUS

from esfem.judging import judge_table
from esfem.judging.plane import Grid, plane_posterior


def runs(p, q, rho, share=0.4, size=0.0, seed=0, taus=TAUS):
    """h^p and tau^q at an angle, the second a ``share`` of the first on the finest levels."""
    h, tau = (axis.ravel() for axis in np.meshgrid(LADDER, taus))
    a = (h / h.min()) ** p
    b = share * (tau / tau.min()) ** q
    e = np.sqrt(np.maximum(a * a + 2 * rho * a * b + b * b, 1e-12))
    return Grid(h, tau, e * np.exp(size * np.random.default_rng(seed).normal(size=len(h))))


@pytest.mark.parametrize("rho", [1.0, 0.4, 0.0, -0.5])
@pytest.mark.parametrize(("p", "q"), [(2.0, 1.0), (3.0, 2.0)])
def test_the_order_is_found_at_any_angle(p, q, rho):
    found, fit = plane_posterior(runs(p, q, rho), 2.0, q)
    assert found.quantile(0.5)[0] == pytest.approx(p, abs=0.03)
    assert fit.q == q and fit.rho == pytest.approx(rho, abs=0.15)


def test_both_parts_are_recovered():
    fit = plane_posterior(runs(2.0, 1.0, 0.0), 2.0, 1.0)[1]
    assert fit.A * LADDER[-1] ** fit.p == pytest.approx(1.0, rel=0.02)
    assert fit.other_term(TAUS[-1]) == pytest.approx(0.4, rel=0.05)
    assert fit.share == pytest.approx(0.4 / 1.4, abs=0.02)


def test_the_order_in_tau_is_found_where_nobody_knows_it():
    fit = plane_posterior(runs(2.0, 2.0, 0.0, share=2.0), 2.0, None)[1]
    assert fit.q == 2.0 and not fit.q_given


def test_the_interval_holds_the_truth_and_widens_with_the_scatter():
    widths = []
    for size in (0.01, 0.1):
        found, _ = plane_posterior(runs(1.63, 1.0, 0.3, size=size), 2.0, 1.0)
        lower, upper = found.quantile(0.025, 0.975)
        assert lower <= 1.63 <= upper
        widths.append(upper - lower)
    assert widths[1] > 2.0 * widths[0]


@pytest.mark.parametrize("p", [1.0, 2.0])
def test_parts_that_cancel_are_found_out(p):
    assert plane_posterior(runs(p, 1.0, -1.0, share=1.7, size=0.01), 2.0, 1.0)[1].cancels > 0.5


def test_parts_that_add_do_not_cancel():
    assert plane_posterior(runs(2.0, 1.0, 1.0, size=0.01), 2.0, 1.0)[1].cancels < 0.01


def test_scatter_of_the_meshes_alone_leaves_the_part_in_tau_exact():
    exact = runs(2.0, 1.0, 0.0)
    factors = np.exp(0.1 * np.random.default_rng(1).normal(size=len(LADDER)))
    grid = Grid(exact.s, exact.o, exact.e * np.tile(factors, len(TAUS)))
    fit = plane_posterior(grid, 2.0, 1.0)[1]
    assert fit.share == pytest.approx(0.4 / 1.4, abs=0.05)


def test_a_part_that_rules_leaves_the_other_unknown():
    found, fit = plane_posterior(runs(1.0, 1.0, 0.0, share=300.0, size=0.02), 2.0, 1.0)
    assert fit.share > 0.9
    assert 0.02 < found.below(1.8) < 0.98


def test_too_few_runs_tell_nothing_of_both_parts():
    assert not runs(2.0, 1.0, 0.0, taus=TAUS[:1]).enough
    assert not Grid(np.array([1.0, 0.5] * 2), np.array([1.0, 1.0, 0.5, 0.5]), np.ones(4)).enough
    assert runs(2.0, 1.0, 0.0, taus=TAUS[:2]).enough


def test_of_an_order_that_no_run_tells_nothing_absurd_is_told():
    """z of a growing Helfrich sphere, where it is zero: an error of the mesh alone."""
    h, tau = np.repeat([0.351, 0.247], 4), np.tile([0.05, 0.025, 0.0125, 0.00625], 2)
    error = np.array(
        [3.986e-06, 4.975e-06, 5.631e-06, 6.022e-06, 5.063e-07, 6.317e-07, 7.147e-07, 7.632e-07]
    )
    found = judge_table({"h": h, "tau": tau, "error": error}, 2.0, direction="tau", other_order=4.0)
    assert found.outcome not in ("pass", "super")
    assert -10.0 <= found.lower <= found.order <= found.upper <= 2.0 + 10.0
