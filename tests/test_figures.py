"""The numbers that the project promises (DESIGN, section 6), on the real meshes."""

import numpy as np
import pytest

from harness.api import run_studies
from harness.eoc import fit_order, rates
from harness.study import STUDIES, load_study


def records(name, tmp_path, scheme=None, **sweep):
    study = load_study(STUDIES / f"{name}.toml")
    changed = study.model_copy(
        update={
            "sweep": study.sweep.model_copy(update=sweep),
            "scheme": study.scheme.model_copy(update=scheme or {}),
        }
    )
    return run_studies([changed], out=tmp_path, jobs=2)[0].records


@pytest.mark.slow
def test_sphere_errors_are_those_of_the_independent_prototype(tmp_path):
    runs = records("sphere", tmp_path, tau=[0.05])
    # Meshes differ, and with them the errors, by up to a quarter.
    expected = [6.5e-2, 2.0e-2, 7.4e-3, 2.6e-3, 9.2e-4, 3.2e-4]
    np.testing.assert_allclose(runs["err_x"], expected, rtol=0.25, atol=0)
    for name in ("x", "nu"):
        assert (rates(runs["h"], runs[f"err_{name}"]) >= 2.0).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("degree", "finest", "low", "high"), [(2, 1920, 1.8, 2.6), (3, 960, 2.7, 3.9)]
)
def test_clifford_torus_has_the_order_of_the_degree(tmp_path, degree, finest, low, high):
    vertices = [finest // 8, finest // 4, finest // 2, finest]
    runs = records("clifford", tmp_path, {"degree": degree}, tau=[0.0125], vertices=vertices)
    for name in ("x", "nu", "H"):
        assert low <= fit_order(runs["h"], runs[f"err_{name}"]).order <= high
    assert fit_order(runs["h"], runs["err_V"]).order > 2


@pytest.mark.slow
@pytest.mark.parametrize("tau", [0.1, 0.05, 0.025])
def test_clifford_torus_with_a_step_between_the_stable_ones_diverges(tmp_path, tau):
    runs = records("clifford", tmp_path, tau=[tau], vertices=[120, 240])
    assert set(runs["status"]) == {"diverged"}
    assert (runs["stopped_at"] < 1.0).all()
