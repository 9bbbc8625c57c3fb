"""Executors: the same cells on processes of this machine and on a dask cluster, which may break."""

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from studies import write_study

from harness import run_study
from harness.bad_input import BadInput
from harness.executors import ONE_THREAD, LocalProcesses, WorkerLost, executor_named

LONGER = [
    ("vertices = [30, 60, 120, 240, 480]", "vertices = [30, 60, 120]"),
    ("tau = [0.25, 0.125]", "tau = [0.005, 0.0025]"),
    ('claim = "section-7"', ""),
]
RUNS = 6
NUMBERS = [f"err_{name}" for name in ("x", "nu", "H", "V", "z", "v")]


def square(n: int) -> int:
    return n * n


def die(n: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def threads(n: int) -> str | None:
    return os.environ.get("OMP_NUM_THREADS")


@pytest.mark.parametrize("jobs", [1, 2])
def test_each_item_has_its_result(jobs):
    with LocalProcesses(jobs) as executor:
        assert dict(executor.run(square, [1, 2, 3])) == {1: 1, 2: 4, 3: 9}


def test_a_process_has_one_thread_and_is_another_one():
    with LocalProcesses(1) as executor:
        assert dict(executor.run(threads, [0])) == {0: "1"}


def test_a_killed_process_is_told_and_the_next_run_works():
    with LocalProcesses(2) as executor:
        with pytest.raises(WorkerLost):
            list(executor.run(die, [1, 2]))
        assert dict(executor.run(square, [3])) == {3: 9}


def test_unknown_names_are_refused():
    with pytest.raises(BadInput, match="must be local or dask"):
        executor_named("slurm", None, 1)
    with pytest.raises(BadInput, match="needs --executor dask"):
        executor_named("local", "tcp://here:1", 1)


def test_a_missing_package_is_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BadInput, match=r"esfem-willmore\[cluster\]"):
        executor_named("dask", None, 1).__enter__()


def test_a_scheduler_that_is_not_there_is_one_line(monkeypatch):
    monkeypatch.setattr("harness.executors.CONNECT_SECONDS", 0.5)
    with pytest.raises(BadInput, match="cannot be reached"):
        executor_named("dask", f"tcp://127.0.0.1:{free_port()}", 1).__enter__()


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def process(log: Path, *words):
    """A process that is killed in the end; its output goes to the log."""
    root = Path(__file__).parent.parent
    path = os.pathsep.join(filter(None, [str(root), os.environ.get("PYTHONPATH")]))
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": path}
    with open(log, "ab") as out:
        started = subprocess.Popen(
            [sys.executable, "-m", *map(str, words)], stdout=out, stderr=out, env=environment
        )
    try:
        yield started
    finally:
        started.kill()
        started.wait()


class Cluster:
    """A scheduler and two workers on loopback."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.folder, self.stack = folder, stack
        self.port = free_port()
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.scheduler = self.start_scheduler()
        self.workers = [self.start_worker() for _ in range(2)]

    def start_scheduler(self) -> subprocess.Popen:
        words = ("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", self.port)
        return self._start("scheduler.log", *words, "--no-dashboard")

    def start_worker(self) -> subprocess.Popen:
        words = ("distributed.cli.dask_worker", self.address, "--nthreads", 1, "--no-nanny")
        place = ("--local-directory", self.folder / "scratch")
        return self._start("workers.log", *words, *place, "--no-dashboard")

    def _start(self, log: str, *words) -> subprocess.Popen:
        return self.stack.enter_context(process(self.folder / log, *words))


@pytest.fixture
def cluster(tmp_path):
    pytest.importorskip("distributed")
    with ExitStack() as stack:
        yield Cluster(tmp_path, stack)


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    folder = tmp_path_factory.mktemp("local")
    return run_study(write_study(folder, *LONGER), out=folder / "out", jobs=2)


def start_sweep(cluster, out):
    study = write_study(cluster.folder, *LONGER)
    words = ("harness", "run", study, "--out", out, "--executor", "dask")
    log = cluster.folder / "sweep.log"
    options = ("--scheduler", cluster.address, "--checkpoint", "0.1")
    return cluster.stack.enter_context(process(log, *words, *options))


def wait_for(condition, of: subprocess.Popen | None = None, seconds: float = 120.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert of is None or of.poll() is None, "ended too early"
        assert time.monotonic() < deadline, "waited too long"
        time.sleep(0.02)


def records(out) -> dict[Path, int]:
    return {p: p.stat().st_mtime_ns for p in out.glob("small/records/*.json")}


def holders(out) -> list[str]:
    """The contents of all leases."""
    found = []
    for path in out.glob("small/progress/*.lease"):
        try:
            found.append(path.read_text())
        except OSError:
            pass
    return found


def assert_complete(cluster, out, expected) -> None:
    table = run_study(write_study(cluster.folder, *LONGER), out=out, jobs=1)
    assert (table["key"] == expected["key"]).all()
    assert table[NUMBERS].equals(expected[NUMBERS])  # one thread each: to the last bit


@pytest.mark.slow
def test_a_cluster_gives_the_numbers_of_processes(cluster, tmp_path, expected):
    sweep = start_sweep(cluster, tmp_path / "out")
    assert sweep.wait(240) == 0, (cluster.folder / "sweep.log").read_text()[-2000:]
    assert len(records(tmp_path / "out")) == RUNS
    assert_complete(cluster, tmp_path / "out", expected)


@pytest.mark.slow
def test_the_cell_of_a_killed_worker_is_computed_elsewhere(cluster, tmp_path, expected):
    out, victim = tmp_path / "out", cluster.workers[0]
    sweep = start_sweep(cluster, out)
    wait_for(lambda: any(f'"pid": {victim.pid},' in text for text in holders(out)), sweep)
    victim.kill()
    assert sweep.wait(240) == 0, (cluster.folder / "sweep.log").read_text()[-2000:]
    assert len(records(out)) == RUNS
    assert_complete(cluster, out, expected)


@pytest.mark.slow
def test_after_a_restart_of_the_scheduler_what_is_stored_is_not_repeated(
    cluster, tmp_path, expected
):
    out = tmp_path / "out"
    sweep = start_sweep(cluster, out)
    wait_for(lambda: len(records(out)) >= 1 and holders(out), sweep)
    cluster.scheduler.kill()
    cluster.scheduler.wait()
    for worker in cluster.workers:
        worker.kill()
    before = records(out)
    assert len(before) < RUNS
    cluster.start_scheduler()
    cluster.start_worker()
    assert sweep.wait(240) == 0, (cluster.folder / "sweep.log").read_text()[-2000:]
    after = records(out)
    assert len(after) == RUNS and all(after[path] == before[path] for path in before)
    assert_complete(cluster, out, expected)
