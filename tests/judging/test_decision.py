"""From probabilities to an outcome: what a trend does, what a table must show."""

from dataclasses import replace

import numpy as np
import pytest

from esfem.judging.decision import Course, Odds, continued, decide

HALVES = np.log(2.0) * np.arange(6)[::-1]  # log(s / s_finest), coarse to fine
SURE = Odds(
    at_least=0.999, good=0.999, bad=0.001, exceeds=0.0, suspicious=0.0, ruled=0.0, turned=0.0,
    curved=0.0,
)  # fmt: skip
SHOWN = Course(order=2.0, finest=2.0, ahead=2.0, scatter=0.01, off=False)


class TestContinued:
    def test_rates_that_stay_stay(self):
        assert continued(np.full(5, 1.9), HALVES) == pytest.approx(1.9)

    @pytest.mark.parametrize("change", [-0.1, 0.07])
    def test_a_straight_trend_goes_on(self, change):
        rates = 2.0 + change * np.arange(5)
        assert continued(rates, HALVES) == pytest.approx(rates[-1] + 2 * change)

    @pytest.mark.parametrize("ratio", [0.25, 0.5, 0.8])
    def test_a_trend_that_settles_goes_on_settling(self, ratio):
        rates = 2.0 + 0.4 * ratio ** np.arange(7)
        assert continued(rates[:5], HALVES) == pytest.approx(rates[6])

    def test_no_trend_grows_faster_than_twice_from_level_to_level(self):
        rates = np.array([2.0, 2.0, 1.999, 1.9, 1.0])
        assert continued(rates, HALVES) == pytest.approx(1.0 - 0.9 * (2 + 4))

    def test_it_counts_in_levels_of_the_table(self):
        """Half as many levels to a factor 4: the same slopes, the same trend in log h."""
        fine, coarse = 0.5 * HALVES, HALVES
        slopes = 2.0 - 0.1 * np.arange(5)
        assert continued(slopes, fine) == pytest.approx(continued(slopes, coarse))

    def test_no_rates_have_no_trend(self):
        assert np.isnan(continued(np.full(3, np.nan), HALVES[:4]))
        assert continued(np.array([1.5]), HALVES[:2]) == 1.5


class TestDecide:
    def of(self, seen=SURE, course=SHOWN, declared=False):
        return decide(seen, course, 2.0, 0.2, declared)

    def test_what_is_sure_and_shown_passes(self):
        assert self.of() == ("pass", "")

    @pytest.mark.parametrize(
        ("change", "code"),
        [
            ({"off": True}, "finest"),
            ({"scatter": 0.6}, "noise"),
            ({"ahead": 1.7}, "trend"),
            ({"finest": 1.3}, "trend"),
            ({"finest": 2.7}, "trend"),
        ],
    )
    def test_what_is_not_shown_does_not(self, change, code):
        assert self.of(course=replace(SHOWN, **change)) == ("inconclusive", code)

    def test_on_a_grid_and_over_floors_there_is_no_trend(self):
        nothing = replace(SHOWN, finest=float("nan"), ahead=float("nan"))
        assert self.of(course=nothing)[0] == "pass"

    def test_rates_far_from_the_order_ask_for_more(self):
        """Enough at the order, not enough above the claim with scatter."""
        likely = replace(SURE, good=0.97)
        assert self.of(likely)[0] == "pass"
        assert self.of(likely, replace(SHOWN, order=2.3, finest=2.3))[0] == "inconclusive"
        likely = replace(SURE, good=0.99)
        above = replace(SHOWN, order=2.3, finest=2.3)
        assert self.of(likely, above)[0] == "pass"
        assert self.of(likely, replace(above, scatter=0.1))[0] == "inconclusive"
        assert self.of(likely, replace(SHOWN, finest=2.2))[0] == "inconclusive"

    def test_more_than_the_claim_is_super_and_too_much_suspect(self):
        assert self.of(replace(SURE, exceeds=0.99))[0] == "super"
        much = replace(SURE, exceeds=1.0, suspicious=0.999)
        course = replace(SHOWN, order=4.0, finest=4.0, ahead=4.0)
        assert self.of(much, course)[0] == "suspect"
        assert self.of(much, course, declared=True)[0] == "super"
        assert self.of(replace(much, suspicious=0.5), course) == ("inconclusive", "above")

    def test_what_is_surely_below_fails_unless_a_trend_reaches_the_claim(self):
        low = replace(SURE, at_least=0.0, good=0.0, bad=0.999)
        course = replace(SHOWN, order=1.0, finest=1.0, ahead=1.0)
        assert self.of(low, course) == ("fail", "below")
        assert self.of(low, replace(course, ahead=1.9)) == ("inconclusive", "trend")

    @pytest.mark.parametrize(
        ("share", "code"),
        [("ruled", "plateau"), ("turned", "diverges"), ("curved", "trend"), ("", "noise")],
    )
    def test_a_cause_is_named_by_what_is_likely(self, share, code):
        unsure = replace(SURE, at_least=0.5, good=0.5, bad=0.5)
        if share:
            unsure = replace(unsure, **{share: 0.8})
        assert self.of(unsure) == ("inconclusive", code)
