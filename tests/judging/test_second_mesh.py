"""A plateau in tau is blamed on the mesh only if a second one shows it."""

import numpy as np
import pandas as pd
import pytest
from judged import grid

from esfem.judging import Floor, judge_table
from esfem.judging.second_mesh import falls_with_h

TAUS = 0.1 * 0.5 ** np.arange(5)
ONE, TWO = np.array([0.1]), np.array([0.2, 0.1])


def judged(e, h, **options):
    """The judgement on the order 2 in tau of errors e(h, tau)."""
    return judge_table(grid(e, h, TAUS), 2.0, direction="tau", other_order=2.0, **options)


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
    assert (found.outcome, found.cause) == ("inconclusive", "h plateau")
    assert "a second mesh shows whether the error is in space" in found.next_run
    assert "h = 0.05" in found.next_run


@pytest.mark.parametrize("error", [constant, scattered])
def test_errors_that_fall_with_neither_fail(error):
    found = judged(error, TWO)
    assert found.outcome == "fail"
    assert error is scattered or found.cause == "does not fall with tau, nor with h"


def test_errors_that_fall_with_h_alone_are_in_space():
    found = judged(lambda h, tau: h**2 * (1 + 1e-3 * np.sin(1e3 * tau)), TWO)
    assert (found.outcome, found.cause) == ("inconclusive", "h plateau")


def test_in_h_the_same_number_on_every_mesh_fails():
    found = judge_table(pd.DataFrame({"h": TAUS, "error": 0.3}), 2.0)
    assert (found.outcome, found.cause) == ("fail", "refinement not applied")


@pytest.mark.parametrize(("share", "falls"), [(0.05, False), (0.2, True), (1.0, True)])
def test_a_tenth_of_the_finer_error_must_fall_with_h(share, falls):
    runs = grid(lambda h, tau: (1 - share) + share * (h / 0.1) ** 2, TWO, TAUS)
    assert falls_with_h(runs, 2.0) is falls


def test_meshes_are_compared_at_the_same_time_step():
    runs = grid(lambda h, tau: h**2 + 100 * tau, TWO, TAUS)
    alone = runs[(runs["h"] == 0.2) & (runs["tau"] > 0.02) | (runs["h"] == 0.1)]
    assert falls_with_h(alone, 2.0) is False  # at tau = .025 the time step rules both
    assert falls_with_h(alone[alone["h"] == 0.1], 2.0) is None


def test_a_run_without_error_is_no_second_mesh():
    runs = grid(constant, TWO, TAUS)
    runs.loc[runs["h"] == 0.2, "error"] = np.nan
    assert falls_with_h(runs, 2.0) is None


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
        assert (found.outcome, found.cause) == ("inconclusive", "tau")
        assert all(run.floor == "tau" for run in found.masked) and len(found.masked) >= 4
