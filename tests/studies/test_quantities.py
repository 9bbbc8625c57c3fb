"""Rates measured along a run, and which quantities a solution has."""

import numpy as np
import pytest

from esfem.judging.eoc import Fit
from esfem.reference_solutions import STARTS, BreathingEllipsoid, StationarySphere, SurfaceFlow
from esfem.reference_solutions.surface_flow import REFERENCES
from esfem.results.limits import compare_limit
from esfem.studies.case import Law
from esfem.studies.claims import claims
from esfem.studies.quantities import (
    QUANTITIES,
    balances,
    decay_rate,
    growth_rate,
    measured,
    odd_part,
    requestable,
)

T = np.linspace(0.0, 1.0, 101)
HELFRICH = Law(name="helfrich", spontaneous_curvature=1.0)
DIFFUSION = Law(name="surface_diffusion")


class TestDecayRate:
    @pytest.mark.parametrize("rate", [0.5, 2.4, 24.0])
    def test_an_exponential_gives_its_rate(self, rate):
        assert decay_rate(T, 0.01 * np.exp(-rate * T)) == pytest.approx(rate, rel=1e-12)

    def test_the_sign_and_size_of_the_amplitude_do_not_matter(self):
        a = np.exp(-3.0 * T) * (1.0 + 0.1 * np.sin(9.0 * T))
        assert decay_rate(T, -7e-5 * a) == pytest.approx(decay_rate(T, a), rel=1e-12)

    def test_what_comes_after_the_first_decade_does_not_count(self):
        a = np.exp(-10.0 * T)
        assert decay_rate(T, np.where(a < 0.05, 0.05, a)) == pytest.approx(10.0, rel=1e-12)

    def test_of_the_odd_part_is_that_of_the_linear_flow(self):
        """What both runs have in common, and terms of even order, do not count."""
        common, even = 0.02 * np.sin(7.0 * T), 1e-4 * np.exp(-12.0 * T)
        linear = 0.01 * np.exp(-6.0 * T)
        up, down = common + even + linear, common + even - linear
        assert decay_rate(T, odd_part(up, down)) == pytest.approx(6.0, rel=1e-12)
        assert abs(decay_rate(T, up) - 6.0) > 0.1  # which one run alone does not know

    def test_growth_has_a_negative_rate(self):
        assert decay_rate(T, np.exp(2.0 * T)) == pytest.approx(-2.0, rel=1e-12)

    def test_a_mode_that_vanishes_at_once_has_none(self):
        assert np.isnan(decay_rate(T, np.where(T > 0, 0.0, 1.0)))

    def test_one_that_changes_its_sign_has_none(self):
        assert np.isnan(decay_rate(T, np.cos(20.0 * T)))

    @pytest.mark.parametrize("size", [0.0, 1e-17, 3e-12])
    def test_one_that_is_or_becomes_rounding_has_none(self, size):
        noise = 1e-16 * np.random.default_rng(0).standard_normal(len(T))
        assert np.isnan(decay_rate(T, size * np.exp(-3.0 * T) + noise))

    def test_one_that_stays_above_rounding_has_its_rate(self):
        assert decay_rate(T, 3e-10 * np.exp(-3.0 * T)) == pytest.approx(3.0, rel=1e-12)


class TestGrowthRate:
    @pytest.mark.parametrize("side", ["least", "greatest"])
    def test_an_exponential_gives_its_rate_from_either_side(self, side):
        deviation = 1e-5 * np.exp(8.0 * T)
        normals = {"least": 1.0 - 0.1 * deviation, "greatest": 1.0 + 0.1 * deviation}
        normals[side] = 1.0 + (deviation if side == "greatest" else -deviation)
        assert growth_rate(T, **normals) == pytest.approx(8.0, rel=1e-9)

    def test_lengths_that_stay_have_rate_zero(self):
        rng = np.random.default_rng(0)
        greatest = 1.0 + 1e-4 * (1.0 + 1e-3 * rng.standard_normal(len(T)))
        assert growth_rate(T, np.ones_like(T), greatest) == pytest.approx(0.0, abs=1e-3)

    def test_unit_lengths_do_not_grow(self):
        assert growth_rate(T, np.ones_like(T), np.ones_like(T)) == 0.0

    @pytest.mark.parametrize("seed", range(5))
    def test_units_in_the_last_place_are_no_growth(self, seed):
        ulps = np.sort(np.random.default_rng(seed).integers(0, 5, (2, len(T))))
        least, greatest = 1.0 - ulps[0] * 2.0**-53, 1.0 + ulps[1] * 2.0**-52
        assert growth_rate(T, least, greatest) == 0.0

    def test_growth_out_of_rounding_is_measured_above_it(self):
        deviation = np.maximum(1e-13, 2e-14 * np.exp(6.0 * T))
        assert growth_rate(T, np.ones_like(T), 1.0 + deviation) == pytest.approx(6.0, rel=1e-2)

    def test_growth_that_hardly_leaves_rounding_has_no_rate(self):
        deviation = np.where(T > 0.985, 2e-12, 1e-13)
        assert np.isnan(growth_rate(T, np.ones_like(T), 1.0 + deviation))

    def test_lengths_far_off_from_the_start_have_no_rate(self):
        assert np.isnan(growth_rate(T, np.ones_like(T), np.full_like(T, 1.5)))

    def test_nonlinear_growth_beyond_a_hundredth_does_not_count(self):
        deviation = 1e-4 * np.exp(8.0 * T)
        deviation = np.where(deviation > 0.02, 5.0 * deviation, deviation)
        assert growth_rate(T, np.ones_like(T), 1.0 + deviation) == pytest.approx(8.0, rel=1e-9)

    def test_interpolation_error_before_the_decade_does_not_count(self):
        deviation = np.maximum(4e-5, 1e-5 * np.exp(7.0 * T))
        assert growth_rate(T, np.ones_like(T), 1.0 + deviation) == pytest.approx(7.0, rel=1e-9)


class TestMeasured:
    @pytest.mark.parametrize("name", STARTS)
    def test_every_solution_has_known_quantities(self, name):
        solution = SurfaceFlow("ellipsoid") if name == "surface" else STARTS[name]()
        assert measured(solution) or requestable(solution)
        assert set(measured(solution)) | set(requestable(solution)) <= set(QUANTITIES)

    def test_every_quantity_is_measured_of_some_solution(self):
        solutions = [STARTS[name]() for name in STARTS if name != "surface"]
        solutions += [SurfaceFlow("ellipsoid", reference) for reference in REFERENCES]
        flow = SurfaceFlow("ellipsoid", "axisymmetric")
        unforced = [measured(flow, law=law) for law in (HELFRICH, DIFFUSION)]
        apart = set().union(*map(requestable, solutions))
        assert set().union(*map(measured, solutions), *unforced, apart) == set(QUANTITIES)

    def test_what_the_law_alone_tells_is_measured_where_nothing_forces_the_flow(self):
        flow, willmore = SurfaceFlow("ellipsoid"), Law(name="willmore")
        assert balances(flow, willmore) == balances(flow, HELFRICH) == ("energy_law",)
        assert balances(flow, DIFFUSION) == ("energy_law", "volume_drift")
        assert balances(BreathingEllipsoid(), willmore) == balances(flow, None) == ()

    @pytest.mark.parametrize("law", ["willmore", "surface_diffusion", "mean_curvature"])
    def test_an_energy_that_is_W_or_the_area_is_not_measured_twice(self, law):
        flow = SurfaceFlow("ellipsoid", "axisymmetric")
        shown = [v for v in measured(flow, law=Law(name=law)) if not QUANTITIES[v].on_request]
        assert shown == ["W", "area", "volume", "distance"]

    def test_the_helfrich_energy_is_measured_beside_W(self):
        assert measured(SurfaceFlow("ellipsoid", "axisymmetric"), law=HELFRICH)[:2] == (
            "W",
            "energy",
        )

    def test_the_free_growth_rate_scales_like_one_over_time(self):
        assert StationarySphere(2.0).off_constraint_rate * 2.0**4 == pytest.approx(8.0)


class TestLimits:
    falling, rising = Fit(2.0, 0.1, 1.0, 4), Fit(-0.5, 0.1, 1.0, 4)
    rate, growth = claims()["decay-rate"].limit, claims()["off-constraint-growth"].limit

    @pytest.mark.parametrize(
        ("fit", "errors", "outcome"),
        [
            (falling, [0.08, 0.02, 0.009], "pass"),
            (falling, [0.08, 0.02, 0.011], "fail"),
            (rising, [0.007, 0.008, 0.009], "inconclusive"),
            (rising, [1e-4, 2e-4, 3e-4], "pass"),
            (falling, [0.08, 0.02, np.inf], "fail"),
            (falling, [0.08, 0.02, np.nan], "inconclusive"),
            (falling, [np.nan, 0.02, 0.009], "inconclusive"),
        ],
    )
    def test_a_converging_error_is_judged_by_its_finest(self, fit, errors, outcome):
        assert compare_limit(fit, errors, self.rate)[0] == outcome

    @pytest.mark.parametrize(
        ("errors", "outcome"),
        [
            ([0.03, 0.02, 0.04], "pass"),
            ([0.06, 0.01, 0.01], "fail"),
            ([0.0, 0.0, 0.0], "pass"),
            ([0.03, np.nan, 0.04], "inconclusive"),
            ([np.nan, 0.06, 0.04], "inconclusive"),
        ],
    )
    def test_one_that_need_not_converge_by_its_largest(self, errors, outcome):
        assert compare_limit(self.rising, errors, self.growth, converges=False)[0] == outcome
