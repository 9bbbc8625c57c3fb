"""A plateau in tau is blamed on the mesh only if a second one shows it."""

import numpy as np
import pytest
from judged import grid

from esfem.judging import Floor, judge_table
from esfem.judging.second_mesh import falls_with_h
from esfem.judging.validate import validated

TAUS = 0.1 * 0.5 ** np.arange(5)
ONE, TWO = np.array([0.1]), np.array([0.2, 0.1])


def judged(e, h, **options):
    """The judgement on the order 2 in tau of errors e(h, tau)."""
    return judge_table(grid(e, h, TAUS), 2.0, direction="tau", other_order=2.0, **options)


def falls(table):
    """Whether a finer mesh has a smaller error, where order 2 in h is expected."""
    return falls_with_h(validated(table, "tau"), 2.0)


def constant(h, tau):
    return 0.3 + 0 * h


def scattered(h, tau):
    """No two numbers are the same; neither h nor tau matters."""
    return 0.3 + 1e-3 * np.sin(1e3 * tau + 7 * h)


def levelling(h, tau):
    return tau**2 + 1e-3


@pytest.mark.parametrize("error", [constant, scattered, levelling])
def test_on_one_mesh_nobody_knows_and_a_second_one_is_asked_for(error):
    found = judged(error, ONE)
    assert (found.outcome, found.code) == ("inconclusive", "plateau")
    assert "second mesh" in found.next_run and "h = 0.05" in found.next_run


@pytest.mark.parametrize("error", [constant, scattered])
def test_errors_that_fall_with_neither_fail(error):
    found = judged(error, TWO)
    assert found.outcome == "fail"
    assert error is scattered or found.cause == "the errors do not fall with tau, nor with h"


def test_errors_that_fall_with_h_alone_are_in_space():
    found = judged(lambda h, tau: h**2 * (1 + 1e-3 * np.sin(1e3 * tau)), TWO)
    assert (found.outcome, found.code) == ("inconclusive", "plateau")
    assert "space" in found.cause


@pytest.mark.parametrize(("share", "found"), [(0.05, False), (0.2, True), (1.0, True)])
def test_a_tenth_of_the_finer_error_must_fall_with_h(share, found):
    assert falls(grid(lambda h, tau: (1 - share) + share * (h / 0.1) ** 2, TWO, TAUS)) is found


def test_meshes_are_compared_at_the_same_time_step():
    table = grid(lambda h, tau: h**2 + 100 * tau, TWO, TAUS)
    alone = table[(table["h"] == 0.2) & (table["tau"] > 0.02) | (table["h"] == 0.1)]
    assert falls(alone) is False  # at tau = .025 the time step rules both
    assert falls(alone[alone["h"] == 0.1]) is None


def test_a_run_without_error_is_no_second_mesh():
    table = grid(constant, TWO, TAUS)
    table.loc[table["h"] == 0.2, "error"] = np.nan
    assert falls(table) is None


class TestMeasuredTime:
    """Where the part in time was measured, no model of it is needed."""

    def test_the_line_is_judged_without_a_joint_fit(self):
        """Added in squares, as independent errors add, which no sum of powers fits."""
        h = 0.5 ** np.arange(1, 7)
        table = grid(lambda h, tau: np.hypot(h**2, 0.03 * tau), h, (0.01, 0.005))
        floor = Floor("tau", (0.03 * table["tau"]).to_numpy())
        found = judge_table(table, 2.0, floors=[floor], other_order=1.0)
        assert found.joint is None and judge_table(table, 2.0, other_order=1.0).joint is not None
        assert found.outcome == "pass"

    def test_errors_within_ten_times_of_it_are_masked_and_rule_nothing_out(self):
        table = grid(lambda h, tau: 0.1 + h**3, 0.5 ** np.arange(1, 7), (0.01,))
        found = judge_table(table, 3.0, floors=[Floor("tau", 0.02)])
        assert (found.outcome, found.code) == ("inconclusive", "tau")
        assert all(run.floor == "tau" for run in found.masked) and len(found.masked) >= 4


@pytest.mark.parametrize("space", [lambda h: 1e-2, lambda h: 1.0 + 1e-3 * (h / 0.1) ** 4])
def test_errors_that_level_off_on_both_meshes_fail(space):
    """The coarse steps still fall; what is left falls with neither."""
    h, tau = np.repeat([0.1, 0.05], 6), np.tile(0.5 ** np.arange(1.0, 7.0), 2)
    error = tau**2 + np.array([space(width) for width in h])
    table = {"h": h, "tau": tau, "error": error}
    found = judge_table(table, 2.0, direction="tau", other_order=4.0)
    assert (found.outcome, found.code) == ("fail", "plateau")
    falls = {**table, "error": tau**2 + 1e-2 * (h / 0.1) ** 4}
    assert judge_table(falls, 2.0, direction="tau", other_order=4.0).outcome != "fail"
