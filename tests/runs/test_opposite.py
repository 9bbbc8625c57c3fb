"""The run from the opposite amplitude of a decaying mode."""

import pytest

from esfem.meshes import surface_mesh
from esfem.runs import run_case as module
from esfem.solver import Diverged
from esfem.studies.catalogue import study_path
from esfem.studies.study import load_study


@pytest.mark.parametrize("reached", [0, 2])
def test_a_run_that_diverges_has_the_amplitudes_so_far(monkeypatch, reached):
    """None, if it could not even start."""
    case = load_study(study_path("decay-sphere-2")).cases()[0]
    whole = module.states

    def ends_early(problem, levels):
        for n, state in enumerate(whole(problem, levels)):
            if n == reached:
                raise Diverged("as told", state.t)
            yield state

    monkeypatch.setattr(module, "states", ends_early)
    surface = surface_mesh(case.initial.mesh_surface, case.vertices)
    amplitudes, ending = module.opposite_amplitudes(case, surface)
    assert (len(amplitudes), ending.status) == (reached, "diverged")
    assert all(amplitude < 0.0 for amplitude in amplitudes)
