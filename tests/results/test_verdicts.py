"""Verdicts on planted records."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pandas as pd
import pytest
from stored import recast
from studies import write_study

from esfem.judging.outcome import worst
from esfem.measuring.lift import VARIABLES
from esfem.reference_solutions import STARTS, StationarySphere
from esfem.results.error_verdicts import ErrorVerdict
from esfem.results.limits import within_limit
from esfem.results.selection import bounded_runs, exclusions
from esfem.results.verdicts import judge
from esfem.studies.claims import claims
from esfem.studies.quantities import QUANTITIES
from esfem.studies.study import STUDIES, load_study
from esfem.studies.variations import floor_pairs

LADDER = [30, 60, 120, 240, 480, 960]
STEPS = (0.2, 0.1, 0.05, 0.025, 0.0125)


def planted(order=2.0, taus=(0.1, 0.05), stopped=(), **of_variable) -> pd.DataFrame:
    """Records with pure powers of h; ``of_variable`` gives other errors as functions of h."""
    rows = []
    for tau in taus:
        for vertices in LADDER:
            h = vertices**-0.5
            ok = (vertices, tau) not in stopped
            errors = {
                f"err_{name}": float(of_variable.get(name, lambda h: 0.7 * h**order)(h))
                if ok
                else np.nan
                for name in VARIABLES
            }
            status = {"status": "ok" if ok else "diverged", "stopped_at": np.nan if ok else 0.3}
            cost = {"seconds": vertices / tau, "final_time": 1.0}
            rows.append({"vertices": vertices, "tau": tau, "h": h, **cost, **status, **errors})
    return pd.DataFrame(rows)


def with_sweep(study, taus=(0.1, 0.05)):
    sweep = study.sweep.model_copy(update={"vertices": LADDER, "tau": list(taus)})
    return study.model_copy(update={"sweep": sweep})


@pytest.fixture
def study(tmp_path):
    return with_sweep(load_study(write_study(tmp_path)))


@pytest.fixture
def in_tau(tmp_path):
    """A study of the order in tau over five time steps."""
    return with_sweep(load_study(write_study(tmp_path, ("section-7", "bdf-order"))), STEPS)


def of(verdicts, variable):
    return next(v for v in verdicts if v.variable == variable)


@pytest.mark.parametrize(
    ("order", "outcome"),
    [(2.0, "pass"), (1.85, "pass"), (3.0, "super"), (1.7, "fail"), (-0.5, "fail"), (-2.0, "fail")],
)
def test_a_pure_power_is_judged_by_its_order(study, order, outcome):
    verdict = of(judge(study, planted(order)), "x")
    assert verdict.verdict == outcome
    assert verdict.observed == pytest.approx(order, abs=1e-3)
    assert verdict.lower - 1e-3 <= order <= verdict.upper + 1e-3
    assert verdict.constant == pytest.approx(0.7, rel=1e-2)
    assert verdict.expected == 2.0


def test_growing_errors_fail(study):
    assert of(judge(study, planted(nu=lambda h: 1.0 / h)), "nu").verdict == "fail"


def test_scatter_about_the_bound_is_inconclusive(study):
    scatter = dict(zip(LADDER, [1.0, 1.0, 1.25, 0.8, 1.25, 0.8], strict=True))
    records = planted(H=lambda h: scatter[round(h**-2)] * h**1.8)
    verdict = of(judge(study, records), "H")
    assert verdict.verdict == "inconclusive"
    assert verdict.lower < 1.6 and verdict.upper > 2.0
    assert verdict.next_run


def test_variables_outside_the_claim_are_observed_without_verdict(study):
    verdict = of(judge(study, planted(0.5)), "z")
    assert (verdict.verdict, verdict.claim) == ("no claim", "")
    assert verdict.observed == pytest.approx(0.5, abs=1e-3)
    assert np.isnan(verdict.expected)


def test_a_study_without_a_claim_is_judged_on_nothing(tmp_path):
    study = with_sweep(load_study(write_study(tmp_path, ('claim = "section-7"\n', ""))))
    verdicts = judge(study, planted(0.1))
    assert {v.verdict for v in verdicts} == {"no claim"}


def test_errors_at_the_measured_rounding_exercise_no_order(study):
    floors = pd.DataFrame(
        {"floor": ["rounding"], "variable": ["H"], "tau": [0.05], "value": [2e-11]}
    )
    verdict = of(judge(study, planted(H=lambda h: 1e-12 / h), floors), "H")
    assert verdict.verdict == "not exercised"
    assert np.isnan(verdict.observed)


def test_the_theorem_expects_the_degree():
    assert [claims()["theorem"].expected_order(k, 1) for k in (2, 3, 4)] == [2.0, 3.0, 4.0]


def test_the_bdf_claim_expects_the_order_of_the_method():
    assert [claims()["bdf-order"].expected_order(4, q) for q in (1, 2, 5)] == [1.0, 2.0, 5.0]


def test_the_finest_tau_with_the_four_finest_meshes_is_judged(study):
    levels = bounded_runs(study, planted())
    assert set(levels["tau"]) == {0.05}
    assert list(levels["vertices"]) == [120, 240, 480, 960]


@pytest.mark.parametrize("hole", [120, 240, 480, 960])
def test_a_hole_in_the_finest_meshes_is_not_bridged(study, hole):
    assert set(bounded_runs(study, planted(stopped=[(hole, 0.05)]))["tau"]) == {0.1}
    both = planted(stopped=[(hole, 0.05), (hole, 0.1)])
    assert bounded_runs(study, both).empty
    assert of(judge(study, both), "x").verdict == "inconclusive"


def test_a_missing_run_is_named_and_never_green(study):
    records = planted().iloc[:-1]
    assert exclusions(study, records)[0] == "missing: V = 960, tau = 0.05 has no record"
    assert of(judge(study, records), "x").verdict == "inconclusive"


def test_diverged_runs_are_excluded_by_name(study):
    records = planted(stopped=[(30, 0.1), (960, 0.05)])
    assert exclusions(study, records) == [
        "stopped early, tau = 0.1: V = 30 (diverged at t = 0.3)",
        "stopped early, tau = 0.05: V = 960 (diverged at t = 0.3)",
    ]


def test_too_few_levels_are_inconclusive_never_green(study):
    records = planted(stopped=[(120, 0.1), (120, 0.05)])
    verdicts = judge(study, records)
    assert of(verdicts, "x").verdict == "inconclusive"
    assert worst(verdicts) == "inconclusive"


@pytest.mark.parametrize("tail", [[1e-3, 1e-3], [1e-3, 2e-3], [1e-3, 0.9e-3]])
def test_a_plateau_or_growth_at_the_fine_end_is_never_green(study, tail):
    errors = dict(zip(LADDER, [1e3, 1e2, 1e1, 1e-1, *tail], strict=True))
    verdict = of(judge(study, planted(x=lambda h: errors[round(h**-2)])), "x")
    assert verdict.verdict in ("inconclusive", "fail")


def test_the_reason_tells_on_which_runs_the_order_was_observed(study):
    assert "over V = 30..960 at tau = 0.05" in of(judge(study, planted()), "x").reason


@dataclass(frozen=True)
class Moving(StationarySphere):
    stationary: ClassVar[bool] = False


@pytest.fixture
def moving(monkeypatch):
    monkeypatch.setitem(STARTS, "sphere", Moving)


def mixed(space: float, time: float, p: float, q: float, taus) -> pd.DataFrame:
    """Records with the error space h^p + time tau^q in every variable."""
    records = planted(taus=taus)
    for name in VARIABLES:
        records[f"err_{name}"] = space * records["h"] ** p + time * records["tau"] ** q
    return records


@pytest.mark.usefixtures("moving")
class TestMovingSolutions:
    def test_an_order_in_h_is_judged_where_the_time_error_is_small(self, study):
        verdict = of(judge(study, mixed(1.0, 1e-4, 2, 2, (0.1, 0.05))), "x")
        assert (verdict.verdict, verdict.direction) == ("pass", "h")
        assert verdict.observed == pytest.approx(2.0, abs=0.01)

    def test_a_time_error_is_taken_away_before_the_order_in_h_is_judged(self, study):
        verdict = of(judge(study, mixed(1.0, 0.1, 2, 2, (0.1, 0.05))), "x")
        assert verdict.verdict == "pass"
        assert verdict.observed == pytest.approx(2.0, abs=0.05)

    def test_a_time_error_that_rules_is_named(self, study):
        """With 2 % scatter, which is more than all of the error in space."""
        records = mixed(1.0, 100.0, 2, 2, (0.1, 0.05))
        noise = np.random.default_rng(0).normal(size=len(records))
        records["err_x"] *= np.exp(0.02 * noise)
        verdict = of(judge(study, records), "x")
        assert verdict.verdict == "inconclusive"
        assert "% of the error is that in time" in verdict.reason

    @pytest.mark.parametrize(
        ("order", "outcome"), [(2.0, "pass"), (1.5, "fail"), (0.6, "fail"), (2.5, "super")]
    )
    def test_an_order_in_tau_is_judged_on_the_finest_mesh(self, in_tau, order, outcome):
        verdict = of(judge(in_tau, mixed(1e-9, 1.0, 2, order, STEPS)), "x")
        assert (verdict.verdict, verdict.direction) == (outcome, "tau")
        assert verdict.observed == pytest.approx(order, abs=1e-3)
        assert verdict.vertices == (960,)

    def test_an_error_in_space_is_taken_from_an_order_in_tau(self, in_tau):
        verdict = of(judge(in_tau, mixed(0.2, 1.0, 2, 2, STEPS)), "x")
        assert verdict.verdict == "pass"
        assert verdict.observed == pytest.approx(2.0, abs=0.05)


@pytest.mark.usefixtures("moving")
def test_an_error_that_does_not_depend_on_tau_exercises_no_order_in_tau(in_tau):
    verdict = of(judge(in_tau, mixed(1.0, 1e-5, 2, 1, STEPS)), "x")
    assert verdict.verdict == "not exercised"


@pytest.mark.usefixtures("moving")
def test_a_constant_error_on_one_mesh_alone_is_inconclusive(in_tau):
    """With no second mesh nobody knows whether it is the mesh or a time error of order 0."""
    sweep = in_tau.sweep.model_copy(update={"vertices": [960]})
    records = mixed(0.0, 1.0, 2, 0.001, STEPS)
    study = in_tau.model_copy(update={"sweep": sweep})
    assert of(judge(study, records[records["vertices"] == 960]), "x").verdict == "inconclusive"


@pytest.fixture
def unclaimed(in_tau):
    """Two meshes, more time steps, and no claim."""
    about = in_tau.study.model_copy(update={"claim": None})
    sweep = in_tau.sweep.model_copy(update={"vertices": [480, 960]})
    return in_tau.model_copy(update={"study": about, "sweep": sweep})


@pytest.mark.usefixtures("moving")
def test_without_a_claim_the_parameter_with_more_levels_is_observed(unclaimed):
    assert unclaimed.direction == "tau"
    fewer = unclaimed.sweep.model_copy(update={"tau": [0.1]})
    assert unclaimed.model_copy(update={"sweep": fewer}).direction == "h"


def test_without_a_claim_a_stationary_solution_is_observed_in_space(unclaimed):
    assert unclaimed.direction == "h"


def test_a_stationary_solution_exercises_no_order_in_tau(in_tau):
    assert of(judge(in_tau, planted(taus=STEPS)), "x").verdict == "not exercised"


@pytest.mark.parametrize(
    ("outcomes", "expected"),
    [
        (["pass", "fail", "inconclusive"], "fail"),
        (["pass", "inconclusive", "no claim"], "inconclusive"),
        (["pass", "not exercised", "no claim"], "pass"),
        (["not exercised", "no claim"], "not exercised"),
        (["pass", "super", "not exercised"], "super"),
        (["super", "suspect", "inconclusive"], "suspect"),
    ],
)
def test_the_worst_verdict_decides(study, outcomes, expected):
    one = judge(study, planted())[0]
    assert worst([recast(one, verdict=o) for o in outcomes]) == expected


def test_a_measured_floor_in_time_masks_what_is_near_it(study):
    floors = pd.DataFrame({"floor": ["tau"], "variable": ["x"], "tau": [0.05], "value": [2e-4]})
    verdict = of(judge(study, planted(2.0), floors), "x")
    assert verdict.verdict == "pass" and verdict.vertices == (30, 60, 120, 240)
    assert [round(run.h**-2) for run in verdict.masked if run.tau == 0.05] == [480, 960]


@pytest.fixture
def growth():
    """The study of growth, and its records with a planted error."""
    study = with_sweep(load_study(STUDIES / "growth-projected.toml"))
    return study, lambda error: planted().assign(err_growth=error)


def test_an_error_that_is_no_number_proves_nothing_and_the_verdict_tells_why(growth):
    study, records = growth
    broken = records(0.01)
    broken.loc[broken["vertices"] == 240, "err_growth"] = np.nan
    (verdict,) = judge(study, broken)
    assert verdict.verdict == "inconclusive"
    assert verdict.reason.startswith("no error at V = 240: a growth rate needs three levels")


@pytest.mark.parametrize(("error", "outcome"), [(0.0, "pass"), (np.inf, "fail")])
def test_errors_without_a_logarithm_are_judged_by_their_size(growth, error, outcome):
    study, records = growth
    (verdict,) = judge(study, records(error))
    assert verdict.verdict == outcome and np.isnan(verdict.observed)


def test_every_quantity_tells_why_a_run_may_lack_it():
    assert all(len(quantity.lacking) > 10 for quantity in QUANTITIES.values())


def test_more_than_a_sharp_order_fails(study, monkeypatch):
    sharp = claims()["section-7"].model_copy(update={"sharp": True})
    monkeypatch.setattr("esfem.studies.study.claims", lambda: {"section-7": sharp})
    found = judge(study, planted(2.1, nu=lambda h: h**3, H=lambda h: h**1.5))
    assert [of(found, name).verdict for name in ("x", "nu", "H")] == ["pass", "fail", "fail"]


def test_far_more_than_the_order_is_suspect_unless_declared(study):
    records = planted(4.0)
    assert of(judge(study, records), "x").verdict == "super"
    about = study.study.model_copy(update={"superconvergent": {}})
    assert of(judge(study.model_copy(update={"study": about}), records), "x").verdict == "suspect"


@pytest.mark.parametrize(
    ("reaction", "start", "iterates"),
    [
        ("implicit", "exact", True),
        ("linearised", "exact", True),
        ("extrapolated", "exact", False),
        ("extrapolated", "self", True),
    ],
)
def test_the_floor_of_the_solver_is_measured_where_a_step_iterates(
    tmp_path, reaction, start, iterates
):
    """An extrapolated step is a direct solve; those by which BDF2 starts itself are not."""
    options = ('"extrapolated"', f'"{reaction}"\nstart = "{start}"')
    claim = ('claim = "section-7"', 'claim = "bdf-order"')
    study = load_study(write_study(tmp_path, options, claim))
    assert ("solver" in floor_pairs(study)) == iterates


class TestLimitBesideAnOrder:
    MET = ErrorVerdict("error", "", "super", "exceeds order 2", error=1e-3)

    @pytest.mark.parametrize(
        ("outcome", "limit", "expected"),
        [
            ("super", 1e-2, "super"),
            ("super", 1e-4, "fail"),
            ("inconclusive", 1e-2, "inconclusive"),
            ("inconclusive", 1e-4, "fail"),
            ("fail", 1e-2, "fail"),
        ],
    )
    def test_both_must_hold(self, outcome, limit, expected):
        assert within_limit(replace(self.MET, outcome=outcome), limit).outcome == expected

    def test_where_no_run_was_judged_nothing_is_said_of_it(self):
        blank = replace(self.MET, outcome="inconclusive", error=np.nan)
        assert within_limit(blank, 1e-4).outcome == "inconclusive"
