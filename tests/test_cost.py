"""The cost model: what is stored corrects what was known before."""

import json

import numpy as np
import pytest
from studies import write_study

from harness import run_study
from harness.cell import Cell
from harness.cost import CostModel, features, fitted, nodes_of, remaining, stored_timings
from harness.meshing import surface_mesh
from harness.study import load_study
from solver import elevate


@pytest.fixture
def cell(tmp_path):
    def make(vertices: int, tau: float) -> Cell:
        study = load_study(write_study(tmp_path))
        case = study.cases()[0].model_copy(update={"vertices": vertices, "tau": tau})
        return Cell("small", tmp_path, case, surface_mesh("sphere", vertices))

    return make


def test_nodes_are_those_of_the_mesh():
    surface = surface_mesh("sphere", 30)
    for k in (1, 2, 3, 4):
        mesh, _ = elevate(surface.triangles, surface.vertices, k, lambda x: x)
        assert nodes_of(30, len(surface.triangles), k) == mesh.node_count


def test_finer_takes_longer(cell):
    model = CostModel()
    assert model.seconds(cell(30, 0.25)) < model.seconds(cell(60, 0.25))
    assert model.seconds(cell(30, 0.25)) < model.seconds(cell(30, 0.125))


def runs(count: int, law) -> list[tuple[np.ndarray, float]]:
    rng = np.random.default_rng(0)
    sizes = zip(rng.uniform(100, 10_000, count), rng.uniform(10, 1000, count), strict=True)
    rows = [features(nodes, steps, 2, False) for nodes, steps in sizes]
    return [(row, law(row)) for row in rows]


def test_without_timings_it_is_the_prior():
    assert fitted([]) == CostModel()


def test_one_slow_run_tells_of_a_slow_machine():
    (row, expected), *_ = runs(1, lambda row: float(np.exp(row @ CostModel().coefficients)))
    slow = fitted([(row, 10 * expected)])
    assert np.exp(row @ slow.coefficients) == pytest.approx(10 * expected, rel=0.15)


def test_many_runs_overrule_the_prior():
    truth = np.array([-9.0, 0.8, 1.0, -0.68, 0.22])
    model = fitted(runs(200, lambda row: float(np.exp(row @ truth))))
    rows = [row for row, _ in runs(20, len)]
    np.testing.assert_allclose([r @ model.coefficients for r in rows], rows @ truth, atol=0.05)


def test_timings_are_those_of_the_records(tmp_path):
    changes = [
        ("vertices = [30, 60, 120, 240, 480]", "vertices = [30, 60]"),
        ('claim = "section-7"', ""),
    ]
    table = run_study(write_study(tmp_path, *changes), out=tmp_path / "out", jobs=1)
    found = stored_timings(tmp_path / "out")
    assert sorted(s for _, s in found) == pytest.approx(sorted(table["seconds"]))
    (tmp_path / "out" / "small" / "records" / "damaged.json").write_text(json.dumps({}))
    assert len(stored_timings(tmp_path / "out")) == len(found)


def test_the_schedule_fills_the_first_free_worker():
    assert remaining([], [], 2) == 0.0
    assert remaining([], [4, 3, 2, 1], 2) == 5.0
    assert remaining([6.0], [4, 1], 2) == 6.0
    assert remaining([3.0, 2.0, 1.0], [1], 2) == 3.0  # one runs in another sweep
