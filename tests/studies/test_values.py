"""What a study and its result derive once, and hand on."""

from dataclasses import replace

import pandas as pd
import pytest
from stored import recast
from studies import write_study

from esfem.common.bad_input import BadInput
from esfem.judging.outcome import worst
from esfem.results.run_studies import How, run_studies
from esfem.results.selection import exclusions
from esfem.studies.claims import claims
from esfem.studies.study import load_study


@pytest.fixture
def study(tmp_path):
    return load_study(write_study(tmp_path))


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    return run_studies([write_study(folder)], folder / "out", jobs=1)[0]


class TestStudy:
    def test_derives_title_claim_and_solution(self, study):
        assert study.title == study.study.title
        assert study.claimed is claims()["section-7"]
        assert study.direction == study.claimed.direction == "h"
        assert study.expected_order == study.scheme.degree
        assert study.initial == study.solution.initial()
        assert not study.forced

    def test_derives_once(self, study):
        assert study.initial is study.initial
        assert all(a is b for a, b in zip(study.cases(), study.cases(), strict=True))

    def test_a_changed_copy_derives_anew(self, study):
        title = study.study.model_copy(update={"title": "other", "claim": None})
        other = study.model_copy(update={"study": title})
        assert (study.title, study.claimed is None) == ("A small study", False)
        assert (other.title, other.claimed) == ("other", None)

    def test_a_changed_scheme_has_its_own_order(self, study):
        assert (study.scheme.order, study.scheme.solved_to) == (2, study.scheme.tolerance)
        other = study.scheme.model_copy(update={"bdf": 3, "tolerance": 1e-3})
        assert (other.order, other.solved_to) == (3, 1e-3)

    def test_what_was_derived_does_not_go_to_other_processes(self, study):
        case = study.cases()[0]
        assert case.levels is not None and "levels" in vars(case)
        sent = case.__getstate__()["__dict__"]
        assert sent.keys() == type(case).model_fields.keys()


class TestResult:
    def test_series_are_all_runs_along_the_judged_parameter(self, result):
        assert [label for label, _ in result.series] == ["tau = 0.25", "tau = 0.125"]
        for _, runs in result.series:
            assert runs["tau"].nunique() == 1 and runs["h"].is_monotonic_decreasing
        together = pd.concat([runs for _, runs in result.series])
        pd.testing.assert_frame_equal(together.sort_index(), result.records)

    def test_the_shown_series_is_the_one_that_was_judged(self, result):
        judged = {(v, t) for one in result.verdicts for v in one.vertices for t in one.tau}
        runs = dict(result.series)[result.shown]
        assert judged == set(zip(runs["vertices"], runs["tau"], strict=True))

    def test_each_series_has_its_table(self, result):
        for label, runs in result.series:
            errors, nodal = result.tables[label]
            for table in (errors, nodal):
                assert [int(n) for n in table["vertices"]] == runs["vertices"].tolist()
                assert set(result.study.variables) <= set(table.columns)

    def test_excluded_are_the_runs_that_are_not_there(self, result):
        assert result.excluded == []
        less = replace(result, records=result.records.iloc[1:])
        assert less.excluded == exclusions(less.study, less.records)
        assert less.excluded[0].startswith("missing: V = 30, tau = 0.25")

    def test_nothing_is_recovered_of_a_scheme_that_offers_everything(self, result):
        assert result.recovered == ()
        assert result.headings == {name: name for name in result.study.variables}

    def test_the_outcome_is_the_worst_of_the_verdicts(self, result):
        claimed = [v for v in result.verdicts if v.claim]
        assert len(claimed) == 3 and result.outcome == worst(claimed)
        one = recast(result.verdicts[0], verdict="fail")
        assert replace(result, verdicts=[one, *result.verdicts[1:]]).outcome == "fail"


@pytest.mark.parametrize("given", [{"jobs": 0}, {"checkpoint": -1.0}])
def test_how_to_run_is_checked(given):
    (name,) = given
    with pytest.raises(BadInput, match=f"--{name} "):
        How(**given)
