"""Sweeps in processes: the same numbers from two, from several sweeps at once, and after kills."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest
from studies import small_study
from sweeps import ERRORS, SMALLER, assert_same_numbers, times_of_records

from esfem import run_study

pytestmark = pytest.mark.usefixtures("processes")
BITS = ["key", *ERRORS, *(f"{e}_l2" for e in ERRORS), "energy_T", "area_T", "volume_T"]
LONG = {"vertices": [30, 60], "claim": None, "tau": [0.001]}


def test_two_processes_give_the_numbers_of_one(tmp_path):
    undisturbed = run_study(small_study(tmp_path, **SMALLER), out=tmp_path / "one", jobs=1)
    records = run_study(small_study(tmp_path, **SMALLER), out=tmp_path / "out", jobs=2)
    assert_same_numbers(records, undisturbed)


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_killed_sweep_resumes_with_the_numbers_of_an_undisturbed_one(tmp_path, jobs):
    study = small_study(tmp_path, vertices=[60, 120, 240], tau=[0.025, 0.0125])
    out = tmp_path / "out"
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
    study, rng = small_study(tmp_path, **LONG), random.Random(seed)
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
    study = small_study(tmp_path, **{**LONG, "tau": [0.004, 0.002, 0.001]})
    out = tmp_path / "out"
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
    study, out = small_study(tmp_path, **LONG), tmp_path / "out"
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
