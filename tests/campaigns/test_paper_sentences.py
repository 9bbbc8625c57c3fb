"""The paper's sentences: each check holds on results that bear it out, and not on others."""

from dataclasses import asdict, replace
from inspect import signature
from itertools import permutations

import pandas as pd
import pytest
from paper_examples import (
    EXAMPLES,
    FLOORS,
    HALVED,
    LADDER,
    LONG,
    PLAIN,
    STEADY,
    TORUS,
    WITHOUT_VERDICT,
    X,
    data,
    flow,
    in_both,
    judgeable,
    runs,
    study,
    verdict,
)
from pydantic import TypeAdapter, ValidationError

from esfem.campaigns.paper.plan import NEEDED, committed_plan
from esfem.campaigns.paper.run import EXTRAS
from esfem.campaigns.paper.sentence_checks import CHECKS
from esfem.campaigns.paper.sentences import Sentence, judged, sentences
from esfem.campaigns.paper.stored_results import Missing, Part, stored_flow, stored_study, within
from esfem.common.provenance import numerics_digest
from esfem.flows.flow_results import CheckedFlow
from esfem.judging.outcome import SEVERITY
from esfem.results.error_verdicts import PREFIXES
from esfem.results.verdicts import NAN
from esfem.studies.catalogue import study_path
from esfem.studies.study import load_study

ALL = sentences()


def section_7(sentence):
    return sentence.section == "7.1" and "Theorem" not in sentence.quote


def takes_an_error(sentence):
    return "error" in signature(CHECKS[sentence.check]).parameters


class TestChecks:
    def test_every_check_has_an_example(self):
        assert set(EXAMPLES) | WITHOUT_VERDICT == set(CHECKS)

    @pytest.mark.parametrize("name", EXAMPLES)
    def test_holds_on_results_that_bear_it_out(self, name):
        found, _, parameters = EXAMPLES[name]
        finding = CHECKS[name](*found, **parameters)
        assert finding.verdict == "pass"
        assert finding.measured and finding.expected

    @pytest.mark.parametrize("name", EXAMPLES)
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

    def test_each_time_step_is_judged_by_itself(self):
        spoilt = judgeable(lambda h, tau: h if tau == 0.1 else h**2)
        found = CHECKS["orders_by_step"](spoilt, **EXAMPLES["orders_by_step"][2])
        assert found.note == "met by 2 of 3 lines"
        assert "tau = 0.1 FAIL (x 1.00 " in found.measured
        assert "tau = 0.05 PASS (x 2.00 " in found.measured

    def test_runs_that_stop_are_named_with_their_time_and_no_claim(self):
        stopped = [(30, 0.2), (30, 0.1), (60, 0.1)]
        found = CHECKS["stops"](data(records=runs(stopped=stopped)))
        told = "V = 30: tau = 0.2 (t = 0.5), 0.1 (t = 0.5); V = 60: tau = 0.1 (t = 0.5)"
        assert (found.verdict, found.measured) == ("no claim", told)
        assert CHECKS["stops"](data()).measured == "all runs reach T"

    def test_rates_of_growth_are_told_by_run_and_are_no_claim(self):
        """Each with its mesh, also where two are equal to the digits that are shown."""
        rates = {240: 14.12, 480: 14.11, 960: None}
        rows = [{"BDF": 1, "V": V, "tau": 0.0015625, "rate": rate} for V, rate in rates.items()]
        found = CHECKS["growth"](rows, rate=13.0)
        assert (found.verdict, found.expected) == ("no claim", "e^(13 t)")
        assert found.measured == (
            "e^(rate t) with BDF1, tau = 0.0015625: 14.1 on V = 240, 14.1 on V = 480"
        )
        assert CHECKS["growth"](rows[2:], rate=13.0).measured == "no run grows"

    def test_an_error_in_time_that_exceeds_that_in_space_is_named_with_its_mesh(self):
        check, (_, found, parameters) = (
            CHECKS["never_exceeds_space"],
            EXAMPLES["never_exceeds_space"],
        )
        assert check(*found, **parameters).note == f"above: x on V = {LADDER[0]} (2.50)"
        one = data(records=runs(stopped=[(30, 0.2)]))
        assert check(one, **parameters).verdict == "fail"
        assert "1 of 8 runs stop early" in check(one, **parameters).note

    def test_the_worst_of_several_studies_decides(self):
        found = [data(verdict()), data(verdict("inconclusive", NAN)), data(verdict("super", 3.0))]
        finding = CHECKS["orders"](*found, variables=["x"])
        assert (finding.verdict, finding.note) == ("inconclusive", "INCONCLUSIVE: x of s")

    @pytest.mark.parametrize(
        ("name", "parameters"),
        [
            ("space_dominates", {**PLAIN, "share": 0.5}),
            ("never_exceeds_space", PLAIN),
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
        finding = CHECKS["space_dominates"](found, **PLAIN, share=0.25)
        assert finding.verdict == "fail" and f"V = {LADDER[0]}" in finding.measured

    @pytest.mark.parametrize(
        ("error", "verdict"),
        [(lambda h, tau: 0.0, "pass"), (lambda h, tau: max(0.0, tau - 0.1), "fail")],
    )
    def test_an_error_of_zero_changes_by_nothing_or_wholly(self, error, verdict):
        finding = CHECKS["space_dominates"](data(records=runs(error=error)), **PLAIN, share=0.5)
        assert finding.verdict == verdict and "nan" not in finding.measured

    @pytest.mark.parametrize("name", ["exceeds", "at_least"])
    def test_without_an_observed_order_nothing_is_concluded(self, name):
        parameters = EXAMPLES[name][2]
        assert CHECKS[name](data(verdict(observed=NAN)), **parameters).verdict == "inconclusive"

    @pytest.mark.parametrize(
        ("check", "more"),
        [
            ("orders", {}),
            ("orders_by_step", {}),
            ("exceeds", {}),
            ("space_dominates", {"share": 0.5}),
            ("never_exceeds_space", {}),
        ],
    )
    def test_the_error_that_is_asked_for_decides(self, check, more):
        """Here each check holds of one error and not of the other, and the other way round."""
        for holding, failing in permutations(PREFIXES):
            found = in_both(*EXAMPLES[check][:2], errors=(holding, failing))
            for error, outcome in ((holding, "pass"), (failing, "fail")):
                finding = CHECKS[check](*found, **X, **more, error=error)
                assert finding.verdict == outcome

    @pytest.mark.parametrize("check", ["orders", "exceeds", "space_dominates"])
    def test_an_error_that_was_not_measured_is_missing(self, check):
        (found, *_), _, parameters = EXAMPLES[check]
        with pytest.raises(Missing, match="has no error against the interpolation of x"):
            CHECKS[check](found, **{**parameters, "error": "interpolation"})

    def test_without_a_choice_the_worst_error_decides(self):
        part = replace(verdict("fail", 1.0).parts[0], name="interpolation")
        both = replace(verdict(), parts=(*verdict().parts, part))
        assert CHECKS["orders"](data(both), **X).verdict == "fail"
        assert CHECKS["orders"](data(both), **X, error="error").verdict == "pass"

    def test_what_was_not_exercised_is_no_success(self):
        idle = verdict("not exercised")
        found = CHECKS["orders"](data(idle), **X)
        assert (found.verdict, found.note) == ("not exercised", "NOT EXERCISED: x of s")
        beside = CHECKS["orders"](data(idle), data(verdict()), **X)
        assert (beside.verdict, beside.note) == ("pass", found.note)

    def test_an_order_of_the_interpolation_alone_exceeds_nothing(self):
        """However high it is."""
        idle = verdict("not exercised", 4.0)
        found = CHECKS["exceeds"](data(idle), **PLAIN)
        assert (found.verdict, found.note) == ("not exercised", "NOT EXERCISED: x of s")
        assert CHECKS["exceeds"](data(idle), data(verdict()), **PLAIN).verdict == "fail"

    def test_an_inconclusive_row_names_the_runs_that_would_decide_it(self):
        run = "h = 0.05, tau = 0.1 (the next finer level), about 46 s"
        open_ = verdict("inconclusive", NAN, next_run=run)
        told = f"INCONCLUSIVE: x of s; x of s would be decided by {run}"
        assert CHECKS["orders"](data(open_), data(verdict()), **X).note == told
        failed = CHECKS["orders"](data(open_), data(verdict("fail")), **X)
        assert run not in failed.note

    def test_on_the_line_of_a_step_too_it_names_them(self):
        few = within(judgeable(), Part(vertices_from=LONG[-2]))
        found = CHECKS["orders_by_step"](few, **EXAMPLES["orders_by_step"][2])
        assert found.verdict == "inconclusive" and "would be decided by h = " in found.note

    @pytest.mark.parametrize(
        ("found", "more"),
        [(flow(status="diverged"), {}), (flow(), {"halvings": 7}), (flow(), {"final_time": 2.0})],
    )
    def test_another_setting_of_a_flow_fails(self, found, more):
        setting = {**EXAMPLES["flow_setting"][2], **more}
        assert CHECKS["flow_setting"](found, **setting).verdict == "fail"

    def test_a_check_that_the_flow_did_not_make_is_inconclusive(self):
        finding = CHECKS["flow_checks"](flow(), names=["energy decreases"])
        assert finding.verdict == "inconclusive" and "energy decreases" in finding.note


class TestSentences:
    def test_every_check_is_used(self):
        assert {sentence.check for sentence in ALL} == set(CHECKS)

    def test_all_studies_flows_and_tables_exist(self):
        plan = committed_plan(long=True)
        names = {f"flows/{path.stem}" for path in plan.flows}
        names |= {path.stem for path in plan.studies} | {f"extra/{name}" for name in EXTRAS}
        assert {name for sentence in ALL for name in sentence.studies} <= names

    def test_what_is_read_on_a_part_is_read_on_the_whole_grid_too(self):
        """But for what tells of the rest of it alone."""

        def reading(sentence):
            return (sentence.quote, sentence.check, tuple(sentence.studies))

        whole = {reading(sentence) for sentence in ALL if sentence.part is None}
        parts = {reading(s) for s in ALL if s.part is not None and s.check != "stops"}
        assert len(parts) >= 5 and parts <= whole

    def test_every_study_of_the_figures_is_checked_by_a_sentence(self):
        used = {name for sentence in ALL for name in sentence.studies}
        assert {"paper-sphere", "paper-sphere-unprojected", "paper-torus"} <= used
        assert {f"flows/{path.stem}" for path in committed_plan().flows} <= used

    def test_what_extra_tables_need_is_known_and_in_the_plan(self):
        used = {name for sentence in ALL for name in sentence.studies if name.startswith("extra/")}
        assert {name.partition("/")[2] for name in used} == set(NEEDED) <= set(EXTRAS)
        assert {name for names in NEEDED.values() for name in names} <= set(committed_plan().names)

    def test_every_part_holds_runs_of_its_studies_and_not_all_of_them(self):
        parts = [sentence for sentence in ALL if sentence.part is not None]
        assert parts
        for sentence in parts:
            for name in sentence.studies:
                whole = load_study(study_path(name))
                assert 0 < len(sentence.part.of(whole).cases()) < len(whole.cases())

    @pytest.mark.parametrize("sentence", ALL, ids=lambda s: f"{s.check}-{s.studies[0]}")
    def test_without_results_it_is_inconclusive_and_says_what_to_run(self, sentence, tmp_path):
        kind, _, name = sentence.studies[0].rpartition("/")
        done = "made" if kind == "extra" else "run"
        for line in judged(sentence, tmp_path, tmp_path):
            assert line.verdict == "inconclusive"
            assert f"{name} has not been {done}" in line.note

    def test_those_of_the_figures_are_judged_in_both_errors(self):
        """And in norms whose unit of length is 1: the figures have no other."""
        figures = [s for s in ALL if section_7(s) and takes_an_error(s)]
        assert len(figures) > 15
        for sentence in figures:
            assert sentence.errors == ["error", "interpolation"]
            for name in sentence.studies:
                assert load_study(study_path(name)).claimed_length == 1.0

    def test_all_others_leave_the_error_to_the_verdicts(self):
        others = [s for s in ALL if not (section_7(s) and takes_an_error(s))]
        assert {s.label for s in others} >= {"MainTHM", "eq:initial errors", "eq:defect bounds"}
        assert not any(s.errors for s in others)

    def test_the_theorem_is_read_on_its_own_scheme_and_where_surfaces_move(self):
        """Each of its seven bounds; on no surface that rests exactly in the discrete equations."""
        rows = [s for s in ALL if s.label == "MainTHM"]
        studies = {name: load_study(study_path(name)) for s in rows for name in s.studies}
        bounds = {s.quote: [studies[name] for name in s.studies] for s in rows}
        assert len(bounds) == 7
        assert {found.study.claim for found in studies.values()} >= {"theorem", "flow-map"}
        moves = {s.quote for s in rows if any(studies[n].forced for n in s.studies)}
        assert moves == set(bounds)
        for found in studies.values():
            assert found.claimed is not None and found.solution.name != "sphere"

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"check": "nothing"}, "must be one of orders"),
            ({"parameters": {}}, "variables"),
            ({"parameters": {"variables": ["x"], "more": 1}}, "more"),
            ({"check": "bounded", "studies": ["a", "b"]}, "multiple values"),
            ({"studies": []}, "at least 1"),
            ({"more": 1}, "Extra inputs"),
            ({"part": {"tau_from": 0.1}, "studies": ["flows/a"]}, "part: is for studies alone"),
            ({"part": {"tau": 0.1}}, "Extra inputs"),
            ({"errors": ["both"]}, "'error' or 'interpolation'"),
            ({"errors": ["error", "error"]}, "must be different ones"),
            ({"check": "bounded", "errors": ["error"]}, "unexpected keyword argument 'error'"),
            ({"check": "exceeds"}, "missing a required argument: 'error'"),
            ({"part": {"vertices_from": "240"}}, "valid integer"),
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

    def test_a_line_has_what_the_report_shows_and_tells_its_program(self, tmp_path):
        (line,) = map(asdict, judged(ALL[0], tmp_path, tmp_path))
        keys = ("label", "section", "quote", "study", "measured", "expected", "verdict", "note")
        assert tuple(line) == (*keys, "error", "numerics") and line["verdict"] in SEVERITY
        assert line["numerics"] == numerics_digest() and line["error"] == ""

    def test_a_sentence_that_does_not_say_which_error_has_a_line_for_each(self, monkeypatch):
        """Which it tells, with the unit of length of the claim."""
        spoilt = runs(STEADY).assign(nodal_x=runs(HALVED)["err_x"])
        monkeypatch.setattr(
            "esfem.campaigns.paper.sentences.evidence", lambda *_: data(records=spoilt)
        )
        words = {"label": "l", "section": "7", "quote": "q", "studies": ["a"]}
        check = {"check": "space_dominates", "parameters": {**X, "share": 0.5}}
        both = Sentence.model_validate({**words, **check, "errors": ["error", "interpolation"]})
        lines = judged(both, None, None)
        assert [(line.error, line.verdict) for line in lines] == [
            ("u_h - u, L = 1", "pass"),
            ("u_h - I_h u, L = 1", "fail"),
        ]
        assert {line.quote for line in lines} == {"q"}


class TestParts:
    small = study(vertices=list(LADDER), tau=[0.2, 0.1, 0.05])

    def test_the_ends_belong_to_it(self):
        part = Part(vertices_from=60, vertices_to=120, tau_from=0.05, tau_to=0.1)
        sweep = part.of(self.small).sweep
        assert (sweep.vertices, sweep.tau) == ([60, 120], [0.1, 0.05])

    def test_without_ends_it_is_the_whole_grid(self):
        assert Part().of(self.small) == self.small

    def test_one_without_runs_is_refused(self):
        with pytest.raises(ValueError, match="holds no run of paper-sphere"):
            Part(vertices_from=121, vertices_to=239).of(self.small)

    def test_only_its_runs_are_judged_and_anew(self):
        """Of order 2 on the finer steps, spoilt on the coarsest."""
        whole = judgeable(lambda h, tau: h**2 + 0.3 * (tau > 0.1))
        found = within(whole, Part(tau_to=0.1))
        assert set(found.records["tau"]) == {0.1, 0.05}
        assert len(found.records) == 2 * len(LONG)
        x = found.verdicts[0]
        assert x.verdict == "pass" and x.observed == pytest.approx(2.0, abs=0.01)
        assert within(whole, Part(tau_from=0.2)).verdicts[0].verdict != "pass"

    def test_floors_that_were_measured_elsewhere_do_not_count(self):
        floor = {"floor": "rounding", "variable": "x", "vertices": 1920, "tau": 0.1, "value": 1.0}
        found = replace(judgeable(), floors=pd.DataFrame([floor]))
        assert within(found, Part(tau_to=0.1)).verdicts[0].verdict != "pass"
        assert within(found, Part(tau_to=0.05)).floors.empty
        assert within(found, Part(tau_to=0.05)).verdicts[0].verdict == "pass"

    def test_of_a_table_without_lines_the_columns_are_kept(self):
        """So that a part of a part can be taken."""
        empty = Part().lines(FLOORS)
        assert list(empty.columns) == list(FLOORS.columns)

    def test_a_sentence_is_judged_on_its_part(self, monkeypatch):
        table = runs(taus=(0.2, 0.1), stopped=[(30, 0.2)]).assign(seconds=1.0, final_time=1.0)
        found = data(of=self.small, records=table)
        monkeypatch.setattr("esfem.campaigns.paper.sentences.evidence", lambda *_: found)
        words = {"label": "l", "section": "7", "quote": "q", "studies": ["a"]}
        plain = Sentence.model_validate({**words, "check": "all_finish"})
        on_part = Sentence.model_validate({**plain.model_dump(), "part": {"vertices_from": 60}})
        (line,) = judged(plain, None, None)
        assert line.verdict == "fail"
        (line,) = judged(on_part, None, None)
        assert (line.verdict, line.measured) == ("pass", "6 of 6 runs reach T")


class TestEvidence:
    def test_a_flow_of_another_version_counts_as_missing(self, tmp_path):
        kind, path = TypeAdapter(CheckedFlow), tmp_path / "checks.json"
        stored = replace(flow(), environment={"numerics": numerics_digest()})
        path.write_bytes(kind.dump_json(stored))
        assert stored_flow(tmp_path, "f") == stored
        path.write_bytes(kind.dump_json(replace(stored, environment={"numerics": "other"})))
        with pytest.raises(Missing, match="flow f was run by numerics other"):
            stored_flow(tmp_path, "f")

    def test_a_flow_that_is_not_there_or_damaged_counts_as_missing(self, tmp_path):
        with pytest.raises(Missing, match="flow f has not been run"):
            stored_flow(tmp_path, "f")
        (tmp_path / "checks.json").write_text("{}")
        with pytest.raises(Missing, match="holds no flow that can be read"):
            stored_flow(tmp_path, "f")

    def test_a_damaged_study_counts_as_missing(self, tmp_path):
        (tmp_path / "verdicts.json").write_text("{")
        with pytest.raises(Missing, match="cannot be read"):
            stored_study(tmp_path, "s")
