"""The posterior of an order: exact on what it models, honest about what it does not know."""

import numpy as np
import pytest
from judged import LADDER, scattered

from esfem.judging.families import FAMILIES, NAMES, NEVER, shapes
from esfem.judging.posterior import EVEN, NEAR, STEPS, line_posterior
from esfem.judging.scatter import patterns, printed_digits, printed_variance

X = np.log(LADDER / LADDER[-1])
STEP = float(X[0]) / (len(X) - 1)


def posterior(errors, claim=2.0, plateaus=True):
    e = np.asarray(errors)
    models = shapes(X, claim, STEP, plateaus)
    return line_posterior(np.log(e), X, claim, models, patterns(e, X))[0]


class TestPriors:
    def test_those_of_families_of_orders_and_of_shapes_are_whole(self):
        models = shapes(X, 2.0, STEP, True)
        assert sum(FAMILIES.values()) == pytest.approx(1.0)
        assert sum(STEPS.values()) + NEAR + EVEN == pytest.approx(1.0)
        assert np.exp(models.prior).sum() == pytest.approx(1.0)
        for name, prior in FAMILIES.items():
            own = models.family == NAMES.index(name)
            assert np.exp(models.prior[own]).sum() == pytest.approx(prior), name

    def test_those_of_scatter_are_whole(self):
        assert np.exp(patterns(LADDER**2, X).prior).sum() == pytest.approx(1.0)

    def test_a_known_part_in_the_other_parameter_leaves_no_floor(self):
        assert (shapes(X, 2.0, STEP, False).floor == 0).all()

    def test_splitting_keeps_the_weight_and_stays_near(self):
        models = shapes(X, 2.0, STEP, True)
        some = models.at(np.flatnonzero(np.isfinite(models.v))[::40])
        finer = some.split(X)
        assert np.exp(finer.prior).sum() == pytest.approx(np.exp(some.prior).sum())
        middle = finer.at(np.arange(2, len(finer), 5))
        np.testing.assert_allclose(middle.g, some.g, atol=1e-12)


class TestOrder:
    @pytest.mark.parametrize("order", [-1.0, 0.5, 1.37, 2.0, 4.0])
    def test_a_pure_power_has_its_order(self, order):
        found = posterior(3.0 * LADDER**order)
        assert found.quantile(0.5)[0] == pytest.approx(order, abs=2e-3)
        assert np.ptp(found.quantile(0.025, 0.975)) < 0.05

    @pytest.mark.parametrize(
        ("family", "errors", "order"),
        [
            ("next order", lambda h: h**2 * (1 + 2 * h), 2.0),
            ("next order", lambda h: 10 * h**3 + 0.3 * h, 1.0),
            ("difference", lambda h: h**2 * (1 - 0.8 * h), 2.0),
            ("saturation", lambda h: h**2 / (1 + 3 * h), 2.0),
            ("plateau", lambda h: h**2 + 0.1, 2.0),
        ],
    )
    def test_what_made_the_errors_is_found(self, family, errors, order):
        found = posterior(errors(LADDER))
        assert next(iter(found.families())) == family
        assert found.mean_in(family) == pytest.approx(order, abs=0.15)

    def test_scatter_widens_the_interval(self):
        widths = [
            np.ptp(posterior(LADDER**1.63 * scattered(2, size)).quantile(0.025, 0.975))
            for size in (0.003, 0.03, 0.3)
        ]
        assert widths[0] < widths[1] < widths[2]

    def test_errors_without_order_are_likelier_to_have_none(self):
        none = [posterior(e).below(NEVER + 1.0) for e in (scattered(4, 1.5), LADDER**2)]
        assert none[0] > FAMILIES["no order"] > none[1]

    def test_quantiles_are_in_order_and_hold_their_probability(self):
        found = posterior(LADDER**1.63 * scattered(2, 0.05))
        lower, middle, upper = found.quantile(0.025, 0.5, 0.975)
        assert lower < middle < upper
        for q, order in ((0.025, lower), (0.5, middle), (0.975, upper)):
            assert found.below(order - 1e-3) <= q + 5e-3
            assert found.below(order + 1e-3) >= q - 5e-3

    def test_an_outlier_is_seen(self):
        e = LADDER**2 * scattered(1, 0.005)
        e[2] *= 2.0
        noise = patterns(e, X)
        found, _ = line_posterior(np.log(e), X, 2.0, shapes(X, 2.0, STEP, True), noise)
        off = found.weight @ noise.off[found.pattern]
        assert off[2] > 0.9 and np.delete(off, 2).max() < 0.2
        assert found.quantile(0.5)[0] == pytest.approx(2.0, abs=0.05)


class TestDigits:
    @pytest.mark.parametrize("digits", [1, 2, 3, 4, 5, 6])
    def test_those_that_were_printed_are_counted(self, digits):
        e = np.array([float(f"{v:.{digits - 1}e}") for v in 0.7234567 * LADDER**2.1234567])
        assert printed_digits(e) == digits

    def test_full_precision_has_none(self):
        assert printed_variance(LADDER**2.1).max() < 1e-11

    def test_the_variance_is_that_of_rounding(self):
        """Log-uniform numbers, rounded to two digits: the mean square error of their logarithms."""
        exact = np.exp(np.random.default_rng(0).uniform(0, 9, 20000))
        rounded = np.array([float(f"{v:.1e}") for v in exact])
        seen = np.mean(np.log(rounded / exact) ** 2)
        assert printed_variance(rounded).mean() == pytest.approx(seen, rel=0.05)

    def test_fewer_digits_make_less_certain(self):
        exact = 0.7234567 * LADDER**1.87
        widths = []
        for digits in (2, 4):
            e = np.array([float(f"{v:.{digits - 1}e}") for v in exact])
            widths.append(np.ptp(posterior(e).quantile(0.025, 0.975)))
        assert widths[1] < widths[0]
