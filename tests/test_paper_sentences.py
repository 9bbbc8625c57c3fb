"""The paper's sentences: each check holds on results that bear it out, and not on others."""

import json
from dataclasses import asdict

import pytest
from paper_examples import EXAMPLES, LADDER, TORUS, WITHOUT_VERDICT, X, data, flow, runs, verdict
from pydantic import ValidationError

from harness.paper.evidence import Missing, flow_data, study_data
from harness.paper.extras import EXTRAS
from harness.paper.plan import committed_plan
from harness.paper.registry import CHECKS
from harness.paper.sentences import Sentence, judged, sentences
from harness.provenance import numerics_digest
from harness.verdict import SEVERITY

ALL = sentences()


class TestChecks:
    def test_every_check_has_an_example(self):
        assert set(EXAMPLES) | WITHOUT_VERDICT == set(CHECKS)

    @pytest.mark.parametrize("name", EXAMPLES)
    def test_holds_on_results_that_bear_it_out(self, name):
        found, _, parameters = EXAMPLES[name]
        finding = CHECKS[name](*found, **parameters)
        assert finding.verdict == "pass"
        assert finding.measured and finding.expected

    @pytest.mark.parametrize("name", sorted(set(EXAMPLES) - {"radii"}))
    def test_fails_on_results_that_do_not(self, name):
        _, found, parameters = EXAMPLES[name]
        finding = CHECKS[name](*found, **parameters)
        assert finding.verdict == "fail"
        assert finding.measured

    def test_other_radii_fail(self):
        assert CHECKS["radii"](data(of=TORUS), squared=3.0, bound=1e-12).verdict == "fail"

    def test_what_is_only_observed_is_no_claim(self):
        found = CHECKS["observed"](data(verdict("pass")), variables=["x"])
        assert (found.verdict, found.measured) == ("no claim", "x 2.00 [1.95, 2.05]")

    def test_the_worst_of_several_studies_decides(self):
        found = [data(verdict()), data(verdict("inconclusive", None)), data(verdict("super", 3.0))]
        finding = CHECKS["orders"](*found, variables=["x"])
        assert finding.verdict == "inconclusive" and "x inconclusive" in finding.note

    @pytest.mark.parametrize(
        ("name", "parameters"),
        [
            ("space_dominates", {**X, "share": 0.5}),
            ("final_energy", {"bound": 1e-4}),
            ("moves_discretely", {"bound": 1e-9}),
        ],
    )
    def test_where_nothing_finished_nothing_is_concluded(self, name, parameters):
        every = [(v, tau) for v in LADDER for tau in (0.2, 0.1)]
        found = data(records=runs(stopped=every, willmore_T=None))
        assert CHECKS[name](found, **parameters).verdict == "inconclusive"

    def test_the_error_in_space_has_to_dominate_on_each_mesh(self):
        """On the coarsest one it grows as tau falls, on the finest it does not."""
        found = data(records=runs(error=lambda h, tau: h**2 * (1.0 + (h == 1.0) * 0.1 / tau)))
        finding = CHECKS["space_dominates"](found, **X, share=0.25)
        assert finding.verdict == "fail" and f"V = {LADDER[0]}" in finding.measured

    @pytest.mark.parametrize(
        ("error", "verdict"),
        [(lambda h, tau: 0.0, "pass"), (lambda h, tau: max(0.0, tau - 0.1), "fail")],
    )
    def test_an_error_of_zero_changes_by_nothing_or_wholly(self, error, verdict):
        finding = CHECKS["space_dominates"](data(records=runs(error=error)), **X, share=0.5)
        assert finding.verdict == verdict and "nan" not in finding.measured

    @pytest.mark.parametrize("name", ["exceeds", "at_least"])
    def test_without_an_observed_order_nothing_is_concluded(self, name):
        parameters = EXAMPLES[name][2]
        assert CHECKS[name](data(verdict(observed=None)), **parameters).verdict == "inconclusive"

    def test_a_check_that_the_flow_did_not_make_is_inconclusive(self):
        finding = CHECKS["flow_checks"](flow(), names=["energy decreases"])
        assert finding.verdict == "inconclusive" and "energy decreases" in finding.note


class TestSentences:
    def test_every_check_is_used(self):
        assert {sentence.check for sentence in ALL} == set(CHECKS)

    def test_all_studies_flows_and_tables_exist(self):
        plan = committed_plan()
        names = {f"flows/{path.stem}" for path in plan.flows}
        names |= {path.stem for path in plan.studies} | {f"extra/{name}" for name in EXTRAS}
        assert {name for sentence in ALL for name in sentence.studies} <= names

    def test_every_study_of_the_figures_is_checked_by_a_sentence(self):
        used = {name for sentence in ALL for name in sentence.studies}
        assert {"paper-sphere", "paper-sphere-unprojected", "paper-torus"} <= used
        assert {f"flows/{path.stem}" for path in committed_plan().flows} <= used

    @pytest.mark.parametrize("sentence", ALL, ids=lambda s: f"{s.check}-{s.studies[0]}")
    def test_without_results_it_is_inconclusive_and_says_what_to_run(self, sentence, tmp_path):
        line = judged(sentence, tmp_path, tmp_path)
        assert line.verdict == "inconclusive"
        kind, _, name = sentence.studies[0].rpartition("/")
        done = "made" if kind == "extra" else "run"
        assert f"{name} has not been {done}" in line.note

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"check": "nothing"}, "must be one of orders"),
            ({"parameters": {}}, "variables"),
            ({"parameters": {"variables": ["x"], "more": 1}}, "more"),
            ({"check": "bounded", "studies": ["a", "b"]}, "multiple values"),
            ({"studies": []}, "at least 1"),
            ({"more": 1}, "Extra inputs"),
        ],
    )
    def test_one_that_does_not_fit_its_check_is_refused(self, change, message):
        good = {
            **{"label": "l", "section": "7", "quote": "q", "studies": ["a"]},
            **{"check": "orders", "parameters": {"variables": ["x"]}},
        }
        assert Sentence.model_validate(good).check == "orders"
        with pytest.raises(ValidationError, match=message):
            Sentence.model_validate({**good, **change})

    def test_a_line_has_what_the_report_shows(self, tmp_path):
        line = asdict(judged(ALL[0], tmp_path, tmp_path))
        keys = ("label", "section", "quote", "study", "measured", "expected", "verdict", "note")
        assert tuple(line) == keys and line["verdict"] in SEVERITY


class TestEvidence:
    def test_a_flow_of_another_version_counts_as_missing(self, tmp_path):
        content = {"environment": {"numerics": numerics_digest()}}
        path = tmp_path / "checks.json"
        path.write_text(json.dumps(content))
        assert flow_data(tmp_path, "f").content == content
        path.write_text(json.dumps({"environment": {"numerics": "other"}}))
        with pytest.raises(Missing, match="flow f was run by numerics other"):
            flow_data(tmp_path, "f")

    def test_a_damaged_study_counts_as_missing(self, tmp_path):
        (tmp_path / "verdicts.json").write_text("{")
        with pytest.raises(Missing, match="cannot be read"):
            study_data(tmp_path, "s")
