"""Verdicts on tables of known order."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from judged import LADDER, TAUS, grid, line, scattered

from esfem.judging import Floor, judge_table, worst
from esfem.judging.judgement import EXIT, SEVERITY

SHAPES = {
    "pure": lambda h: h**2 * scattered(4, 0.02),
    "low": lambda h: h * scattered(5, 0.02),
    "high": lambda h: h**3 * scattered(6, 0.02),
    "two powers": lambda h: 10 * h**3 + 0.03 * h,
    "plateau": lambda h: h**2 + 0.05,
    "growing": lambda h: 1 / h,
    "no order": lambda h: scattered(7, 1.0),
}


class TestOutcome:
    @pytest.mark.parametrize(
        ("order", "outcome"),
        [
            *((2.0, "pass"), (1.85, "pass"), (2.15, "pass"), (2.3, "super"), (3.4, "super")),
            *((3.6, "suspect"), (1.7, "fail"), (1.0, "fail"), (-1.0, "fail")),
        ],
    )
    def test_a_pure_power_is_judged_by_its_order(self, order, outcome):
        judgement = judge_table(line(lambda h: 0.7 * h**order), 2.0)
        assert judgement.outcome == outcome
        assert judgement.order == pytest.approx(order, abs=1e-8)
        assert judgement.constant == pytest.approx(0.7, rel=1e-8)

    def test_a_declared_superconvergence_is_not_suspect(self):
        table = line(lambda h: h**4)
        assert judge_table(table, 2.0, declared_super=True).outcome == "super"

    def test_a_lower_power_not_ruled_out_forbids_super(self):
        """h^3.12 and 74 % of h^1.25 on the finest level, with scatter: the claim 2 is not kept."""
        h = 0.952656 * 0.5 ** np.arange(7)
        errors = [97.6896, 11.2494, 1.23357, 0.12085, 0.0125689, 1.46847e-3, 3.21645e-4]
        judgement = judge_table(pd.DataFrame({"h": h, "error": errors}), 2.0)
        assert judgement.outcome == "inconclusive" and judgement.lower > 2.2

    def test_growing_errors_have_a_negative_order(self):
        judgement = judge_table(line(lambda h: 1 / h), 1.0)
        assert judgement.outcome == "fail" and judgement.upper < 0

    def test_identical_errors_fail(self):
        judgement = judge_table(line(lambda h: 0 * h + 0.3), 2.0)
        assert (judgement.outcome, judgement.cause) == ("fail", "refinement not applied")

    @pytest.mark.parametrize("claim", [2.0, 3.0])
    def test_ten_cubes_and_a_little_first_order_are_no_higher_order(self, claim):
        """The slopes over h = 0.14 .. 0.025 run from 2.7 to 1.3."""
        table = line(lambda h: 10 * h**3 + 0.03 * h, 0.2 * LADDER)
        assert np.polyfit(np.log(table["h"]), np.log(table["error"]), 1)[0] > 1.8
        assert judge_table(table, claim).outcome in ("inconclusive", "fail")

    @pytest.mark.parametrize("levels", [2, 3, 4])
    def test_too_few_levels_are_inconclusive(self, levels):
        judgement = judge_table(line(lambda h: h**2, LADDER[:levels]), 2.0)
        assert (judgement.outcome, judgement.cause) == ("inconclusive", "too few levels")

    def test_scatter_is_named_and_the_levels_it_needs(self):
        table = line(LADDER**2 * [1.2, 0.8, 1.2, 1.2, 0.8, 1.2])
        judgement = judge_table(table, 2.0)
        assert (judgement.outcome, judgement.cause) == ("inconclusive", "noise")
        assert "more level" in judgement.next_run

    @pytest.mark.parametrize("order", [1.8, 2.2])
    def test_an_interval_across_the_bound_decides_nothing(self, order):
        judgement = judge_table(line(LADDER**order * scattered(8, 0.04)), 2.0)
        assert judgement.lower < order < judgement.upper
        assert judgement.outcome == "inconclusive"

    def test_a_plateau_asks_for_smaller_time_steps(self):
        judgement = judge_table(line(lambda h: h**2 + 0.03).assign(tau=0.1), 2.0)
        assert (judgement.outcome, judgement.cause) == ("inconclusive", "tau plateau")
        assert "tau = 0.025" in judgement.next_run

    def test_a_slow_start_is_pre_asymptotic(self):
        judgement = judge_table(line(lambda h: h**2 / (1 + 2 * h) ** 3), 2.0)
        assert (judgement.outcome, judgement.cause) == ("inconclusive", "pre-asymptotic")
        assert judgement.upper >= 2.0

    @pytest.mark.parametrize("e", [lambda h: h**2 / (1 + 2 * h), lambda h: h**2 + 3 * h**4])
    def test_a_trend_that_the_claimed_order_explains_settles(self, e):
        judgement = judge_table(line(e), 2.0)
        assert abs(judgement.order - 2.0) > 0.2
        assert judgement.outcome == "pass"

    def test_errors_that_jump_are_never_green(self):
        judgement = judge_table(line([1e3, 1e2, 1e1, 1e-1, 1e-3, 1e-3]), 2.0, declared_super=True)
        assert (judgement.outcome, judgement.cause) == ("inconclusive", "noise")

    def test_a_declared_superconvergence_needs_the_lower_bound_alone(self):
        table = line(LADDER**2.3 * scattered(3, 0.04))
        assert judge_table(table, 2.0).outcome == "inconclusive"
        assert judge_table(table, 2.0, declared_super=True).outcome == "pass"

    def test_a_stationary_solution_exercises_no_order_in_tau(self):
        table = line(lambda h: h**2).rename(columns={"h": "tau"}).assign(h=0.1)
        judgement = judge_table(table, 2.0, direction="tau", stationary=True)
        assert judgement.outcome == "not exercised"

    def test_an_order_in_tau_is_judged_alike(self):
        table = line(lambda h: h**2).rename(columns={"h": "tau"}).assign(h=0.1)
        assert judge_table(table, 2.0, direction="tau").outcome == "pass"
        assert judge_table(table, 3.0, direction="tau").outcome == "fail"


class TestInvariance:
    @pytest.mark.parametrize("shape", SHAPES)
    @settings(max_examples=10, deadline=None)
    @given(error_unit=st.floats(1e-6, 1e6), h_unit=st.floats(1e-3, 1e3))
    def test_units_change_no_verdict(self, shape, error_unit, h_unit):
        table = line(SHAPES[shape])
        scaled = pd.DataFrame({"h": h_unit * table["h"], "error": error_unit * table["error"]})
        one, other = judge_table(table, 2.0), judge_table(scaled, 2.0)
        assert (one.outcome, one.cause, one.also) == (other.outcome, other.cause, other.also)
        assert other.order == pytest.approx(one.order, abs=1e-8)

    @pytest.mark.parametrize("shape", SHAPES)
    def test_the_order_of_rows_changes_nothing(self, shape):
        table = grid(lambda h, tau: 0.3 * tau**2).assign(h=np.tile(LADDER, 3))
        table["error"] += np.tile(SHAPES[shape](LADDER), 3)
        shuffled = table.sample(frac=1.0, random_state=1)
        assert str(judge_table(shuffled, 2.0)) == str(judge_table(table, 2.0))

    @pytest.mark.parametrize("order", [1.0, 2.0, 3.0])
    @pytest.mark.parametrize("where", ["fine", "coarse"])
    def test_a_further_level_on_the_line_changes_no_verdict(self, order, where):
        h = 0.7 * 0.5 ** (np.arange(7) / 2)
        table = line(lambda h: h**order, h[1:] if where == "coarse" else h[:-1])
        longer = line(lambda h: h**order, h)
        assert judge_table(longer, 2.0).outcome == judge_table(table, 2.0).outcome

    def test_the_table_is_not_changed(self):
        table = grid(lambda h, tau: h**2 + tau)
        before = table.copy()
        judge_table(table, 2.0)
        pd.testing.assert_frame_equal(table, before)


class TestMasks:
    def test_runs_near_a_floor_are_masked_and_listed(self):
        table = line(lambda h: h**2)
        floor = 0.15 * table["error"].iloc[-1]
        judgement = judge_table(table, 2.0, floors=[Floor("solver", floor)])
        assert judgement.outcome == "pass" and len(judgement.window) == 5
        (masked,) = judgement.masked
        assert (masked.h, masked.floor) == (LADDER[-1], "solver")
        assert "within 10 times" in masked.reason

    def test_a_floor_may_have_a_value_for_each_row(self):
        table = line(lambda h: h**2)[::-1]
        values = np.where(table["h"] == LADDER[0], table["error"], 0.0)
        judgement = judge_table(table, 2.0, floors=[Floor("quadrature", tuple(values))])
        assert [m.h for m in judgement.masked] == [LADDER[0]]

    def test_errors_at_rounding_exercise_no_order(self):
        table = line(1e-13 * scattered(1, 0.5))
        judgement = judge_table(table, 2.0, floors=[Floor("rounding", 1e-12)])
        assert judgement.outcome == "not exercised" and len(judgement.masked) == len(table)

    def test_a_measured_time_error_leaves_constant_errors_no_excuse(self):
        table = line(scattered(3, 0.01))
        assert judge_table(table, 2.0).cause == "tau plateau"
        assert judge_table(table, 2.0, floors=[Floor("tau", 1e-9)]).outcome == "fail"

    @pytest.mark.parametrize(("gone", "cause"), [(5, "diverged cells"), (2, "diverged cells")])
    def test_a_hole_is_not_bridged(self, gone, cause):
        table = line(lambda h: h**2).assign(status="ok")
        table.loc[gone, ["error", "status"]] = (np.nan, "diverged")
        judgement = judge_table(table, 2.0)
        assert (judgement.outcome, judgement.cause) == ("inconclusive", cause)
        assert "diverged" in [m.reason for m in judgement.masked]
        assert f"h = {LADDER[gone]:.3g}" in judgement.next_run

    def test_a_coarse_run_that_failed_is_left_out_and_listed(self):
        table = line(lambda h: h**2)
        table.loc[0, "error"] = np.nan
        judgement = judge_table(table, 2.0)
        assert judgement.outcome == "pass"
        assert [(m.h, m.reason) for m in judgement.masked] == [(LADDER[0], "no error")]

    def test_an_error_of_zero_is_masked(self):
        table = line(lambda h: h**2)
        table.loc[5, "error"] = 0.0
        judgement = judge_table(table, 2.0)
        assert [m.floor for m in judgement.masked] == ["rounding"]


class TestGrid:
    @pytest.mark.parametrize(("order", "outcome"), [(2.0, "pass"), (1.0, "fail"), (3.0, "super")])
    def test_the_term_in_tau_is_taken_away(self, order, outcome):
        table = grid(lambda h, tau: h**order + 2.0 * (tau / 0.1) ** 2 * LADDER[-1] ** order)
        finest = table[table["tau"] == TAUS[-1]].drop(columns="tau")
        judgement = judge_table(table, 2.0)
        assert judgement.outcome == outcome
        assert judgement.order == pytest.approx(order, abs=1e-3)
        assert judge_table(finest, 2.0).order < order - 0.02

    def test_the_interval_covers_that_of_the_joint_fit(self):
        """The finest line is exact; the others scatter, and with them the joint fit."""
        table = grid(lambda h, tau: h**2 + 0.1 * tau)
        coarse = table["tau"] > TAUS[-1]
        table.loc[coarse, "error"] *= scattered(1, 0.03, coarse.sum())
        judgement = judge_table(table, 2.0)
        lower, upper = judgement.joint.p_interval
        assert judgement.lower <= lower < upper <= judgement.upper

    def test_what_tau_rules_is_masked(self):
        judgement = judge_table(grid(lambda h, tau: 0.001 * h + tau**2), 1.0)
        assert (judgement.outcome, judgement.cause) == ("inconclusive", "tau plateau")
        assert any("term in tau" in m.reason for m in judgement.masked)

    def test_the_order_in_tau_is_judged_on_the_finest_mesh(self):
        taus = 0.1 * 0.5 ** np.arange(5)
        table = grid(lambda h, tau: 1e-4 * h**2 + tau**2, h=LADDER[:3], taus=taus)
        judgement = judge_table(table, 2.0, direction="tau")
        assert judgement.outcome == "pass"
        assert judgement.order == pytest.approx(2.0, abs=1e-3)

    @pytest.mark.parametrize("order", [1.0, 2.0])
    def test_terms_that_cancel_never_pass(self, order):
        table = grid(lambda h, tau: np.abs(h**order - 0.5 * tau))
        judgement = judge_table(table, 2.0)
        assert (judgement.outcome, judgement.cause) == ("inconclusive", "cancellation")

    def test_a_stationary_solution_has_no_term_in_tau(self):
        judgement = judge_table(grid(lambda h, tau: h**2), 2.0, stationary=True)
        assert judgement.outcome == "pass" and judgement.joint is None

    def test_time_steps_that_diverged_leave_the_finest_whole_line(self):
        table = grid(lambda h, tau: h**2)
        table.loc[table["tau"] > TAUS[-1], "error"] = np.nan
        judgement = judge_table(table, 2.0)
        assert judgement.outcome == "pass"
        assert len(judgement.masked) == 12


class TestNextRun:
    def test_its_cost_is_that_of_the_given_function(self):
        table = line(lambda h: h**2, LADDER[:4]).assign(tau=0.1)
        judgement = judge_table(table, 2.0, cost=lambda h, tau: 7.0)
        assert judgement.next_run.endswith("about 7 s")

    def test_its_cost_follows_from_the_seconds_of_the_finest(self):
        """A level at ratio 2^(-1/2) has twice the unknowns."""
        table = line(lambda h: h**2, LADDER[:4]).assign(seconds=3.0)
        assert judge_table(table, 2.0).next_run.endswith("about 6 s")


def test_the_worst_decides_and_is_never_green():
    judged = {order: judge_table(line(lambda h, p=order: h**p), 2.0) for order in (1.0, 2.0, 3.0)}
    assert worst(list(judged.values())) == "fail"
    few = judge_table(line(lambda h: h**2, LADDER[:3]), 2.0)
    assert worst([judged[2.0], few]) == "inconclusive"
    assert [EXIT[outcome] for outcome in SEVERITY] == [3, 0, 0, 3, 1, 1]
