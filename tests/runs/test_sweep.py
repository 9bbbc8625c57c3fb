"""Sweeps: what is stored is not repeated, whatever happened before."""

import errno
import os

import numpy as np
import pandas as pd
import pytest
from studies import small_study
from sweeps import SMALLER, assert_same_numbers, times_of_records

from esfem import run_study
from esfem.common.bad_input import BadInput
from esfem.common.provenance import numerics_digest
from esfem.judging.outcome import worst
from esfem.meshes import library, meshes_of
from esfem.results.run_studies import run_studies
from esfem.runs import store
from esfem.runs.run_case import run_case
from esfem.runs.store import cells_of, progress, record_path
from esfem.runs.work import BUSY, Orders, Outcome, compute, held, keeper_of, lease_of
from esfem.studies.study import load_study


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    return run_study(small_study(folder, **SMALLER), out=folder / "out", jobs=1)


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
    study, out = small_study(tmp_path, **SMALLER), tmp_path / "out"
    first = run_study(study, out=out, jobs=1)
    before = times_of_records(out)
    second = run_study(study, out=out, jobs=1)
    assert times_of_records(out) == before
    pd.testing.assert_frame_equal(first, second)


@pytest.mark.parametrize("stored", [False, True])
def test_each_record_is_read_once(tmp_path, monkeypatch, stored):
    study, out = small_study(tmp_path, **SMALLER), tmp_path / "out"
    if stored:
        run_study(study, out=out, jobs=1)
    read = []

    def counting(original):
        def counted(folder, record_key, complain):
            record = original(folder, record_key, complain)
            read.extend([record_key] * (record is not None))
            return record

        return counted

    for name in ("read_record", "read_pair"):
        monkeypatch.setattr(store, name, counting(getattr(store, name)))
    run_study(study, out=out, jobs=1)
    assert sorted(f"{key}.json" for key in read) == sorted(times_of_records(out))


def test_force_repeats_everything(tmp_path):
    study, out = small_study(tmp_path, **SMALLER), tmp_path / "out"
    run_study(study, out=out, jobs=1)
    before = times_of_records(out)
    run_study(study, out=out, jobs=1, force=True)
    after = times_of_records(out)
    assert after.keys() == before.keys()
    assert all(after[name] > before[name] for name in before)


def test_only_what_is_missing_or_damaged_is_computed(tmp_path, undisturbed):
    study, out = small_study(tmp_path, **SMALLER), tmp_path / "out"
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
    run_study(small_study(tmp_path, **SMALLER, claim=None), out=out, jobs=1)  # without floors
    before = times_of_records(out)
    run_study(small_study(tmp_path, vertices=[20, 30, 60], claim=None), out=out, jobs=1)
    after = times_of_records(out)
    assert len(after) == len(before) + 2
    assert all(after[name] == before[name] for name in before)


def test_a_diverging_run_is_a_result_with_name_and_time(tmp_path, figures):
    torus = [
        ('name = "sphere"', 'name = "clifford_torus"'),
        ("radius = 1.0", "scale = 1.0"),
    ]
    study = small_study(tmp_path, *torus, vertices=[30], tau=[0.05], bdf=1, final_time=1.0)
    (result,) = run_studies([study], out=tmp_path / "out", jobs=1)
    run = result.records.iloc[0]
    assert run["status"] == "diverged"
    assert 0 < run["stopped_at"] <= 1.0
    assert np.isnan(run["err_x"]) and np.isnan(run["energy_T"])
    assert worst(result.verdicts) == "inconclusive"


def test_a_generated_mesh_is_kept_and_used_again(tmp_path, monkeypatch):
    study = small_study(tmp_path, vertices=[25])
    first = run_study(study, out=tmp_path / "out", jobs=1)
    assert (tmp_path / "out" / "meshes" / "sphere" / "V00025.npz").exists()
    monkeypatch.setattr(library, "surface_mesh", lambda *_: pytest.fail("generated again"))
    second = run_study(study, out=tmp_path / "out", jobs=1)
    assert (first["key"] == second["key"]).all()


def test_the_solution_scale_reaches_the_mesh(tmp_path):
    study = small_study(tmp_path, **SMALLER, radius=2.0, tau=[0.25])
    records = run_study(study, out=tmp_path / "out", jobs=1)
    assert records["h"].iloc[0] == pytest.approx(2 * 0.7187, rel=1e-2)
    assert records["energy_0"].iloc[0] == pytest.approx(8 * np.pi, rel=1e-2)


def cells(study, out):
    loaded = load_study(study)
    meshes = meshes_of("sphere", loaded.sweep.vertices, out / "meshes", print)
    return cells_of(loaded, out / "small", meshes)


def test_progress_of_a_cell_that_does_not_run_is_none(tmp_path):
    cell = cells(small_study(tmp_path, **SMALLER), tmp_path)[0]
    assert progress(cell) is None


def test_a_record_lies_under_its_key(tmp_path):
    study, out = small_study(tmp_path, **SMALLER), tmp_path / "out"
    records = run_study(study, out=out, jobs=1)
    assert all(record_path(out / "small", key).exists() for key in records["key"])


def work_on(study, out, **orders):
    """One cell, computed in this process."""
    return compute(cells(study, out)[0], Orders(numerics=numerics_digest(), **orders))


def test_what_another_process_computes_is_left_alone(tmp_path):
    study = small_study(tmp_path, **SMALLER)
    with held(lease_of(cells(study, tmp_path)[0].lease_path)):
        assert work_on(study, tmp_path) == Outcome(BUSY)
    assert work_on(study, tmp_path).status == "ok"
    assert work_on(study, tmp_path) == Outcome("ok")  # stored meanwhile


def test_a_worker_with_other_code_is_refused(tmp_path):
    cell = cells(small_study(tmp_path, **SMALLER), tmp_path)[0]
    with pytest.raises(BadInput, match="other code"):
        compute(cell, Orders(numerics="another"))


def test_a_checkpoint_of_another_version_is_told_of_and_left_aside(tmp_path, monkeypatch, caplog):
    study = small_study(tmp_path, **SMALLER)
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
    assert work_on(small_study(tmp_path, **SMALLER), tmp_path, checkpoint=0.0).status == "ok"
    assert "No space left on device" in caplog.messages[0]
