"""What a run measures because the claim of its study names it, and what a study says of it."""

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError

from esfem.meshes import surface_mesh
from esfem.results.records import record_row
from esfem.results.verdicts import judge
from esfem.runs.run_case import run_case
from esfem.studies.claims import claims
from esfem.studies.quantities import QUANTITIES, asked_for, measured, requestable
from esfem.studies.study import Study
from esfem.studies.variations import floor_pairs

BREATHING = {"name": "breathing_ellipsoid", "amplitude": 0.25, "period": 1.0}
TORUS = {"name": "torus", "R": 1.0, "r": 0.6}
ELLIPSOID = {"name": "surface", "surface": "ellipsoid", "reference": "start"}
PLAIN = {"degree": 2, "bdf": 1, "project": True, "theta": False}
THETA = {**PLAIN, "theta": True}
OF = {  # by claim a study
    "start-of-w": (TORUS, PLAIN),
    "start-with-theta": (ELLIPSOID, THETA),
    "defects": (BREATHING, PLAIN),
    "flow-map": (BREATHING, THETA),
    "gauss-bonnet": (BREATHING, THETA),
}


def study(claim, solution=None, scheme=None, law=None, **sweep) -> Study:
    solution, scheme = solution or OF[claim][0], scheme or OF[claim][1]
    return Study.model_validate(
        {
            "study": {"name": "one", "title": "One", **({"claim": claim} if claim else {})},
            "solution": solution,
            "law": law or {"name": "willmore"},
            "scheme": scheme,
            "sweep": {"vertices": [60, 120], "tau": [0.01], "final_time": 0.02, **sweep},
        }
    )


def rows(of: Study) -> pd.DataFrame:
    """The lines of records.csv, of runs that are made here."""
    surface = of.initial.mesh_surface
    found = [run_case(case, surface_mesh(surface, case.vertices))[0] for case in of.cases()]
    return pd.DataFrame([record_row("one", str(i), record) for i, record in enumerate(found)])


class TestAsked:
    @pytest.mark.parametrize("claim", OF)
    def test_a_case_is_asked_for_what_the_claim_names(self, claim):
        (also,) = {case.also for case in study(claim).cases()}
        assert also == tuple(v for v in claims()[claim].variables if QUANTITIES[v].measured_apart)
        assert also

    @pytest.mark.parametrize("claim", ["order-k", None])
    def test_and_for_nothing_by_other_claims(self, claim):
        of = study(claim, BREATHING, THETA)
        assert {case.also for case in of.cases()} == {()}
        assert of.variables == ("x", "nu", "H", "V", "z", "v")

    def test_quantities_of_the_claim_are_shown_with_those_beside_them(self):
        assert study("start-of-w").variables == (
            *("start_V", "start_V_l2", "start_V_h1"),
            *("start_z", "start_z_l2", "start_z_h1"),
        )
        assert study("flow-map").variables == ("flow_map",)

    def test_what_is_measured_apart_is_no_error_that_runs_have_anyhow(self):
        apart = {name for name, q in QUANTITIES.items() if q.measured_apart}
        of = study("flow-map").initial
        assert not apart & set(measured(of))
        assert set(requestable(of)) == apart

    def test_a_scheme_whose_nodes_slide_has_no_labels(self):
        assert requestable(study("flow-map").initial, "bgn") == ()

    def test_a_flow_without_solution_has_no_defects(self):
        found = requestable(study("start-of-w").initial)
        assert set(found) == {*asked_for(("start_V", "start_z")), "gauss_bonnet"}


class TestMeasured:
    @pytest.mark.parametrize("claim", OF)
    def test_each_has_a_positive_column_and_no_other_has(self, claim):
        of = study(claim)
        found = rows(of)
        columns = {f"err_{name}" for name in of.variables}
        assert (found[list(columns)] > 0).to_numpy().all()
        others = {f"err_{name}" for name, q in QUANTITIES.items() if q.measured_apart} - columns
        assert not others & set(found.columns)

    def test_the_start_and_the_defects_are_those_of_any_scheme_in_time(self):
        """Forms, laws and quadrature count: one that does nothing, or is late, has the same."""
        one = rows(study("defects"))
        sweep = {"vertices": [60, 120], "tau": [0.01], "final_time": 0.02}
        two = rows(study("defects", scheme={**THETA, "bdf": 2, "project": False}, **sweep))
        names = [f"err_{name}" for name in study("defects").variables]
        assert names
        np.testing.assert_array_equal(one[names], two[names])

    def test_the_flow_map_is_that_of_the_scheme(self):
        one = rows(study("flow-map"))
        two = rows(study("flow-map", scheme={**THETA, "bdf": 2}))
        assert (one["err_flow_map"] > 1.01 * two["err_flow_map"]).all()

    def test_a_run_that_stopped_early_has_none(self):
        of = study("flow-map")
        record, _ = run_case(of.cases()[0], surface_mesh("sphere", 60))
        stopped = {**vars(record), "status": "diverged", "stopped_at": 0.01}
        row = record_row("one", "key", type(record)(**stopped))
        assert np.isnan(row["err_flow_map"])


class TestJudged:
    def test_what_is_shown_beside_has_no_claim(self):
        of = study("start-of-w", vertices=[60, 120, 240, 480])
        verdicts = {v.variable: v for v in judge(of, rows(of))}
        assert {name for name, v in verdicts.items() if v.claim} == {"start_V", "start_z"}

    def test_the_start_is_no_question_of_the_time_step(self):
        """So that no plateau in tau must be ruled out, and no floor in tau measured."""
        of = study("start-of-w", scheme={**PLAIN, "degree": 3}, vertices=[60, 120, 240, 480])
        assert set(floor_pairs(of)) == {"rounding", "quadrature"}
        assert "tau" in floor_pairs(study("flow-map"))

    def test_with_theta_the_start_is_exact(self):
        of = study("start-with-theta", vertices=[60, 120, 240, 480])
        verdicts = {v.variable: v.verdict for v in judge(of, rows(of))}
        assert verdicts["start_V"] == verdicts["start_z"] == "pass"


class TestRefused:
    def test_a_study_of_a_start_alone_needs_a_claim(self):
        with pytest.raises(
            ValidationError, match=r"\[study\] claim: is missing; of solution 'torus'"
        ):
            study(None, TORUS, PLAIN)

    def test_claims_of_errors_of_fields_are(self):
        with pytest.raises(ValidationError, match="judges x, nu, H, V, v, not measured of 'torus'"):
            study("bdf-order", TORUS, PLAIN)

    def test_times_of_comparison_without_a_reference_are(self):
        with pytest.raises(
            ValidationError, match=r"\[sweep\] compare_at: is for solution 'surface'"
        ):
            study("start-of-w", ELLIPSOID, compare_at=[0.01])

    def test_a_claim_on_the_start_does_not_mix_with_theta(self):
        with pytest.raises(ValidationError, match="is made for theta = false, not for true"):
            study("start-of-w", scheme=THETA)
