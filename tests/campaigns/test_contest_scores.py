"""The tables of the comparison of schemes: orders, rates, costs and breakdowns."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from entrant_runs import made

from esfem.campaigns.contest import scores as tables
from esfem.campaigns.contest.contest import (
    GROUNDS,
    PRINCIPAL,
    VARIANTS,
    Sizes,
    case_of,
)
from esfem.campaigns.contest.entrant_run import EntrantRun
from esfem.campaigns.contest.scores import shown
from esfem.judging.judge import LEVELS_MIN
from esfem.judging.slices import spread_enough
from esfem.meshes import surface_mesh
from esfem.runs.run_case import computational_mesh
from esfem.solver.functionals import mesh_width
from esfem.solver.geometry import geometry

EVERYONE = {**PRINCIPAL, **VARIANTS}
each_entrant = pytest.mark.parametrize("entrant", EVERYONE)


class TestTables:
    def test_rises_of_the_energy_are_relative_and_after_the_first_step(self):
        assert made(energy=(10.0, 11.0, 10.5)).rise() == 0.0
        assert made(energy=(10.0, 11.0, 12.0)).rise() == pytest.approx(0.1)

    def test_a_run_that_broke_down_claims_nothing(self):
        broken = made(ended="diverged at t = 0.1", energy=(1.0, 50.0))
        row = shown(tables.measured(broken))
        nothing = ("W rises by", "distance, end", "W error", "x in H^1, end")
        assert {row[name] for name in nothing} == {"-"}
        course = shown(tables.course_row("kll", broken))
        assert {course[k] for k in ("W rises by", "quality, end", "W / 8 pi, end")} == {"-"}

    def test_an_order_has_its_standard_error_and_leaves_out_what_did_not_run(self):
        assert str(tables.order([0.4, 0.2, 0.1], [0.16, 0.04, 0.01])) == "2.00 ± 0.00"
        four = tables.order([0.8, 0.4, 0.2, 0.1], [np.nan, 0.16, 0.04, 0.01])
        assert str(four) == "2.00 ± 0.00 (3 of 4)"
        assert tables.order([0.4, 0.2, 0.1], [0.16, np.nan, 0.01]) is None
        scattered = tables.order([0.8, 0.4, 0.2, 0.1], [0.16, 0.08, 0.04, 0.08])
        assert scattered.fit.uncertainty > 0.2

    def test_numbers_are_shown_by_their_column(self):
        row = {"N": 7, "W error": 0.01234, "quality, end": 0.5, "own W / 8 pi, end": 1.0}
        row |= {"W rises by": 1e-12, "own W rises by": 0.5, "largest stable tau": 0.0}
        row |= {"order k": None, "W": None, "CPU s a step": 0.016149}
        assert list(shown(row).values()) == [
            *(7, "1.2e-02", "0.50", "1.00000"),
            *("never", "5.0e-01", "none"),
            *("none", "-", 0.0161),
        ]

    @pytest.mark.parametrize("k", [1, 2, 3])
    @each_entrant
    def test_an_order_is_judged_where_one_is_claimed(self, entrant, k):
        runs = [EntrantRun(100, h, {"apart": [0.0, h**2]}) for h in (0.5, 0.35, 0.25, 0.18, 0.12)]
        found = tables.verdict(EVERYONE[entrant], k, runs, Sizes())
        word = tables.shown_verdict(found).partition(" ")[0]
        spoken = entrant.startswith("kll, theta") and "Ritz" not in entrant and k > 1
        assert word == ({2: "PASS", 3: "FAIL"}[k] if spoken else "none")

    def test_the_ladder_is_long_enough_for_the_judge(self):
        case = case_of(PRINCIPAL["kll"], GROUNDS["Clifford torus"], 30, 1e-4, 1e-4)
        torus, h = case.solution.initial(), []
        for v in Sizes().order_V:
            mesh, p = computational_mesh(surface_mesh(torus.mesh_surface, v), torus, 1)
            h.append(mesh_width(geometry(mesh, p)))
        assert spread_enough(np.array(h), LEVELS_MIN)

    def test_a_verdict_tells_its_cause(self):
        few = [EntrantRun(100, h, {"apart": [0.0, h**2]}) for h in (0.5, 0.35, 0.25)]
        found = tables.verdict(PRINCIPAL["kll, theta"], 2, few, Sizes())
        assert tables.shown_verdict(found).startswith("INCONCLUSIVE, 3 levels can be judged")

    def test_decay_rates_do_not_depend_on_the_amplitude(self):
        at = partial(tables.rate_on_mesh, PRINCIPAL["kll, theta"], 60, 3)
        whole = Sizes(decay_time=0.004)
        rate = at(whole)[1]
        half = replace(whole, decay_amplitude=whole.decay_amplitude / 2)
        assert 1e-4 < abs(rate - 24.0) < 0.1
        assert abs(at(half)[1] - rate) < 0.05 * abs(rate - 24.0)

    def test_extrapolated_rates_have_hardly_an_error_in_tau(self):
        """The implicit Euler method on a' = -24 a."""
        steps = [Sizes().decay_tau / m for m in (1, 2, 4)]
        rates = [np.log1p(24.0 * tau) / tau for tau in steps]
        assert abs(rates[0] - 24.0) > 0.1
        assert abs(tables.extrapolated(*rates) - 24.0) < 1e-5

    def test_a_scheme_that_breaks_down_has_no_cost(self, monkeypatch):
        broken = made(ended="diverged at t = 0.1")
        monkeypatch.setattr(tables, "run_entrant", lambda *_, **__: broken)
        row = shown(tables.cost_row("kll", PRINCIPAL["kll"], Sizes()))
        assert (row["ended"], row["CPU s a step"]) == (broken.ended, "-")
