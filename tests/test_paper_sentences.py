"""The paper's sentences: each check holds on results that bear it out, and not on others."""

import json
from dataclasses import asdict

import pandas as pd
import pytest
from pydantic import ValidationError

from harness.catalogue import study_path
from harness.flows.command import flow_path
from harness.flows.flow_file import load_flow
from harness.paper.evidence import FlowData, Missing, StudyData, Table, flow_data, study_data
from harness.paper.extras import EXTRAS
from harness.paper.plan import committed_plan
from harness.paper.registry import CHECKS
from harness.paper.sentences import Sentence, judged, sentences
from harness.provenance import numerics_digest
from harness.study import Study, load_study
from harness.verdict import SEVERITY

ALL = sentences()
LADDER = (30, 60, 120, 240)
BOUND, NO_CLAIM = {"limit": 1e-7}, "no claim"


def study(name="paper-sphere", **sweep) -> Study:
    found = load_study(study_path(name))
    return found.model_copy(update={"sweep": found.sweep.model_copy(update=sweep)})


def runs(error=lambda h, tau: h**2, taus=(0.2, 0.1), stopped=(), ratio=2**-0.5, **columns):
    """A row a run; the error of x, nu, H and v is ``error``."""
    rows = []
    for i, vertices in enumerate(LADDER):
        for tau in taus:
            h, ok = ratio**i, (vertices, tau) not in stopped
            e = error(h, tau) if ok else None
            errors = {f"err_{name}": e for name in ("x", "nu", "H", "V", "z", "v")}
            rows.append({"vertices": vertices, "tau": tau, "h": h, **errors, **columns})
            rows[-1]["status"] = "ok" if ok else "diverged"
    return pd.DataFrame(rows)


def verdict(outcome="pass", observed=2.0, half=0.05, **facts):
    ends = {"lower": observed - half, "upper": observed + half} if observed else {}
    blank = {"lower": None, "upper": None, "limit": None, "expected": 2.0, "tolerance": 0.2}
    named = {"study": "s", "variable": "x", "verdict": outcome, "observed": observed}
    return {**blank, **named, **ends, **facts}


def data(*verdicts, of=None, records=None) -> StudyData:
    records = runs() if records is None else records
    return StudyData(of or study(), records, list(verdicts))


def energy(value):
    return data(records=runs(energy_T=value))


def flow(nodes=4978, status="ok", verdicts=("pass", "pass")) -> FlowData:
    plain = load_flow(flow_path("ellipsoid")).model_dump(mode="json")
    names = ("energy at rest", "surface at rest")
    checks = [
        {"name": n, "verdict": v, "measured": 0.0, "bound": 0.01, "text": n}
        for n, v in zip(names, verdicts, strict=True)
    ]
    content = {"flow": plain, "nodes": nodes, "status": status, "reason": "", "checks": checks}
    return FlowData(content)


def normals(without=0.99, kept=1.0, count=1914) -> Table:
    rows = []
    for name, low in (("without", without), ("with", kept)):
        row = {"projections": name, "nodes": count}
        for quantity in ("|nu|", "distance", "W"):
            row |= {f"least {quantity}": low, f"greatest {quantity}": 1.0, f"exact {quantity}": 1.0}
        rows.append(row)
    return Table(rows)


X = {"variables": ["x"]}
HALVED, STEADY = (lambda h, tau: tau), (lambda h, tau: h**2 + 1e-3 * tau)
SETTING = {"nodes": 4978, "first": 0.2, "halvings": 8, "final_time": 4.0}
REST = {"names": ["energy at rest", "surface at rest"]}
SQUARED = {"squared": 2.0, "bound": 1e-12}
TORUS, HELFRICH = study("paper-torus"), study("helfrich-bdf2")
# By check: what it is given where it holds, what where it fails, and its parameters.
EXAMPLES = {
    "orders": ([data(verdict())], [data(verdict("fail", 1.0))], X),
    "bounded": (
        [data(verdict(**BOUND), records=runs(lambda h, tau: 1e-9))],
        [data(verdict("fail", **BOUND))],
        X,
    ),
    "exceeds": (
        [data(verdict()), data(verdict("super", 3.0))],
        [data(verdict()), data(verdict(observed=2.2))],
        X,
    ),
    "at_least": (
        [data(verdict(NO_CLAIM, 2.0))],
        [data(verdict(NO_CLAIM, 0.5))],
        {**X, "below_degree": 1, "tolerance": 0.2},
    ),
    "space_dominates": (
        [data(records=runs(STEADY))],
        [data(records=runs(HALVED))],
        {**X, "share": 0.5},
    ),
    "more_runs_finish": (
        [data(), data(records=runs(stopped=[(30, 0.2)]))],
        [data(records=runs(stopped=[(30, 0.2)])), data()],
        {},
    ),
    "printed_energy": ([data()], [data(of=TORUS)], {"printed": "25.1327"}),
    "final_energy": ([energy(25.1328)], [energy(25.2)], {"bound": 1e-4}),
    "rests_exactly": ([data(of=TORUS)], [data(of=HELFRICH)], {"bound": 1e-12}),
    "moves_discretely": ([data()], [data(records=runs(lambda h, tau: 1e-13))], {"bound": 1e-9}),
    "mesh_widths": ([data(), data()], [data(), data(records=runs(ratio=0.5))], {"tolerance": 0.05}),
    "time_steps": ([data(), data()], [data(), data(of=study(tau=[0.2, 0.05]))], {"first": 0.2}),
    "radii": ([data(of=TORUS)], [data(of=TORUS)], SQUARED),
    "graded": ([data(of=TORUS)], [data()], {"part": 0.25}),
    "flow_setting": ([flow()], [flow(nodes=4977)], SETTING),
    "flow_checks": ([flow()], [flow(verdicts=("pass", "fail"))], REST),
    "nodes": ([normals()], [normals(count=954)], {"count": 1914}),
    "normals_deviate": ([normals()], [normals(without=1.0)], {"bound": 1e-3}),
    "normals_kept": ([normals()], [normals(kept=0.999)], {"bound": 1e-12}),
    "stays_nearer": ([normals()], [normals(kept=0.9)], {"quantity": "distance"}),
}
WITHOUT_VERDICT = {"observed"}  # tells what was observed, where nothing is claimed


class TestChecks:
    def test_every_check_has_an_example(self):
        assert set(EXAMPLES) | WITHOUT_VERDICT == set(CHECKS)

    @pytest.mark.parametrize("name", EXAMPLES)
    def test_holds_on_results_that_bear_it_out(self, name):
        found, _, parameters = EXAMPLES[name]
        finding = CHECKS[name](*found, **parameters)
        assert finding.verdict == "pass"
        assert finding.measured and finding.expected

    @pytest.mark.parametrize("name", set(EXAMPLES) - {"radii"})
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
        found = data(records=runs(stopped=every, energy_T=None))
        assert CHECKS[name](found, **parameters).verdict == "inconclusive"

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
