"""Sweeps: what is stored is not repeated, whatever happened before."""

import errno
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from studies import write_study

from esfem import run_study
from esfem.common.bad_input import BadInput
from esfem.common.provenance import numerics_digest
from esfem.judging.outcome import worst
from esfem.measuring.lift import VARIABLES
from esfem.meshes import library, meshes_of
from esfem.results.run_studies import run_studies
from esfem.runs import store
from esfem.runs.run_case import run_case
from esfem.runs.store import cells_of, progress, record_path
from esfem.runs.work import BUSY, Orders, Outcome, compute, held, keeper_of, lease_of
from esfem.studies.study import load_study

SMALLER = ("vertices = [30, 60, 120, 240, 480]", "vertices = [30, 60]")
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


@pytest.mark.parametrize("stored", [False, True])
def test_each_record_is_read_once(tmp_path, monkeypatch, stored):
    study, out = write_study(tmp_path, SMALLER), tmp_path / "out"
    if stored:
        run_study(study, out=out, jobs=1)
    read, original = [], store.read_record

    def counted(folder, record_key, complain):
        record = original(folder, record_key, complain)
        read.extend([record_key] * (record is not None))
        return record

    monkeypatch.setattr(store, "read_record", counted)
    run_study(study, out=out, jobs=1)
    assert sorted(f"{key}.json" for key in read) == sorted(times_of_records(out))


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
    no_floors = ('claim = "section-7"', "")
    run_study(write_study(tmp_path, SMALLER, no_floors), out=out, jobs=1)
    before = times_of_records(out)
    wider = (SMALLER[0], "vertices = [20, 30, 60]")
    run_study(write_study(tmp_path, wider, no_floors), out=out, jobs=1)
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
        ("vertices = [30, 60, 120, 240, 480]", "vertices = [30]"),
        ("tau = [0.25, 0.125]", "tau = [0.05]"),
        ("bdf = 2", "bdf = 1"),
        ("final_time = 0.5", "final_time = 1.0"),
    ]
    (result,) = run_studies([write_study(tmp_path, *torus)], out=tmp_path / "out", jobs=1)
    run = result.records.iloc[0]
    assert run["status"] == "diverged"
    assert 0 < run["stopped_at"] <= 1.0
    assert np.isnan(run["err_x"]) and np.isnan(run["energy_T"])
    assert worst(result.verdicts) == "inconclusive"


def test_a_generated_mesh_is_kept_and_used_again(tmp_path, monkeypatch):
    study = write_study(tmp_path, (SMALLER[0], "vertices = [25]"))
    first = run_study(study, out=tmp_path / "out", jobs=1)
    assert (tmp_path / "out" / "meshes" / "sphere" / "V00025.npz").exists()
    monkeypatch.setattr(library, "surface_mesh", lambda *_: pytest.fail("generated again"))
    second = run_study(study, out=tmp_path / "out", jobs=1)
    assert (first["key"] == second["key"]).all()


def test_the_solution_scale_reaches_the_mesh(tmp_path):
    scaled = [SMALLER, ("radius = 1.0", "radius = 2.0"), ("tau = [0.25, 0.125]", "tau = [0.25]")]
    records = run_study(write_study(tmp_path, *scaled), out=tmp_path / "out", jobs=1)
    assert records["h"].iloc[0] == pytest.approx(2 * 0.7187, rel=1e-2)
    assert records["energy_0"].iloc[0] == pytest.approx(8 * np.pi, rel=1e-2)


def cells(study, out):
    loaded = load_study(study)
    meshes = meshes_of("sphere", loaded.sweep.vertices, out / "meshes", print)
    return cells_of(loaded, out / "small", meshes)


def test_progress_of_a_cell_that_does_not_run_is_none(tmp_path):
    cell = cells(write_study(tmp_path, SMALLER), tmp_path)[0]
    assert progress(cell) is None


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_killed_sweep_resumes_with_the_numbers_of_an_undisturbed_one(tmp_path, jobs):
    longer = [
        ("vertices = [30, 60, 120, 240, 480]", "vertices = [60, 120, 240]"),
        ("tau = [0.25, 0.125]", "tau = [0.025, 0.0125]"),
    ]
    study, out = write_study(tmp_path, *longer), tmp_path / "out"
    expected = run_study(study, out=tmp_path / "undisturbed", jobs=2)
    command = [sys.executable, "-m", "esfem", "run", study, "--out", out, "--jobs", str(jobs)]
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


BITS = ["key", *ERRORS, *(f"{e}_l2" for e in ERRORS), "energy_T", "area_T", "volume_T"]
LONG = [("vertices = [30, 60, 120, 240, 480]", "vertices = [30, 60]"), ('claim = "section-7"', "")]
LONG += [("tau = [0.25, 0.125]", "tau = [0.001]")]


def start_sweep(study, out, *options) -> subprocess.Popen:
    command = [sys.executable, "-m", "esfem", "run", study, "--out", out, *options]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen([str(word) for word in command], **quiet)


def children(process: subprocess.Popen) -> list[int]:
    listed = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    return [int(pid) for pid in listed.read_text().split()]


def leased_since(out: Path, began: float) -> bool:
    leases = out.glob("small/progress/*.lease")
    return any(path.stat().st_mtime > began for path in leases)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs the list of children")
@pytest.mark.parametrize("seed", range(2))
def test_killed_at_random_moments_it_ends_with_the_same_bits(tmp_path, seed):
    study, rng = write_study(tmp_path, *LONG), random.Random(seed)
    expected = run_study(study, out=tmp_path / "undisturbed", jobs=2)
    out, checkpoints = tmp_path / "out", 0
    for _ in range(3):
        began = time.time()
        process = start_sweep(study, out, "--jobs", 2, "--checkpoint", 0.1)
        while not leased_since(out, began) and process.poll() is None:
            assert time.time() < began + 240
            time.sleep(0.01)
        time.sleep(rng.uniform(0.0, 1.5))
        victims = [*children(process), process.pid] if process.poll() is None else []
        for victim in victims if rng.random() < 0.5 else victims[:1]:
            os.kill(victim, signal.SIGKILL)
        process.wait()
        checkpoints += len(list(out.glob("small/checkpoints/*.npz")))
    records = run_study(study, out=out, jobs=2)
    numbers = [name for name in BITS if name in records]
    pd.testing.assert_frame_equal(records[numbers], expected[numbers], check_exact=True)
    assert not list((out / "small" / "progress").iterdir())
    assert checkpoints == 0 or not list((out / "small" / "checkpoints").iterdir())


@pytest.mark.slow
def test_two_sweeps_at_once_share_the_work(tmp_path):
    more = ("tau = [0.001]", "tau = [0.004, 0.002, 0.001]")
    study, out = write_study(tmp_path, *LONG, more), tmp_path / "out"
    both = [start_sweep(study, out, "--jobs", 1) for _ in range(2)]
    assert [process.wait(240) for process in both] == [0, 0]
    found = times_of_records(out)
    assert len(found) == 6
    assert not list((out / "small" / "progress").iterdir())
    records = run_study(study, out=out, jobs=1)
    assert times_of_records(out) == found
    assert_same_numbers(records, run_study(study, out=tmp_path / "alone", jobs=2))


@pytest.mark.slow
def test_a_sweep_finishes_what_a_killed_one_was_computing(tmp_path):
    study, out = write_study(tmp_path, *LONG), tmp_path / "out"
    first = start_sweep(study, out, "--jobs", 2)
    while not list(out.glob("small/progress/*.lease")):
        assert first.poll() is None
        time.sleep(0.01)
    second = start_sweep(study, out, "--jobs", 2)
    time.sleep(1.0)
    for pid in [*children(first), first.pid]:
        os.kill(pid, signal.SIGKILL)
    first.wait()
    assert second.wait(240) == 0
    assert len(times_of_records(out)) == 2


def work_on(study, out, **orders):
    """One cell, computed in this process."""
    return compute(cells(study, out)[0], Orders(numerics=numerics_digest(), **orders))


def test_what_another_process_computes_is_left_alone(tmp_path):
    study = write_study(tmp_path, SMALLER)
    with held(lease_of(cells(study, tmp_path)[0].lease_path)):
        assert work_on(study, tmp_path) == Outcome(BUSY)
    assert work_on(study, tmp_path).status == "ok"
    assert work_on(study, tmp_path) == Outcome("ok")  # stored meanwhile


def test_a_worker_with_other_code_is_refused(tmp_path):
    cell = cells(write_study(tmp_path, SMALLER), tmp_path)[0]
    with pytest.raises(BadInput, match="other code"):
        compute(cell, Orders(numerics="another"))


def test_a_checkpoint_of_another_version_is_told_of_and_left_aside(tmp_path, monkeypatch, caplog):
    study = write_study(tmp_path, SMALLER)
    cell = cells(study, tmp_path)[0]
    keeper = keeper_of(cell, Orders(checkpoint=0.0))
    keeper._identity["numerics"] = "old"
    run_case(cell.case, cell.surface, keeper=keeper)
    assert cell.checkpoint_path.exists()
    assert work_on(study, tmp_path, checkpoint=0.0).status == "ok"
    (line,) = caplog.messages
    assert f"numerics is old there, {numerics_digest()} here; the run starts anew" in line
    assert not cell.checkpoint_path.exists()


def test_a_full_disk_costs_the_checkpoint_but_not_the_run(tmp_path, monkeypatch, caplog):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("esfem.runs.checkpoint.write_checkpoint", full)
    monkeypatch.setattr("esfem.runs.work.write_text", full)
    assert work_on(write_study(tmp_path, SMALLER), tmp_path, checkpoint=0.0).status == "ok"
    assert "No space left on device" in caplog.messages[0]
