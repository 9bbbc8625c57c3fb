"""The sham schemes: what they hand out, and that small studies see through them."""

from pathlib import Path

import numpy as np
import pytest

from esfem.campaigns.mutants.sham_trials import tried
from esfem.campaigns.mutants.shams import SHAMS, planted, states_of
from esfem.meshes import surface_mesh
from esfem.runs.problem import problem_of
from esfem.runs.run_case import computational_mesh
from esfem.runs.stepping import states
from esfem.schemes import named_scheme
from esfem.studies.catalogue import study_path
from esfem.studies.study import Study, load_study

NOTHING, HALF, LATE = SHAMS
STUDIES = Path(__file__).parents[2] / "harness" / "studies"
MOVING = {
    "ellipsoid-degree-3": True,
    "flow-map-ellipsoid-degree-3": True,
    "gauss-bonnet-ellipsoid": True,
    "defects-ellipsoid-degree-4": False,
    "defects-ellipsoid-degree-3": False,
    "clifford-degree-3": False,
    "helfrich-bdf2": False,
}


def small(name: str, vertices: list[int], **changes: object) -> Study:
    """A committed study with a smaller sweep."""
    study = load_study(STUDIES / f"{name}.toml")
    sweep = {**study.sweep.model_dump(), "vertices": vertices, **changes}
    return Study.model_validate({**study.model_dump(), "sweep": sweep})


@pytest.fixture
def evolution():
    """Problem and levels of a small run on the moving ellipsoid."""
    case = small("full/ellipsoid-degree-2", [30], tau=[0.02], final_time=0.1).cases()[0]
    surface = surface_mesh(case.initial.mesh_surface, case.vertices)
    mesh, p = computational_mesh(surface, case.initial, case.scheme.degree)
    return problem_of(case, mesh, p, case.initial), case.levels


def test_does_nothing(evolution):
    problem, levels = evolution
    with planted(NOTHING):
        found = list(states(problem, levels))
    assert [state.t for state in found] == [levels.t(n) for n in range(levels.steps + 1)]
    assert all(state.x is problem.initial.x and state.H is problem.initial.H for state in found)


def test_late(evolution):
    problem, levels = evolution
    honest = list(states(problem, levels))
    with planted(LATE):
        found = list(states(problem, levels))
    assert [state.t for state in found] == [state.t for state in honest]
    for state, before in zip(found[1:], honest, strict=False):
        np.testing.assert_array_equal(state.x, before.x)


def test_half_speed_moves_by_half_its_velocity(evolution):
    """The surface is that of half of the time, and x' = v of what it hands out."""
    problem, levels = evolution
    with planted(HALF):
        found = list(states(problem, levels))
    exact = problem.exact(levels.t(levels.steps) / 2.0)
    assert np.abs(found[-1].x - exact.x).max() < 0.02 * np.abs(exact.x - problem.initial.x).max()
    step = (found[3].x - found[1].x) / (found[3].t - found[1].t)
    assert np.abs(step - found[2].v).max() < 0.05 * np.abs(found[2].v).max()


def test_the_scheme_is_there_again():
    honest = named_scheme("kll")
    with pytest.raises(ZeroDivisionError), planted(NOTHING):
        assert named_scheme("kll") is not honest
        raise ZeroDivisionError
    assert named_scheme("kll") is honest


def test_a_scheme_that_is_given_by_its_step():
    case = small("schemes/ellipsoid-dziuk", [30], tau=[0.001], final_time=0.003).cases()[0]
    surface = surface_mesh(case.initial.mesh_surface, case.vertices)
    mesh, p = computational_mesh(surface, case.initial, case.scheme.degree)
    problem = problem_of(case, mesh, p, case.initial)
    own = list(states_of(named_scheme("dziuk"), problem, case.levels))
    with planted(LATE, "dziuk"):
        found = list(states(problem, case.levels))
    np.testing.assert_array_equal(found[-1].x, own[-2].x)


def test_half_the_speed_must_be_caught_where_a_scheme_makes_what_is_judged():
    """Not where defects are: those of exact States are the same for any scheme."""
    must = {name: HALF.tries(load_study(study_path(name))) for name in MOVING}
    assert must == MOVING


@pytest.mark.slow
@pytest.mark.parametrize(
    "study",
    [
        small("full/ellipsoid-degree-2", [30, 60, 120, 240, 480], tau=[0.01]),
        small("helfrich-bdf2", [30, 60], tau=[0.1, 0.05, 0.025, 0.0125]),
        small("full/clifford-degree-2", [30, 60, 120, 240, 480], tau=[0.025], final_time=0.1),
        small("sphere", [30, 60, 120, 240, 480], tau=[0.05], final_time=0.2),
    ],
    ids=lambda study: study.name,
)
def test_small_studies_catch_what_they_must(study):
    missed = [line for line in tried(study) if line.must and not line.caught]
    assert not missed
