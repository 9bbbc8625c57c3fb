"""Fits of one slice: exact on what they model, and by the book on scatter."""

from itertools import combinations, pairwise

import numpy as np
import pytest
from judged import LADDER, scattered
from scipy.stats import linregress
from scipy.stats import t as student

from esfem.judging.fits import VISIBLE, aicc, hypotheses, power_fit, residual_sums
from esfem.judging.models import models
from esfem.judging.window import asymptotic_window, fewest_levels, runs_probability

X = np.log(LADDER / LADDER[-1])


class TestPower:
    @pytest.mark.parametrize("order", [-1.0, 0.5, 2.0, 5.0])
    def test_a_pure_power_is_recovered(self, order):
        fit = power_fit(X, np.log(3.0) + order * X)
        assert fit.order == pytest.approx(order, abs=1e-8)
        assert np.exp(fit.intercept) == pytest.approx(3.0, rel=1e-8)

    def test_the_interval_is_that_of_student(self):
        y = 2.0 * X + np.log(scattered(0, 0.05))
        fit, book = power_fit(X, y), linregress(X, y)
        half = student.ppf(0.975, len(X) - 2) * book.stderr
        assert (fit.lower, fit.upper) == pytest.approx((book.slope - half, book.slope + half))

    def test_the_interval_covers_the_truth_in_95_of_100_tables(self):
        fits = [power_fit(X, 2.0 * X + np.log(scattered(seed, 0.1))) for seed in range(2000)]
        share = np.mean([fit.lower <= 2.0 <= fit.upper for fit in fits])
        assert share == pytest.approx(0.95, abs=0.015)  # three standard errors

    def test_the_parabola_is_significant_by_chance_in_5_of_100_tables(self):
        fits = [power_fit(X, 2.0 * X + np.log(scattered(seed, 0.1))) for seed in range(2000)]
        assert np.mean([fit.bend < 0.05 for fit in fits]) == pytest.approx(0.05, abs=0.015)

    def test_the_curvature_is_the_change_of_slope(self):
        fit = power_fit(X, 2.0 * X + 0.1 * X**2)
        assert fit.curvature == pytest.approx(0.2 * np.ptp(X), rel=1e-10)


class TestHypotheses:
    @pytest.mark.parametrize("k", [1.0, 2.0, 4.0])
    def test_each_fits_its_own_errors(self, k):
        which = hypotheses(k, plateaus=True)
        for i, h in enumerate(which):
            r = 0.3 * np.exp(-max(h.m, 0) * X.max()) * (-1 if h.kind == "difference" else 1)
            r = {"sum": 0.5, "saturation": 0.5, "plateau": 0.2}.get(h.kind, r)
            y = 0.7 + h.p * X + h.s * np.log1p(r * np.exp(h.m * X))
            sums = residual_sums(X, y, which)
            assert sums[i] < 1e-8, h.name

    def test_a_leading_term_that_cannot_be_seen_is_no_hypothesis(self):
        """A pure power is h^(k-1) + h^k without its first term, which must hold 40 %."""
        which = hypotheses(2.0, plateaus=False)
        sums = dict(zip((h.name for h in which), residual_sums(X, 2.0 * X, which), strict=True))
        assert sums["h^1 + h^2"] > 0.1 * VISIBLE
        assert sums["h^2 + h^3"] < 1e-4

    def test_a_plateau_is_one_only_if_floors_do_not_rule_it_out(self):
        assert any(h.kind == "plateau" for h in hypotheses(2.0, plateaus=True))
        assert not any(h.kind == "plateau" for h in hypotheses(2.0, plateaus=False))

    def test_names_are_distinct(self):
        names = [h.name for h in hypotheses(2.0, plateaus=True)]
        assert len(set(names)) == len(names)


class TestModels:
    @pytest.mark.parametrize(
        ("name", "errors"),
        [
            ("power", lambda h: h**2),
            ("power + plateau", lambda h: h**2 + 0.05),
            ("power + next order", lambda h: h**2 * (1 + 3 * h)),
            ("two powers", lambda h: h**0.5 + 4 * h**4),
        ],
    )
    def test_aicc_chooses_the_model_that_made_the_errors(self, name, errors):
        h = 0.7 * 0.5 ** (np.arange(9) / 2)
        x, y = np.log(h / h[-1]), np.log(errors(h) * scattered(3, 0.002, len(h)))
        assert models(x, y, power_fit(x, y))[0].name == name

    def test_the_next_order_does_not_spoil_the_leading_one(self):
        y = np.log(LADDER**2 * (1 + 2 * LADDER))
        found = {model.name: model for model in models(X, y, power_fit(X, y))}
        next_order = found["power + next order"]
        assert next_order.order == pytest.approx(2.0, abs=0.05)  # the odds are scanned
        assert 1.8 < next_order.lower <= 2.0 <= next_order.upper < 2.2

    def test_too_many_parameters_are_never_chosen(self):
        assert aicc(1e-30, 5, 3) == float("inf")


class TestWindow:
    def test_close_levels_need_five_and_halving_four(self):
        assert fewest_levels(LADDER) == 5
        assert fewest_levels(0.5 ** np.arange(6)) == 4

    def test_coarse_levels_off_the_line_are_left_out(self):
        h = 0.5 ** np.arange(8)
        y = np.log(h**2 * scattered(1, 0.01, 8))
        y[:2] += 1.0
        window = asymptotic_window(h, y, hypotheses(2.0, True), 0.2)
        assert window.stable and window.levels == 6

    def test_too_few_levels_have_no_window(self):
        assert asymptotic_window(LADDER[:4], 2 * X[:4], hypotheses(2.0, True), 0.2) is None
        assert asymptotic_window(LADDER[:0], X[:0], hypotheses(2.0, True), 0.2) is None

    def test_a_slope_that_keeps_changing_is_not_stable(self):
        window = asymptotic_window(LADDER, X + X**2, hypotheses(2.0, True), 0.2)
        assert not window.stable and window.levels == 5

    @pytest.mark.parametrize("signs", ["+-+-+-", "+++---", "++----", "+--++-"])
    def test_the_probability_of_few_runs_is_that_of_all_arrangements(self, signs):
        def runs(plus: tuple[int, ...]) -> int:
            row = [i in plus for i in range(len(signs))]
            return 1 + sum(a != b for a, b in pairwise(row))

        plus = tuple(i for i, sign in enumerate(signs) if sign == "+")
        every = [runs(chosen) for chosen in combinations(range(len(signs)), len(plus))]
        expected = np.mean([count <= runs(plus) for count in every])
        residuals = np.array([1.0 if sign == "+" else -1.0 for sign in signs])
        assert runs_probability(residuals) == pytest.approx(expected, abs=1e-12)
