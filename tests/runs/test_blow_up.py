"""Runs that blow up end under one name, whether the guard sees it or GMRES first."""

import re

import pytest

from esfem.meshes.library import surface_mesh
from esfem.runs.run_case import run_case
from esfem.studies.case import Case

# (solution, BDF, tau): in each GMRES fails in a step, from States that have left their start.
BLOW_UPS = {
    "torus": ({"name": "clifford_torus"}, 2, 0.0125, r"max \|V\| = .* exceeds"),
    "ellipsoid": ({"name": "breathing_ellipsoid", "amplitude": 0.5}, 2, 0.1, "is inverted"),
}


@pytest.mark.parametrize("name", BLOW_UPS)
def test_gmres_that_fails_on_a_blow_up_is_divergence(name):
    solution, bdf, tau, reason = BLOW_UPS[name]
    scheme = {"name": "kll", "degree": 2, "bdf": bdf, "project": False, "theta": True}
    case = Case.model_validate(
        {
            "solution": solution,
            "law": {"name": "willmore"},
            "scheme": scheme,
            "vertices": 60,
            "tau": tau,
            "final_time": 80 * tau if name == "torus" else 1.0,
        }
    )
    record, _ = run_case(case, surface_mesh(case.initial.mesh_surface, 60))
    assert record.status == "diverged"
    assert record.stopped_at < case.final_time
    assert re.search(reason, record.reason)
    assert "GMRES" in record.reason
