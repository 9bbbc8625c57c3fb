"""The studies and flows of the paper: all load, and claim only what they may."""

import pytest
from studies import write_study

from esfem.campaigns.paper.ablation import FACTORS, REACTIONS, cases, variants
from esfem.campaigns.paper.plan import committed_plan, plan_in
from esfem.common.bad_input import BadInput
from esfem.flows.flow_file import load_flow
from esfem.solver import Scheme
from esfem.solver.reaction import REACTIONS as KNOWN
from esfem.studies.catalogue import (
    default_studies,
    full_studies,
    long_studies,
    paper_studies,
    study_path,
)
from esfem.studies.study import load_study

PLAN = committed_plan()
LONG = committed_plan(long=True)


@pytest.mark.parametrize("path", LONG.studies, ids=lambda path: path.stem)
def test_every_study_is_valid_and_bears_the_name_of_its_file(path):
    assert load_study(path).name == path.stem


@pytest.mark.parametrize("path", PLAN.flows, ids=lambda path: path.stem)
def test_every_flow_is_valid_and_bears_the_name_of_its_file(path):
    assert load_flow(path).name == path.stem


@pytest.mark.parametrize("path", paper_studies() + long_studies(), ids=lambda path: path.stem)
def test_without_theta_only_the_sentence_of_section_7_is_claimed(path):
    study = load_study(path)
    with_theta = {"theorem", "order-k", None}
    assert study.study.claim in (with_theta if study.scheme.theta else {"section-7", None})


def test_no_two_committed_studies_share_a_name():
    every = default_studies() + full_studies() + paper_studies() + long_studies()
    names = [path.stem for path in every]
    assert len(names) == len(set(names)) and len(LONG.names) == len(set(LONG.names))


def test_a_study_of_the_paper_is_accepted_by_name():
    assert study_path("paper-torus") in paper_studies()


def test_the_figures_have_the_grid_of_the_paper():
    for name in ("paper-sphere-unprojected", "paper-sphere", "paper-torus"):
        study = load_study(study_path(name))
        assert study.sweep.vertices == [30 * 2**i for i in range(8)]
        assert study.sweep.tau == pytest.approx([0.2 / 2**j for j in range(8)], rel=1e-15)
        assert (study.scheme.degree, study.sweep.final_time) == (2, 1.0)


def test_the_figures_are_those_of_the_linearly_implicit_method():
    """Every nonlinear term extrapolated, BDF2 on the sphere and BDF1 on the torus."""
    for path in paper_studies():
        scheme = load_study(path).scheme
        assert scheme.reaction == "extrapolated", path.stem
    bdf = {n: load_study(study_path(f"paper-{n}")).scheme.bdf for n in ("sphere", "torus")}
    assert bdf == {"sphere": 2, "torus": 1}


def test_long_studies_are_run_on_request_alone():
    further = {path.stem for path in long_studies()}
    assert further and further == set(LONG.names) - set(PLAN.names)
    for name in further:
        assert study_path(name) in long_studies()


def test_the_ablation_has_all_combinations_of_its_factors():
    found = {tuple(getattr(options, name) for name in FACTORS) for options in variants()}
    assert len(found) == len(variants()) == 2 * 2 * 2 * len(REACTIONS)
    assert set(REACTIONS) == set(KNOWN)
    assert {options.degree for options in variants()} == {2}


def test_the_runs_of_the_ablation_are_cases_that_the_solver_takes():
    every = list(cases())
    assert len({case.model_dump_json() for case in every}) == len(every)
    assert {case.scheme.reaction for case in every} == set(REACTIONS)
    for case in every:
        Scheme(reaction=case.scheme.reaction)
        assert case.final_time / case.tau == pytest.approx(case.steps, rel=1e-12)


def test_only_chooses_studies_and_flows():
    plan = PLAN.only(["ellipsoid", "paper-torus"])
    assert plan.names == ("paper-torus", "ellipsoid") and not plan.ablation
    alone = PLAN.only(["ablation"])
    assert alone.names == ("ablation",) and alone.ablation
    with pytest.raises(BadInput, match="--only nothing: must be one of paper-"):
        PLAN.only(["nothing"])


def test_a_folder_without_studies_is_refused(tmp_path):
    with pytest.raises(BadInput, match="holds neither"):
        plan_in(tmp_path)


def test_the_long_studies_of_a_folder_are_those_in_its_folder_long(tmp_path):
    (tmp_path / "long").mkdir()
    write_study(tmp_path, name="small.toml")
    write_study(tmp_path / "long", ('name = "small"', 'name = "more"'), name="more.toml")
    assert plan_in(tmp_path).names == ("small",)
    assert plan_in(tmp_path, long=True).names == ("small", "more")


def test_a_study_not_named_as_its_file_is_refused(tmp_path):
    write_study(tmp_path, name="other.toml")
    with pytest.raises(BadInput, match=r"must be named after its study, small\.toml"):
        plan_in(tmp_path)
