"""The runs of the comparison of schemes: what is measured of one, and which steps are stable."""

from dataclasses import replace

import numpy as np
import pytest

from esfem.campaigns.contest import entrant_run
from esfem.campaigns.contest.contest import (
    GROUNDS,
    PRINCIPAL,
    VARIANTS,
    case_of,
)
from esfem.campaigns.contest.entrant_run import largest_stable, run_entrant
from esfem.campaigns.contest.scores import shown_step
from esfem.schemes import named_scheme

EVERYONE = {**PRINCIPAL, **VARIANTS}
each_entrant = pytest.mark.parametrize("entrant", EVERYONE)


class TestRun:
    @each_entrant
    def test_measures_every_level(self, entrant):
        found = run_entrant(case_of(EVERYONE[entrant], GROUNDS["sphere"], 60, 1e-4, 4e-4))
        assert found.ended == "ok"
        np.testing.assert_allclose(found.levels["t"], 1e-4 * np.arange(5), rtol=1e-12)
        assert len(found.seconds) == 4 and min(found.seconds) > 0
        assert 0 < found.at("end", "distance") < 1e-2 and found.at("end", "W") < 1e-2
        assert all(0.5 < quality <= 1.0 for quality in found.levels["quality"])
        assert (entrant == "bgn") == np.isnan(found.at("end", "x"))  # its nodes slide

    def test_at_the_start_errors_are_those_of_the_interpolation(self):
        found = run_entrant(case_of(PRINCIPAL["dziuk"], GROUNDS["Clifford torus"], 60, 1e-4, 4e-4))
        apart = found.levels["apart"]
        assert apart[0] == 0.0 < apart[-1] == found.furthest
        gap = abs(found.at("end", "x") - found.at("start", "x"))
        assert gap <= 1.1 * found.furthest  # the triangle inequality, but for the two surfaces

    @pytest.mark.parametrize("entrant", PRINCIPAL)
    def test_drift_is_beside_the_change_of_the_flow_itself(self, entrant):
        """The sphere keeps its area; the area of the cell changes, and so does that of the flow."""
        options = PRINCIPAL[entrant]
        rest = run_entrant(case_of(options, GROUNDS["sphere"], 60, 1e-4, 4e-4))
        moving = run_entrant(case_of(options, GROUNDS["red blood cell"], 120, 5e-4, 5e-3))
        area, volume = rest.levels["area"], moving.levels["volume"]
        assert rest.at("end", "area_drift") == pytest.approx(abs(area[-1] / area[0] - 1.0))
        change = abs(volume[-1] / volume[0] - 1.0)
        assert change > 0.01 and moving.at("end", "volume_drift") < 0.1 * change

    @each_entrant
    def test_a_breakdown_ends_it_by_name(self, entrant):
        case = case_of(EVERYONE[entrant], GROUNDS["Clifford torus"], 30, 0.05, 1.0)
        found = run_entrant(case.model_copy(update={"disturbance": 0.5}))
        assert found.ended.startswith(("diverged at t = ", "failed at t = "))
        assert np.isnan([found.at("end", "distance"), found.rise(), found.furthest]).all()

    @pytest.mark.parametrize("name", ["start", "energy"])
    def test_a_start_or_an_energy_that_fails_ends_it_by_name(self, name, monkeypatch):
        def fails(*_):
            raise np.linalg.LinAlgError("singular")

        plugin = replace(named_scheme("dziuk"), **{name: fails})
        for module in ("studies.case", "campaigns.contest.contest", "runs.stepping"):
            monkeypatch.setattr(f"esfem.{module}.named_scheme", lambda _: plugin)
        found = run_entrant(case_of(PRINCIPAL["dziuk"], GROUNDS["sphere"], 30, 1e-4, 2e-4))
        assert found.ended == "failed at t = 0"

    def test_the_energy_of_dziuk_is_his_own_and_falls(self):
        """That of the recovered H would rise on the torus."""
        torus = GROUNDS["Clifford torus"]
        found = run_entrant(case_of(PRINCIPAL["dziuk"], torus, 120, 2.5e-4, 2.5e-3))
        own = found.levels["own_energy"]
        assert found.rise("own_energy") == 0.0 and (np.diff(own) < 0).all()
        assert own[0] == pytest.approx(4 * np.pi**2, rel=0.01)


class TestLargestStable:
    @pytest.mark.parametrize("threshold", [0.7, 0.03, 1.3e-4])
    def test_finds_a_threshold_from_below_within_its_factor(self, threshold):
        found = largest_stable(lambda tau: tau <= threshold)
        assert found <= threshold < entrant_run.FACTOR * found

    def test_ends_of_the_range(self):
        assert largest_stable(lambda tau: True) == entrant_run.LARGEST
        assert largest_stable(lambda tau: False) == 0.0

    def test_a_step_beyond_which_none_was_tried_is_shown_as_a_bound(self):
        assert shown_step(entrant_run.LARGEST) == f">= {entrant_run.LARGEST:g}"
        assert shown_step(0.99 * entrant_run.LARGEST) == f"{0.99 * entrant_run.LARGEST:.2g}"
        assert shown_step(0.0) == "none"

    def test_growth_of_the_energy_is_no_stability(self, monkeypatch):
        """A run that ends, on a surface that W says to be another one."""
        bgn = PRINCIPAL["bgn"]
        monkeypatch.setattr(entrant_run, "GROWTH", 0.5)
        assert not entrant_run.is_stable(bgn, GROUNDS["sphere"], 30, 1e-4)
        monkeypatch.setattr(entrant_run, "GROWTH", 1.1)
        assert entrant_run.is_stable(bgn, GROUNDS["sphere"], 30, 1e-4)
