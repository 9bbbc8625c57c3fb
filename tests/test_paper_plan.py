"""The studies and flows of the paper: all load, and claim only what they may."""

import pytest
from studies import write_study

from harness.bad_input import BadInput
from harness.catalogue import default_studies, full_studies, paper_studies, study_path
from harness.flows.flow_file import load_flow
from harness.paper.ablation import VARIANTS
from harness.paper.plan import committed_plan, plan_in
from harness.study import load_study

PLAN = committed_plan()


@pytest.mark.parametrize("path", PLAN.studies, ids=lambda path: path.stem)
def test_every_study_is_valid_and_bears_the_name_of_its_file(path):
    assert load_study(path).name == path.stem


@pytest.mark.parametrize("path", PLAN.flows, ids=lambda path: path.stem)
def test_every_flow_is_valid_and_bears_the_name_of_its_file(path):
    assert load_flow(path).name == path.stem


@pytest.mark.parametrize("path", paper_studies(), ids=lambda path: path.stem)
def test_without_theta_only_the_sentence_of_section_7_is_claimed(path):
    study = load_study(path)
    with_theta = {"theorem", "order-k", None}
    assert study.study.claim in (with_theta if study.scheme.theta else {"section-7", None})


def test_no_two_committed_studies_share_a_name():
    names = [path.stem for path in default_studies() + full_studies() + paper_studies()]
    assert len(names) == len(set(names)) and len(PLAN.names) == len(set(PLAN.names))


def test_a_study_of_the_paper_is_accepted_by_name():
    assert study_path("paper-torus") in paper_studies()


def test_the_figures_have_the_grid_of_the_paper():
    for name in ("paper-sphere-unprojected", "paper-sphere", "paper-torus"):
        study = load_study(study_path(name))
        assert study.sweep.vertices == [30 * 2**i for i in range(8)]
        assert study.sweep.tau == pytest.approx([0.2 / 2**j for j in range(8)], rel=1e-15)
        assert (study.scheme.degree, study.sweep.final_time) == (2, 1.0)


def test_the_ablation_varies_theta_projections_and_bdf_alone():
    found = [load_study(study_path(name)) for name in VARIANTS]
    schemes = {(s.scheme.bdf, s.scheme.theta, s.scheme.project) for s in found}
    assert len(schemes) == 8
    assert len({(s.solution, s.law, tuple(s.sweep.tau), s.sweep.final_time) for s in found}) == 1


def test_only_chooses_studies_and_flows():
    plan = PLAN.only(["ellipsoid", "paper-torus"])
    assert plan.names == ("paper-torus", "ellipsoid")
    with pytest.raises(BadInput, match="--only nothing: must be one of paper-"):
        PLAN.only(["nothing"])


def test_a_folder_without_studies_is_refused(tmp_path):
    with pytest.raises(BadInput, match="holds neither"):
        plan_in(tmp_path)


def test_a_study_not_named_as_its_file_is_refused(tmp_path):
    write_study(tmp_path, name="other.toml")
    with pytest.raises(BadInput, match=r"must be named after its study, small\.toml"):
        plan_in(tmp_path)
