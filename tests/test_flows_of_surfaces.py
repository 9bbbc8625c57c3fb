"""Studies of named surfaces: against the axisymmetric solver, and against the finest level."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from studies import write_study

import harness.self_convergence
from harness.api import run_studies
from harness.case import Case, Law, Solution
from harness.meshing import surface_mesh
from harness.reference import against_profile, lattice_surface
from harness.runner import computational_mesh, run_case
from harness.schemes.kll import KLLOptions
from harness.selection import exclusions, judged_runs, too_fine
from harness.start_states import initial_state
from harness.store import key, read_record, snapshots_path
from harness.study import load_study
from harness.verdicts import judge
from reference_solutions import SurfaceFlow
from reference_solutions.laws import velocity
from solver.functionals import area, volume, willmore_energy
from solver.geometry import geometry

SURFACE = ('name = "sphere"\nradius = 1.0', 'name = "surface"\nsurface = "ellipsoid"')
NO_CLAIM = ('claim = "section-7"\n', "")


def case(reference: str, **changes) -> Case:
    scheme = KLLOptions(degree=2, bdf=2, project=True, theta=True)
    given = {
        "solution": Solution(name="surface", surface="ellipsoid", reference=reference),
        "law": Law(name="willmore"),
        "scheme": scheme,
        "vertices": 120,
        "tau": 0.01,
        "final_time": 0.04,
        "compare_at": (0.02, 0.04),
    }
    return Case(**{**given, **changes})


@pytest.fixture(scope="module")
def flow_record():
    return run_case(case("axisymmetric"), surface_mesh("ellipsoid", 120))


@pytest.fixture(scope="module")
def self_study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("self")
    sweep = (
        "vertices = [30, 60, 120, 240, 480]\ntau = [0.25, 0.125]\nfinal_time = 0.5",
        "vertices = [120, 240, 480]\ntau = [0.005]\nfinal_time = 0.01\ncompare_at = [0.005, 0.01]",
    )
    return write_study(folder, SURFACE, NO_CLAIM, sweep)


class TestAxisymmetric:
    def test_energy_area_volume_and_shape_agree(self, flow_record):
        compared = flow_record[0].compared
        assert compared["t"] == pytest.approx([0.02, 0.04])
        for name, bound in (("W", 0.02), ("area", 0.01), ("volume", 0.01), ("distance", 0.02)):
            assert 0 < max(compared[name]) < bound, name

    def test_distances_both_ways_are_alike(self, flow_record):
        compared = flow_record[0].compared
        np.testing.assert_allclose(compared["distance_back"], compared["distance"], rtol=0.5)

    def test_a_larger_surface_does_not_agree(self):
        solution = SurfaceFlow("ellipsoid", "axisymmetric")
        mesh, p = computational_mesh(surface_mesh("ellipsoid", 240), solution, 2)
        flow = solution.profile_flow("willmore", {}, (0.0, 0.01))
        exact = initial_state(Law(name="willmore"), p, solution)
        for factor in (1.0, 1.01):
            state = replace(exact, x=factor * exact.x, H=exact.H / factor)
            geo = geometry(mesh, state.x)
            numbers = {
                "energy": willmore_energy(geo, state.H),
                "area": area(geo),
                "volume": volume(geo),
            }
            found = against_profile(mesh, state, numbers, flow, 0)
            expected = {"W": 0.0, "area": factor**2 - 1, "volume": factor**3 - 1}
            for name, error in expected.items():
                assert found[name] == pytest.approx(error, abs=1e-3), name
            assert found["distance"] == pytest.approx(2.0 * (factor - 1.0), abs=2e-3)

    def test_the_lattice_surface_has_the_area_of_the_curved_one(self):
        surface = surface_mesh("ellipsoid", 120)
        mesh, p = computational_mesh(surface, SurfaceFlow("ellipsoid"), 3)
        points, triangles = lattice_surface(mesh, p)
        corners = points[triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat = 0.5 * np.linalg.norm(normal, axis=1).sum()
        assert flat == pytest.approx(area(geometry(mesh, p)), rel=2e-3)
        assert (np.einsum("fa,fa->f", normal, corners.mean(axis=1)) > 0).all()

    def test_a_flow_keeps_no_snapshots(self, flow_record):
        assert flow_record[1] is None


class TestStart:
    def test_the_velocity_is_that_of_the_law(self):
        solution = SurfaceFlow("red_blood_cell")
        _, p = computational_mesh(surface_mesh("red_blood_cell", 120), solution, 2)
        state = initial_state(Law(name="surface_diffusion"), p, solution)
        np.testing.assert_allclose(state.V, solution.fields(p).laplace_H, rtol=1e-12)
        helfrich = {"spontaneous_curvature": 0.7}
        other = initial_state(Law(name="helfrich", **helfrich), p, solution)
        np.testing.assert_allclose(other.V, velocity("helfrich", helfrich, solution.fields(p)))

    def test_the_key_changes_with_the_file_of_the_surface(self, monkeypatch):
        before = key(case("finest"), "mesh")
        monkeypatch.setattr("harness.store.surface_digest", lambda name: "another")
        assert key(case("finest"), "mesh") != before


@pytest.fixture(scope="module")
def result(self_study):
    return run_studies([self_study], self_study.parent / "out")[0]


class TestAgainstFinest:
    def test_the_finest_level_is_a_reference_and_the_others_have_errors(self, result):
        assert result.records["status"].tolist() == ["ok", "ok", "reference"]
        errors = result.records[[f"err_{name}" for name in result.study.variables]]
        assert errors.iloc[:2].gt(0).all().all()
        assert errors.iloc[2].isna().all()
        assert errors.iloc[1].lt(errors.iloc[0]).all()

    def test_only_levels_twice_as_coarse_may_be_judged(self, result):
        assert too_fine(result.study, result.records) == [240, 480]
        assert any("V = 240, 480" in line for line in exclusions(result.study, result.records))

    def test_tables_say_that_it_is_self_convergence(self, result):
        assert "against finest" in (result.folder / "table.md").read_text()
        assert all("against finest" in verdict.norm for verdict in result.verdicts)

    def test_what_was_compared_is_read_again(self, self_study, result, monkeypatch):
        monkeypatch.setattr(harness.self_convergence, "_compare", None)
        again = run_studies([self_study], self_study.parent / "out")[0]
        pd.testing.assert_frame_equal(again.records, result.records)

    def test_damaged_snapshots_are_set_aside_with_their_record(self, self_study, result):
        folder, record_key = result.folder, result.records["key"].iloc[0]
        path = snapshots_path(folder, record_key)
        path.write_bytes(path.read_bytes()[:-100])
        lines: list[str] = []
        assert read_record(folder, record_key, lines.append) is None
        assert "snapshots" in lines[0]
        again = run_studies([self_study], self_study.parent / "out")[0]
        numbers = [f"err_{name}" for name in result.study.variables]
        pd.testing.assert_frame_equal(again.records[numbers], result.records[numbers])

    def test_without_its_finest_run_nothing_has_an_error(self, self_study, result):
        study = load_study(self_study)
        records = result.records.assign(status=["ok", "ok", "diverged"])
        assert judged_runs(study, records).empty
        assert {v.verdict for v in judge(study, records)} == {"no claim"}


def test_the_reference_of_a_stopped_finest_run_is_missing(self_study, tmp_path, monkeypatch):
    """Coarser runs are then kept, shown as runs without errors."""
    from harness import collect

    out = tmp_path / "out"
    done = run_studies([self_study], out)[0]
    path = done.folder / "records" / f"{done.records['key'].iloc[-1]}.json"
    content = json.loads(path.read_text())
    assert content["record"]["status"] == "ok"
    original = collect.read_record

    def stopped(folder, record_key, complain):
        record = original(folder, record_key, complain)
        if record.case["vertices"] != 480:
            return record
        return type(record)(**{**vars(record), "status": "diverged", "stopped_at": 0.005})

    monkeypatch.setattr(collect, "read_record", stopped)
    again = run_studies([self_study], out)[0]
    assert again.records["status"].tolist() == ["reference", "reference", "diverged"]
    assert again.records["err_x"].isna().all()
