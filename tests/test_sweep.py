"""Sweeps: what is stored is not repeated, whatever happened before."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pytest
from studies import write_study

from harness import run_study
from harness.api import meshes_of, run_studies
from harness.cell import cells_of, progress
from harness.errors import VARIABLES
from harness.store import record_path
from harness.study import load_study
from harness.verdict import worst

SMALLER = ("vertices = [30, 60, 120, 240]", "vertices = [30, 60]")
ERRORS = [f"err_{name}" for name in VARIABLES]


def times_of_records(out) -> dict[str, int]:
    return {p.name: p.stat().st_mtime_ns for p in (out / "small" / "records").glob("*.json")}


def assert_same_numbers(one: pd.DataFrame, other: pd.DataFrame) -> None:
    # Runs of one program on one machine; threads may reorder sums, so not to the last bit.
    np.testing.assert_allclose(one[ERRORS], other[ERRORS], rtol=1e-9, atol=1e-13)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    return run_study(write_study(folder, SMALLER), out=folder / "out", jobs=1)


def test_records_are_a_table_with_a_row_a_run(undisturbed):
    assert len(undisturbed) == 4
    assert set(undisturbed["status"]) == {"ok"}
    assert (undisturbed["steps"] * undisturbed["tau"] == undisturbed["final_time"]).all()


def test_h_is_measured_and_falls_with_the_vertices(undisturbed):
    h = undisturbed.groupby("vertices")["h"].first()
    # h = sqrt(4 area / (sqrt(3) E)) with E = 2 V - 4 on a sphere of area just below 4 pi.
    expected = np.sqrt(16 * np.pi / (np.sqrt(3) * (2 * h.index.to_numpy() - 4)))
    np.testing.assert_allclose(h, expected, rtol=1e-2)


def test_a_second_run_repeats_nothing(tmp_path):
    study, out = write_study(tmp_path, SMALLER), tmp_path / "out"
    first = run_study(study, out=out, jobs=1)
    before = times_of_records(out)
    second = run_study(study, out=out, jobs=1)
    assert times_of_records(out) == before
    pd.testing.assert_frame_equal(first, second)


def test_force_repeats_everything(tmp_path):
    study, out = write_study(tmp_path, SMALLER), tmp_path / "out"
    run_study(study, out=out, jobs=1)
    before = times_of_records(out)
    run_study(study, out=out, jobs=1, force=True)
    after = times_of_records(out)
    assert after.keys() == before.keys()
    assert all(after[name] > before[name] for name in before)


def test_only_what_is_missing_or_damaged_is_computed(tmp_path, undisturbed):
    study, out = write_study(tmp_path, SMALLER), tmp_path / "out"
    run_study(study, out=out, jobs=1)
    before = times_of_records(out)
    lost, damaged, *_ = sorted(before)
    folder = out / "small" / "records"
    (folder / lost).unlink()
    (folder / damaged).write_text((folder / damaged).read_text()[:100])
    records = run_study(study, out=out, jobs=1)
    changed = {name for name, written in times_of_records(out).items() if written != before[name]}
    assert changed == {lost, damaged}
    assert (folder / f"{damaged}.damaged").exists()
    assert_same_numbers(records, undisturbed)


def test_a_changed_study_computes_only_its_new_cells(tmp_path):
    out = tmp_path / "out"
    run_study(write_study(tmp_path, SMALLER), out=out, jobs=1)
    before = times_of_records(out)
    wider = (SMALLER[0], "vertices = [20, 30, 60]")
    run_study(write_study(tmp_path, wider), out=out, jobs=1)
    after = times_of_records(out)
    assert len(after) == len(before) + 2
    assert all(after[name] == before[name] for name in before)


def test_two_processes_give_the_numbers_of_one(tmp_path, undisturbed):
    records = run_study(write_study(tmp_path, SMALLER), out=tmp_path / "out", jobs=2)
    assert_same_numbers(records, undisturbed)


def test_a_diverging_run_is_a_result_with_name_and_time(tmp_path):
    torus = [
        ('name = "sphere"', 'name = "clifford_torus"'),
        ("radius = 1.0", "scale = 1.0"),
        ("vertices = [30, 60, 120, 240]", "vertices = [30]"),
        ("tau = [0.25, 0.125]", "tau = [0.05]"),
        ("bdf = 2", "bdf = 1"),
    ]
    (result,) = run_studies([write_study(tmp_path, *torus)], out=tmp_path / "out", jobs=1)
    run = result.records.iloc[0]
    assert run["status"] == "diverged"
    assert 0 < run["stopped_at"] <= 0.5
    assert np.isnan(run["err_x"]) and np.isnan(run["energy_T"])
    assert worst(result.verdicts) == "inconclusive"


def test_a_generated_mesh_is_kept_and_used_again(tmp_path, monkeypatch):
    study = write_study(tmp_path, (SMALLER[0], "vertices = [25]"))
    first = run_study(study, out=tmp_path / "out", jobs=1)
    assert (tmp_path / "out" / "meshes" / "sphere" / "V00025.npz").exists()
    monkeypatch.setattr("harness.api.surface_mesh", lambda *_: pytest.fail("generated again"))
    second = run_study(study, out=tmp_path / "out", jobs=1)
    assert (first["key"] == second["key"]).all()


def test_the_solution_scale_reaches_the_mesh(tmp_path):
    scaled = [SMALLER, ("radius = 1.0", "radius = 2.0"), ("tau = [0.25, 0.125]", "tau = [0.25]")]
    records = run_study(write_study(tmp_path, *scaled), out=tmp_path / "out", jobs=1)
    assert records["h"].iloc[0] == pytest.approx(2 * 0.7187, rel=1e-2)
    assert records["energy_0"].iloc[0] == pytest.approx(8 * np.pi, rel=1e-2)


def cells(study, out):
    loaded = load_study(study)
    from rich.console import Console

    meshes = meshes_of(loaded, out / "meshes", Console(quiet=True))
    return cells_of(loaded, out / "small", meshes)


def test_progress_of_a_cell_that_does_not_run_is_none(tmp_path):
    cell = cells(write_study(tmp_path, SMALLER), tmp_path)[0]
    assert progress(cell) is None


def test_cost_grows_with_vertices_and_steps(tmp_path):
    by_case = {
        (c.case.vertices, c.case.tau): c.cost
        for c in cells(write_study(tmp_path, SMALLER), tmp_path)
    }
    assert by_case[60, 0.25] > by_case[30, 0.25]
    assert by_case[30, 0.125] == 2 * by_case[30, 0.25]


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_killed_sweep_resumes_with_the_numbers_of_an_undisturbed_one(tmp_path, jobs):
    longer = [
        ("vertices = [30, 60, 120, 240]", "vertices = [60, 120, 240]"),
        ("tau = [0.25, 0.125]", "tau = [0.025, 0.0125]"),
    ]
    study, out = write_study(tmp_path, *longer), tmp_path / "out"
    expected = run_study(study, out=tmp_path / "undisturbed", jobs=2)
    command = [sys.executable, "-m", "harness", "run", study, "--out", out, "--jobs", str(jobs)]
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    deadline = time.monotonic() + 60
    while len(times_of_records(out)) < 2:
        assert time.monotonic() < deadline, "no record within a minute"
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    # Workers notice that their owner is gone at their next step.
    time.sleep(3.0)
    finished = times_of_records(out)
    assert 2 <= len(finished) < len(expected)
    records = run_study(study, out=out, jobs=jobs)
    after = times_of_records(out)
    assert all(after[name] == written for name, written in finished.items())
    assert not list((out / "small" / "progress").iterdir())
    assert_same_numbers(records, expected)


def test_a_record_lies_under_its_key(tmp_path):
    study, out = write_study(tmp_path, SMALLER), tmp_path / "out"
    records = run_study(study, out=out, jobs=1)
    assert all(record_path(out / "small", key).exists() for key in records["key"])
