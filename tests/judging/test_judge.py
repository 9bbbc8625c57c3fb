"""Verdicts on tables of known order."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from judged import LADDER, TAUS, grid, line, scattered

from esfem.common.bad_input import BadInput
from esfem.judging import Floor, judge_table, worst
from esfem.judging.causes import SENTENCES
from esfem.judging.judgement import EXIT, SEVERITY

HALVES = 0.5 ** np.arange(1, 9)
SHAPES = {
    "pure": lambda h: h**2 * scattered(4, 0.02),
    "low": lambda h: h * scattered(5, 0.02),
    "high": lambda h: h**3 * scattered(6, 0.02),
    "two powers": lambda h: 10 * h**3 + 0.03 * h,
    "plateau": lambda h: h**2 + 0.05,
    "growing": lambda h: 1 / h,
    "no order": lambda h: scattered(7, 1.0),
}


def of_rates(*rates, ratio=0.5):
    """A table with these rates from level to level."""
    h = ratio ** np.arange(len(rates) + 1.0)
    return line(np.cumprod([1.0, *(ratio**rate for rate in rates)]), h)


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
        assert judgement.order == pytest.approx(order, abs=5e-3)
        assert judgement.constant == pytest.approx(0.7, rel=0.02)
        assert judgement.lower <= judgement.order <= judgement.upper

    def test_a_declared_superconvergence_is_not_suspect(self):
        table = line(lambda h: h**4)
        assert judge_table(table, 2.0, declared_super=True).outcome == "super"

    def test_a_lower_power_not_ruled_out_forbids_super(self):
        """h^3.12 and 74 % of h^1.25 on the finest level, with scatter: the claim 2 is not kept."""
        h = 0.952656 * 0.5 ** np.arange(7)
        errors = [97.6896, 11.2494, 1.23357, 0.12085, 0.0125689, 1.46847e-3, 3.21645e-4]
        assert judge_table(line(errors, h), 2.0).outcome == "inconclusive"

    def test_growing_errors_have_a_negative_order(self):
        judgement = judge_table(line(lambda h: 1 / h), 1.0)
        assert judgement.outcome == "fail" and judgement.upper < 0

    def test_identical_errors_fail(self):
        judgement = judge_table(line(lambda h: 0 * h + 0.3), 2.0)
        assert (judgement.outcome, judgement.code) == ("fail", "identical")

    @pytest.mark.parametrize("claim", [2.0, 3.0])
    def test_ten_cubes_and_a_little_first_order_are_no_higher_order(self, claim):
        """The slopes over h = 0.14 .. 0.025 run from 2.7 to 1.3."""
        table = line(lambda h: 10 * h**3 + 0.03 * h, 0.2 * LADDER)
        assert np.polyfit(np.log(table["h"]), np.log(table["error"]), 1)[0] > 1.8
        assert judge_table(table, claim).outcome in ("inconclusive", "fail")

    @pytest.mark.parametrize("e", [lambda h: h**2 / (1 + 2 * h), lambda h: h**2 + 3 * h**4])
    def test_a_trend_that_the_claimed_order_explains_settles(self, e):
        assert judge_table(line(e, HALVES[:6]), 2.0).outcome == "pass"

    def test_errors_that_jump_are_never_green(self):
        judgement = judge_table(line([1e3, 1e2, 1e1, 1e-1, 1e-3, 1e-3]), 2.0, declared_super=True)
        assert judgement.outcome == "inconclusive"

    def test_more_than_the_claim_meets_the_bound(self):
        """From above and from below are judged alike: an order of 2.05 to 2.4 is at least 1.8."""
        judgement = judge_table(line(LADDER**2.2 * scattered(3, 0.02)), 2.0)
        assert judgement.upper > 2.2 and judgement.outcome in ("pass", "super")

    @pytest.mark.parametrize("order", [1.8, 1.75])
    def test_what_lies_about_the_bound_is_not_decided(self, order):
        judgement = judge_table(line(LADDER**order * scattered(8, 0.04)), 2.0)
        assert judgement.lower < order < judgement.upper
        assert judgement.outcome == "inconclusive"

    def test_the_tolerance_is_that_below_the_claim(self):
        table = line(lambda h: h**1.7)
        assert judge_table(table, 2.0).outcome == "fail"
        assert judge_table(table, 2.0, tolerance=0.4).outcome == "pass"

    def test_a_finest_level_off_the_line_decides_nothing(self):
        errors = np.append(HALVES[:6] ** 3, HALVES[5] ** 3 * 0.45)
        judgement = judge_table(line(errors, HALVES[:7]), 2.0)
        assert judgement.outcome == "inconclusive"

    def test_a_stationary_solution_exercises_no_order_in_tau(self):
        table = line(lambda h: h**2).rename(columns={"h": "tau"}).assign(h=0.1)
        judgement = judge_table(table, 2.0, direction="tau", stationary=True)
        assert judgement.outcome == "not exercised" and judgement.exit_status == 3

    def test_an_order_in_tau_is_judged_alike(self):
        table = line(lambda h: h**2).rename(columns={"h": "tau"}).assign(h=0.1)
        assert judge_table(table, 2.0, direction="tau").outcome == "pass"
        assert judge_table(table, 3.0, direction="tau").outcome == "fail"


class TestTrends:
    """A trend does not pass if, continued by two levels, it leaves what is accepted."""

    def test_rates_that_fall_away_are_not_green(self):
        """As on an L-shaped domain."""
        assert judge_table(of_rates(0.88, 0.87, 0.85, 0.83, 0.81), 1.0).outcome != "pass"

    @pytest.mark.parametrize("change", [-0.02, -0.04, -0.06])
    def test_a_straight_fall_through_the_bound_is_not_green(self, change):
        rates = 1.83 - change * np.arange(6)[::-1]
        assert judge_table(of_rates(*rates), 2.0).outcome not in ("pass", "super")

    @pytest.mark.parametrize(
        ("rates", "claim"),
        [
            ((2.42, 2.26, 2.15, 2.08, 2.04, 2.02), 2.0),
            ((1.52, 1.72, 1.85, 1.92, 1.96, 1.98), 2.0),
            ((4.23, 4.08, 4.02, 4.0, 4.0), 4.0),
            ((3.82, 3.92, 3.96), 4.0),
        ],
    )
    def test_rates_that_settle_inside_pass(self, rates, claim):
        assert judge_table(of_rates(*rates), claim).outcome == "pass"

    def test_rates_that_fall_below_the_claim_are_told(self):
        """Rates of 3.99, 3.94, 3.92, 3.89."""
        errors = [1e-2, 6.29085e-4, 4.10245e-5, 2.71944e-6, 1.82885e-7]
        found = judge_table(line(errors, HALVES[1:6]), 4.0)
        assert found.outcome == "pass" and "the rates fall below 4" in found.notes[0]
        assert not judge_table(of_rates(3.89, 3.92, 3.94, 3.99), 4.0).notes


class TestAudit:
    """Tables whose order is nowhere near the claim, which integer hypotheses let pass."""

    @pytest.mark.parametrize(
        ("claim", "errors"),
        [
            (3.0, lambda s: s**2.25 / (1 + 0.305 * s**2.5) ** 0.5),
            *(
                (claim, rates)
                for claim, rates in [
                    (3.0, (1.00, 1.00, 1.01, 1.06, 1.26, 1.72)),
                    (1.0, (-1.04, 0.01, 0.37, 0.52, 0.57, 0.65)),
                    (4.0, (3.10, 3.11, 3.12, 3.18, 3.32)),
                    (2.0, (0.90, 1.06, 1.20, 1.28, 1.37, 1.43)),
                    (2.0, (2.34, 2.31, 2.22, 2.13, 2.10, 1.97)),
                ]
            ),
        ],
    )
    @pytest.mark.parametrize("ratio", [0.5, 0.5**0.5])
    def test_none_passes(self, claim, errors, ratio):
        if callable(errors):
            s = ratio ** -np.arange(7)[::-1]
            table = line(errors(s), s)
        else:
            table = of_rates(*errors, ratio=ratio)
        assert judge_table(table, claim).outcome in ("fail", "inconclusive")

    @pytest.mark.parametrize(
        ("claim", "rates"),
        [
            (4.0, (4.28, 4.10, 3.92, 3.99, 4.04, 3.96, 4.00)),
            (3.0, (2.84, 2.83, 2.94, 2.96, 3.02, 2.98, 2.98)),
            (4.0, (4.11, 3.58, 3.87, 3.89, 4.02, 3.99, 4.03)),
        ],
    )
    def test_eight_levels_that_settle_at_the_claim_pass(self, claim, rates):
        assert judge_table(of_rates(*rates, ratio=0.5**0.5), claim).outcome == "pass"

    def test_an_error_that_meets_a_floor_between_others_is_not_bridged(self):
        errors = [1.0, 0.25, 1e-7, 0.0156, 0.0039]
        found = judge_table(line(errors, HALVES[:5]), 2.0, floors=[Floor("rounding", 1e-7)])
        assert (found.outcome, found.code) == ("inconclusive", "cancellation")
        assert len(found.masked) == 3

    def test_identical_errors_in_tau_may_be_those_in_space(self):
        table = pd.DataFrame({"h": 0.1, "tau": (*TAUS, 0.0125), "error": 1.234e-3})
        found = judge_table(table, 1.0, direction="tau")
        assert (found.outcome, found.code) == ("inconclusive", "plateau")
        assert "second mesh" in found.next_run

    @pytest.mark.parametrize(("p", "outcome"), [(2.0, "inconclusive"), (0.0, "fail")])
    def test_a_second_mesh_tells_whether_they_are(self, p, outcome):
        table = grid(lambda h, tau: 0.01 * h**p + 0 * tau, h=LADDER[:2], taus=(0.1, 0.05, 0.025))
        assert judge_table(table, 1.0, direction="tau").outcome == outcome

    def test_errors_of_zero_prove_nothing(self):
        table = line(lambda h: 0 * h)
        assert judge_table(table, 2.0).outcome == "inconclusive"
        measured = judge_table(table, 2.0, floors=[Floor("rounding", 1e-15)])
        assert measured.outcome == "not exercised"


class TestFewLevels:
    @pytest.mark.parametrize("levels", [1, 2, 3])
    def test_fewer_than_four_are_inconclusive(self, levels):
        judgement = judge_table(line(lambda h: h**2, LADDER[:levels]), 2.0)
        assert (judgement.outcome, judgement.code) == ("inconclusive", "few")
        assert "more level" in judgement.next_run

    def test_three_are_judged_if_asked_for(self):
        table = line(lambda h: h**2, HALVES[:3])
        assert judge_table(table, 2.0).outcome == "inconclusive"
        assert judge_table(table, 2.0, levels_min=3).outcome == "pass"
        assert judge_table(table, 3.0, levels_min=3).outcome == "fail"

    def test_two_never_are(self):
        with pytest.raises(ValueError, match="levels_min = 2"):
            judge_table(line(lambda h: h**2), 2.0, levels_min=2)

    @pytest.mark.parametrize(("ratio", "outcome"), [(0.5**0.5, "pass"), (0.75, "inconclusive")])
    def test_four_must_reach_two_and_a_half(self, ratio, outcome):
        found = judge_table(line(lambda h: h**2, ratio ** np.arange(4)), 2.0)
        assert found.outcome == outcome
        assert found.code == ("" if outcome == "pass" else "close")

    def test_more_levels_may_lie_closer(self):
        table = line(lambda h: h**2, 0.85 ** np.arange(6))
        assert judge_table(table, 2.0).outcome == "pass"

    @pytest.mark.parametrize("digits", [2, 3, 4])
    def test_four_clean_levels_pass_however_they_are_printed(self, digits):
        errors = [float(f"{v:.{digits - 1}e}") for v in 0.37 * HALVES[:4] ** 2]
        assert judge_table(line(errors, HALVES[:4]), 2.0).outcome == "pass"


class TestInvariance:
    @pytest.mark.parametrize("shape", SHAPES)
    @settings(max_examples=8, deadline=None)
    @given(error_unit=st.floats(1e-4, 1e4), h_unit=st.floats(1e-3, 1e3))
    def test_units_change_no_verdict(self, shape, error_unit, h_unit):
        table = line(SHAPES[shape])
        scaled = pd.DataFrame({"h": h_unit * table["h"], "error": error_unit * table["error"]})
        one, other = judge_table(table, 2.0), judge_table(scaled, 2.0)
        assert (one.outcome, one.code) == (other.outcome, other.code)
        assert other.order == pytest.approx(one.order, abs=1e-3)
        assert other.probability == pytest.approx(one.probability, abs=1e-3)

    @pytest.mark.parametrize("shape", SHAPES)
    def test_the_order_of_rows_changes_nothing(self, shape):
        table = grid(lambda h, tau: 0.3 * tau**2).assign(h=np.tile(LADDER, 3))
        table["error"] += np.tile(SHAPES[shape](LADDER), 3)
        one = judge_table(table, 2.0)
        other = judge_table(table.sample(frac=1.0, random_state=1), 2.0)
        assert (one.outcome, one.code, one.window) == (other.outcome, other.code, other.window)
        assert other.probability == pytest.approx(one.probability, abs=1e-9)

    @pytest.mark.parametrize("order", [1.0, 2.0, 3.0])
    @pytest.mark.parametrize("where", ["fine", "coarse"])
    def test_a_further_level_on_the_line_changes_no_verdict(self, order, where):
        h = 0.7 * 0.5 ** (np.arange(7) / 2)
        table = line(lambda h: h**order, h[1:] if where == "coarse" else h[:-1])
        longer = line(lambda h: h**order, h)
        assert judge_table(longer, 2.0).outcome == judge_table(table, 2.0).outcome

    @pytest.mark.parametrize("size", [0.0, 0.02])
    def test_a_slower_fall_has_no_better_verdict(self, size):
        """The same scatter on h^p: from p = 3 down the probability of at least 1.8 falls, but for
        the single orders that the prior prefers."""
        noise = scattered(3, size)
        found = [judge_table(line(LADDER**p * noise), 2.0) for p in np.arange(3.0, 0.9, -0.1)]
        chances = [j.probability for j in found]
        assert (np.diff(chances) <= 0.02).all()
        green = [j.outcome in ("pass", "super") for j in found]
        assert green == sorted(green, reverse=True) and any(green) and not all(green)
        failed = [j.outcome == "fail" for j in found]
        assert failed == sorted(failed)

    def test_a_larger_plateau_has_no_better_verdict(self):
        outcomes = [
            judge_table(line(lambda h, C=C: h**2 + C), 2.0).outcome for C in (0, 1e-3, 0.1, 10.0)
        ]
        assert outcomes[0] == "pass" and outcomes[-1] != "pass"
        green = [outcome == "pass" for outcome in outcomes]
        assert green == sorted(green, reverse=True)

    def test_more_scatter_makes_no_verdict_out_of_none(self):
        noise = np.random.default_rng(5).normal(size=len(LADDER))
        found = [judge_table(line(LADDER**1.9 * np.exp(s * noise)), 2.0) for s in (0, 0.1, 0.4)]
        assert found[0].outcome == "pass" and found[-1].outcome == "inconclusive"

    def test_the_table_is_not_changed(self):
        table = grid(lambda h, tau: h**2 + tau)
        before = table.copy()
        judge_table(table, 2.0)
        pd.testing.assert_frame_equal(table, before)

    def test_arrays_a_mapping_and_a_frame_are_one_table(self):
        frame = grid(lambda h, tau: h**2 + tau)
        mapping = {name: frame[name].to_numpy() for name in frame}
        lists = {name: frame[name].tolist() for name in frame}
        structured = frame.to_records(index=False)
        said = {str(judge_table(table, 2.0)) for table in (frame, mapping, lists, structured)}
        assert len(said) == 1


class TestAnyTable:
    @pytest.mark.filterwarnings("error")
    @settings(max_examples=60, deadline=None)
    @given(
        exponents=st.lists(st.floats(-12, 12), min_size=1, max_size=9),
        claim=st.sampled_from([0.5, 1.0, 2.0, 4.0, 8.0]),
        tau=st.sampled_from([None, "fixed", "path"]),
    )
    def test_what_is_said_agrees_with_itself(self, exponents, claim, tau):
        """However wild its errors are."""
        h = 0.5 ** np.arange(len(exponents))
        table = line(10.0 ** np.array(exponents), h)
        if tau is not None:
            table["tau"] = 0.1 * (h if tau == "path" else 1.0)
        found = judge_table(table, claim, levels_min=3)
        assert found.outcome in SEVERITY and (found.cause or found.outcome in ("pass", "super"))
        assert bool(found.next_run) == (found.outcome == "inconclusive")
        if np.isfinite(found.order):
            assert found.lower <= found.order <= found.upper
            assert np.isnan(found.probability) or 0.0 <= found.probability <= 1.0


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

    def test_errors_at_a_measured_rounding_exercise_no_order(self):
        table = line(1e-13 * scattered(1, 0.5))
        judgement = judge_table(table, 2.0, floors=[Floor("rounding", 1e-12)])
        assert judgement.outcome == "not exercised" and len(judgement.masked) == len(table)

    def test_errors_that_begin_at_rounding_and_grow_exercise_no_order(self):
        """As an exact solution in the space of the method, with the rounding of finer systems."""
        table = line([7e-15, 4e-14, 2.5e-13, 4.5e-13, 3.2e-12], HALVES[:5])
        judgement = judge_table(table, 2.0)
        assert judgement.outcome == "not exercised"
        assert "no floor of rounding was given" in judgement.notes[0]

    @pytest.mark.parametrize(("unit", "outcome"), [(1.0, "inconclusive"), (1e8, "fail")])
    def test_errors_so_small_that_grow_are_not_accused(self, unit, outcome):
        """Above ten times the measured floor; in another unit nobody would think of rounding."""
        errors = unit * np.array([6e-12, 9e-12, 1.2e-11, 1.9e-11, 2.6e-11, 4e-11])
        found = judge_table(line(errors), 2.0, floors=[Floor("rounding", 1e-14)])
        assert found.outcome == outcome
        assert found.code == ("rounding" if outcome == "inconclusive" else "below")

    def test_levels_above_the_assumed_rounding_are_judged(self):
        """Five levels of order 5, then 6e-13 and 5e-13."""
        errors = [2.1e-4, 7.4e-6, 2.4e-7, 7.6e-9, 2.4e-10, 7.6e-12, 6e-13, 5e-13]
        judgement = judge_table(line(errors, HALVES), 4.0)
        assert judgement.outcome == "super"
        assert "rounding" in " ".join(judgement.notes)

    def test_a_measured_time_error_leaves_constant_errors_no_excuse(self):
        table = line(scattered(3, 0.01)).assign(tau=0.1)
        assert judge_table(table, 2.0).code == "plateau"
        assert judge_table(table, 2.0, floors=[Floor("tau", 1e-9)]).outcome == "fail"

    def test_a_table_without_tau_is_told_nothing_of_time(self):
        for name, shape in SHAPES.items():
            found = judge_table(line(shape), 2.0)
            assert "tau" not in found.cause + found.next_run, name
            assert " time" not in found.cause.replace("times", ""), name

    @pytest.mark.parametrize(("tau", "told"), [(None, "(again)"), (0.1, "half the time step")])
    def test_a_failed_run_has_half_its_time_step_next_if_it_has_one(self, tau, told):
        table = line(lambda h: h**2, LADDER[:6])
        table.loc[2, "error"] = np.nan
        table = table.drop(columns="tau", errors="ignore")
        found = judge_table(table if tau is None else table.assign(tau=tau), 2.0)
        assert found.code == "failed" and told in found.next_run

    @pytest.mark.parametrize("gone", [5, 2])
    def test_a_hole_is_not_bridged(self, gone):
        table = line(lambda h: h**2, LADDER[:6]).assign(status="ok")
        table.loc[gone, ["error", "status"]] = (np.nan, "diverged")
        judgement = judge_table(table, 2.0)
        assert "diverged" in [m.reason for m in judgement.masked]
        if gone == 2:
            assert (judgement.outcome, judgement.code) == ("inconclusive", "failed")
            assert f"h = {LADDER[gone]:.3g}" in judgement.next_run
        else:  # five coarser ones are whole
            assert len(judgement.window) == 0 or judgement.window[-1] == LADDER[4]

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

    def test_a_wild_coarse_level_is_left_out_and_listed(self):
        errors = HALVES[:7] ** 2
        errors[0] *= 30.0
        judgement = judge_table(line(errors, HALVES[:7]), 2.0)
        assert judgement.outcome == "pass" and judgement.window == tuple(HALVES[1:7])
        assert "pre-asymptotic" in judgement.masked[0].reason


class TestGrid:
    @pytest.mark.parametrize(("order", "outcome"), [(2.0, "pass"), (1.0, "fail"), (3.0, "super")])
    def test_the_part_in_tau_is_taken_away(self, order, outcome):
        table = grid(lambda h, tau: h**order + 2.0 * (tau / 0.1) ** 2 * LADDER[-1] ** order)
        judgement = judge_table(table, 2.0, other_order=2.0)
        assert judgement.outcome == outcome
        assert judgement.order == pytest.approx(order, abs=0.03)

    @pytest.mark.parametrize("rho", [1.0, 0.3, -0.3])
    def test_parts_may_stand_at_any_angle(self, rho):
        def error(h, tau):
            a, b = (h / LADDER[-1]) ** 2, 0.5 * tau / TAUS[-1]
            return np.sqrt(a * a + 2 * rho * a * b + b * b)

        assert judge_table(grid(error), 2.0, other_order=1.0).outcome == "pass"

    def test_what_tau_rules_is_said(self):
        noise = np.exp(0.02 * np.random.default_rng(0).normal(size=len(LADDER) * len(TAUS)))
        judgement = judge_table(grid(lambda h, tau: (1e-5 * h + tau**2) * noise), 1.0)
        assert (judgement.outcome, judgement.code) == ("inconclusive", "plateau")
        assert "% of the error is that in time" in judgement.cause

    def test_the_order_in_tau_is_judged_on_all_meshes(self):
        taus = 0.1 * 0.5 ** np.arange(5)
        table = grid(lambda h, tau: 1e-4 * h**2 + tau**2, h=LADDER[:3], taus=taus)
        judgement = judge_table(table, 2.0, direction="tau", other_order=2.0)
        assert judgement.outcome == "pass"
        assert judgement.order == pytest.approx(2.0, abs=0.02)

    def test_terms_that_cancel_never_pass(self):
        for order in (1.0, 2.0):
            table = grid(lambda h, tau, p=order: np.abs(h**p - 0.5 * tau))
            assert judge_table(table, 2.0).outcome not in ("pass", "super")

    def test_a_stationary_solution_has_no_part_in_tau(self):
        judgement = judge_table(grid(lambda h, tau: h**2), 2.0, stationary=True)
        assert judgement.outcome == "pass" and judgement.joint is None

    def test_a_measured_part_in_tau_needs_no_model(self):
        table = grid(lambda h, tau: h**2)
        judgement = judge_table(table, 2.0, floors=[Floor("tau", 1e-6)])
        assert judgement.outcome == "pass" and judgement.joint is None

    def test_time_steps_that_diverged_leave_the_finest_whole_line(self):
        table = grid(lambda h, tau: h**2)
        table.loc[table["tau"] > TAUS[-1], "error"] = np.nan
        judgement = judge_table(table, 2.0)
        assert judgement.outcome == "pass"
        assert len(judgement.masked) == 12


class TestPath:
    """h and tau refined together."""

    @pytest.mark.parametrize(
        ("gamma", "q", "claim"), [(1.0, 1.0, 1.0), (2.0, 1.0, 2.0), (1.0, 3.0, 2.0)]
    )
    def test_the_claim_is_the_lower_order_of_both(self, gamma, q, claim):
        table = line(lambda h: h**2 + h ** (q * gamma), HALVES[:6])
        table["tau"] = 0.1 * table["h"] ** gamma
        found = judge_table(table, 2.0, other_order=q)
        assert (found.outcome, found.claimed) == ("pass", claim)
        assert "refined together" in found.notes[0] and f"h^{gamma:g}" in found.notes[0]

    def test_a_lower_order_along_it_fails(self):
        table = line(lambda h: h, HALVES[:5]).assign(tau=HALVES[:5])
        assert judge_table(table, 2.0, other_order=2.0).outcome == "fail"

    def test_the_claim_in_tau_counts_in_tau(self):
        """tau ~ h^2: order 2 in h is order 1 in tau."""
        table = line(lambda h: h**2, HALVES[:6])
        table["tau"] = table["h"] ** 2
        found = judge_table(table, 2.0, direction="tau", other_order=2.0)
        assert (found.outcome, found.claimed) == ("pass", 1.0)


class TestWords:
    def test_the_probability_stands_in_words(self):
        good, bad = (judge_table(line(lambda h, p=p: h**p), 2.0) for p in (2.0, 1.0))
        assert good.certainty.startswith("order at least 1.8 with probability")
        assert bad.certainty.startswith("order below 1.8 with probability")

    def test_probability_and_interval_agree(self):
        for p in (1.5, 1.75, 1.8, 1.9, 2.0):
            found = judge_table(line(LADDER**p * scattered(2, 0.03)), 2.0)
            if found.lower > 1.8 + 1e-6:
                assert found.probability > 0.97
            if found.upper < 1.8 - 1e-6:
                assert found.probability < 0.03
            assert found.lower <= found.order <= found.upper

    def test_alternatives_are_told_by_probability(self):
        found = judge_table(line(lambda h: h**2 * (1 + h)), 2.0)
        chances = [a.probability for a in found.alternatives]
        assert chances == sorted(chances, reverse=True) and 0.8 < sum(chances) <= 1.0 + 1e-9
        assert found.model == found.alternatives[0].name

    def test_causes_are_sentences_without_jargon(self):
        tables = [line(shape) for shape in SHAPES.values()]
        tables += [line(lambda h: h**2, LADDER[:3]), line(lambda h: 0 * h)]
        tables += [of_rates(2.4, 2.1, 1.75), of_rates(2.0, 2.0, 0.1, 0.0, 0.0)]
        for table in tables:
            found = judge_table(table, 2.0)
            if found.outcome in ("pass", "super"):
                continue
            assert found.code in SENTENCES and len(found.cause.split()) > 6
            assert "plateau" not in found.cause and not found.cause.endswith(".")


class TestNextRun:
    def test_its_cost_is_that_of_the_given_function(self):
        table = line(lambda h: h**2, LADDER[:3]).assign(tau=0.1)
        judgement = judge_table(table, 2.0, cost=lambda h, tau: 7.0)
        assert judgement.next_run.endswith("about 7 s")

    def test_its_cost_follows_from_the_seconds_of_the_finest(self):
        """A level at ratio 2^(-1/2) has twice the unknowns."""
        table = line(lambda h: h**2, LADDER[:3]).assign(seconds=3.0)
        assert judge_table(table, 2.0).next_run.endswith("about 6 s")

    def test_scatter_asks_for_levels(self):
        table = line(LADDER**2 * [1.5, 0.6, 1.5, 1.5, 0.6, 1.5])
        judgement = judge_table(table, 2.0)
        assert (judgement.outcome, judgement.code) == ("inconclusive", "noise")
        assert "more level" in judgement.next_run


def test_the_worst_decides_and_is_never_green():
    judged = {order: judge_table(line(lambda h, p=order: h**p), 2.0) for order in (1.0, 2.0, 3.0)}
    assert worst(list(judged.values())) == "fail"
    few = judge_table(line(lambda h: h**2, LADDER[:3]), 2.0)
    assert worst([judged[2.0], few]) == "inconclusive"
    assert [EXIT[outcome] for outcome in SEVERITY] == [3, 0, 0, 3, 1, 1]


def test_a_small_plateau_is_no_rounding_where_that_was_measured():
    """In units in which all errors are a millionth as large the same is said."""
    h = 0.5 ** np.arange(7.0)
    floors = [Floor("rounding", 1e-22), Floor("solver", 1e-22)]
    small, large = (
        judge_table({"h": h, "error": size * (h**2 + 1e-3)}, 2.0, floors=floors)
        for size in (1e-6, 1.0)
    )
    assert small.outcome == large.outcome == "inconclusive" and small.code == large.code


def test_more_levels_than_can_be_weighed_are_refused():
    h = 0.98 ** np.arange(60.0)
    with pytest.raises(BadInput, match="has 60 levels; at most 50 are judged"):
        judge_table({"h": h, "error": h**2}, 2.0)
    assert judge_table({"h": h[:40], "error": h[:40] ** 2}, 2.0).outcome == "pass"
