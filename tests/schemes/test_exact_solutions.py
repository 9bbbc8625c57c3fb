"""Other schemes on exact solutions that move: their errors fall in h, and in tau with order 1."""

from functools import cache

import numpy as np
import pytest

from esfem.meshes import surface_mesh
from esfem.runs.run_case import Record, run_case
from esfem.studies.case import Case

MOVING = {
    "bgn": (
        {"name": "helfrich_sphere", "spontaneous_curvature": 0.5},
        {"name": "helfrich", "spontaneous_curvature": 0.5},
    ),
    "dziuk": ({"name": "logistic_sphere", "r1": 3.0, "rate": 2.0}, {"name": "willmore"}),
}
STEPS = {"bgn": (16, 32), "dziuk": (4, 8)}  # to t = 0.08, where order 1 has settled
each_scheme = pytest.mark.parametrize("name", MOVING)


@cache
def record(name: str, degree: int, vertices: int, tau: float, steps: int) -> Record:
    solution, law = MOVING[name]
    case = Case.model_validate(
        {
            "solution": solution,
            "law": law,
            "scheme": {"name": name, "degree": degree},
            "vertices": vertices,
            "tau": tau,
            "final_time": steps * tau,
        }
    )
    found = run_case(case, surface_mesh("sphere", vertices))[0]
    assert found.status == "ok", found.reason
    return found


def error(found: Record) -> float:
    """Of x in H^1, or of the distance to the surface where nodes slide; the largest over time."""
    return max(found.h1()["x"] if found.l2 else found.levels["err_distance"])


@each_scheme
def test_error_falls_in_h(name):
    """Of P_2, with an error in time that is far below: at least order 2 - 0.3, no more than 5."""
    coarse, fine = (record(name, 2, V, 2.5e-4, 4) for V in (30, 120))
    order = np.log(error(coarse) / error(fine)) / np.log(coarse.h / fine.h)
    assert 1.7 < order < 5.0


@each_scheme
def test_error_falls_in_tau_with_order_one(name):
    """On a mesh of P_4 whose error, seen after a tiny step, is below a tenth of that in time."""
    coarse, fine = (record(name, 4, 60, 0.08 / steps, steps) for steps in STEPS[name])
    assert error(record(name, 4, 60, 1e-6, 1)) < 0.1 * error(fine)
    assert 0.8 < np.log2(error(coarse) / error(fine)) < 1.2
