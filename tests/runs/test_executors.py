"""Executors: the same cells on processes of this machine and on a dask cluster, which may break."""

import math
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path
from textwrap import dedent

import pytest
from shortcuts import PROCESSES, computed_by
from studies import small_study

from esfem import run_study
from esfem.common.bad_input import BadInput
from esfem.runs.executors import ONE_THREAD, LocalProcesses, WorkerLost, executor_named

ROOT = Path(__file__).resolve().parents[2]
LONGER = {"vertices": [30, 60, 120], "tau": [0.005, 0.0025], "claim": None}
README = (ROOT / "README.md").read_text(encoding="utf-8")
RUNS = 6
SHORT = {"vertices": [30, 60], "claim": None}
NUMBERS = [f"err_{name}" for name in ("x", "nu", "H", "V", "z", "v")]


pytestmark = pytest.mark.usefixtures("processes")


def square(n: int) -> int:
    return n * n


def die(n: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def process_and_threads(n: int) -> tuple[int, str | None]:
    return os.getpid(), os.environ.get("OMP_NUM_THREADS")


@pytest.mark.parametrize("jobs", [1, 2])
def test_each_item_has_its_result(jobs):
    with LocalProcesses(jobs) as executor:
        assert dict(executor.run(square, [1, 2, 3])) == {1: 1, 2: 4, 3: 9}


def test_a_process_has_one_thread_and_is_another_one():
    with LocalProcesses(1) as executor:
        ((_, (process, threads)),) = executor.run(process_and_threads, [0])
    assert threads == "1"
    assert process != os.getpid() == executor.owner


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


@pytest.mark.parametrize("package", ["cryptography", "distributed"])
def test_a_missing_package_is_one_line(monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(
        BadInput, match=rf"needs the package {package}: .*esfem-willmore\[cluster\]"
    ):
        executor_named("dask", None, 1).__enter__()


def test_a_scheduler_that_is_not_there_is_one_line(monkeypatch):
    monkeypatch.setattr("esfem.runs.executors.CONNECT_SECONDS", 0.5)
    with pytest.raises(BadInput, match="cannot be reached"):
        executor_named("dask", f"tcp://127.0.0.1:{free_port()}", 1).__enter__()


@pytest.mark.parametrize(
    ("configuration", "words"),
    [
        ({}, r"tls\.ca-file: must name a file, is not there"),
        ({"ca-file": __file__}, r"tls\.client\.cert: must name a file, is not there"),
        ({"ca-file": "/none/c.pem"}, r"tls\.ca-file = /none/c\.pem: there is no such file"),
        ({"ca-file": __file__, "client.cert": __file__}, "cannot be reached: .*certificate"),
    ],
)
def test_tls_without_certificates_is_one_line(configuration, words):
    config = pytest.importorskip("dask").config
    with config.set({f"distributed.comm.tls.{k}": v for k, v in configuration.items()}):
        with pytest.raises(
            BadInput, match=rf"^--scheduler tls://127\.0\.0\.1:1: .*{words}"
        ) as told:
            executor_named("dask", "tls://127.0.0.1:1", 1).__enter__()
    assert "\n" not in str(told.value)


def test_an_open_port_is_refused_where_encryption_is_required():
    config = pytest.importorskip("dask").config
    with config.set({"distributed.comm.require-encryption": True}):
        with pytest.raises(BadInput, match="cannot be reached: encryption required"):
            executor_named("dask", "tcp://127.0.0.1:1", 1).__enter__()


@pytest.mark.slow
def test_local_workers_listen_to_this_process_alone(caplog):
    """The port of a scheduler without TLS is open to every user of the machine."""
    distributed = pytest.importorskip("distributed")
    with executor_named("dask", None, 1) as executor:
        assert dict(executor.run(math.sqrt, [4.0, 9.0])) == {4.0: 2.0, 9.0: 3.0}
        address = executor._client.scheduler.address
        addresses = [address, *executor._client.nthreads()]
        assert all(each.startswith("tls://") for each in addresses)
        with pytest.raises(OSError, match=r"(?i)ssl|tls|closed|reset"):
            distributed.Client(address, security=distributed.Security.temporary(), timeout=5)
        with pytest.raises(OSError, match=r"(?i)closed|reset|timed out"):
            distributed.Client(address.replace("tls", "tcp"), timeout=5)
    assert not [record for record in caplog.records if record.name == "esfem"]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def process(log: Path, *words, variables: dict[str, str]):
    """A process that is killed in the end; its output goes to the log."""
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": path, **variables}
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
    """A scheduler and two workers on loopback; ``variables`` are those of their environment."""

    def __init__(self, folder: Path, stack: ExitStack, protocol: str, **variables: str) -> None:
        self.folder, self.stack, self.variables = folder, stack, variables
        self.port, self.protocol = free_port(), protocol
        self.address = f"{protocol}://127.0.0.1:{self.port}"
        self.scheduler = self.start_scheduler()
        self.workers = [self.start_worker() for _ in range(2)]

    def start_scheduler(self) -> subprocess.Popen:
        words = ("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", self.port)
        return self._start("scheduler.log", *words, "--protocol", self.protocol, "--no-dashboard")

    def start_worker(self) -> subprocess.Popen:
        words = ("distributed.cli.dask_worker", self.address, "--nthreads", 1, "--no-nanny")
        place = ("--local-directory", self.folder / "scratch")
        return self._start("workers.log", *words, *place, "--no-dashboard")

    def _start(self, log: str, *words) -> subprocess.Popen:
        started = process(self.folder / log, *words, variables=self.variables)
        return self.stack.enter_context(started)


@pytest.fixture
def cluster(tmp_path):
    pytest.importorskip("distributed")
    with ExitStack() as stack:
        yield Cluster(tmp_path, stack, "tcp")


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    folder = tmp_path_factory.mktemp("local")
    with computed_by(PROCESSES):
        return run_study(small_study(folder, **LONGER), out=folder / "out", jobs=2)


def start_sweep(cluster, out, changes=LONGER, **variables):
    study = small_study(cluster.folder, **changes)
    words = ("harness", "run", study, "--out", out, "--executor", "dask")
    log = cluster.folder / "sweep.log"
    options = ("--scheduler", cluster.address, "--checkpoint", "0.1")
    started = process(log, *words, *options, variables=cluster.variables | variables)
    return cluster.stack.enter_context(started)


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
    table = run_study(small_study(cluster.folder, **LONGER), out=out, jobs=1)
    assert (table["key"] == expected["key"]).all()
    assert table[NUMBERS].equals(expected[NUMBERS])  # one thread each: to the last bit


@pytest.mark.slow
def test_a_cluster_gives_the_numbers_of_processes(cluster, tmp_path, expected):
    sweep = start_sweep(cluster, tmp_path / "out")
    assert sweep.wait(240) == 0, (cluster.folder / "sweep.log").read_text()[-2000:]
    log = (cluster.folder / "sweep.log").read_text()
    assert log.count(f"--scheduler {cluster.address}: whoever reaches that port can run") == 1
    assert len(records(tmp_path / "out")) == RUNS
    assert_complete(cluster, tmp_path / "out", expected)


def certificate(folder: Path, name: str) -> str:
    """The path of a new certificate, made as README says; its key is in the same file."""
    command = re.search(r"openssl req .*", README)[0].split()
    if shutil.which(command[0]) is None:
        pytest.skip("without openssl there is no certificate")
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    text = (folder / "key.pem").read_text() + (folder / "cert.pem").read_text()
    (folder / f"{name}.pem").write_text(text)
    return str(folder / f"{name}.pem")


def by_file(own: str, folder: Path) -> dict[str, str]:
    """The configuration of README, with that certificate."""
    text = re.search(r"^    distributed:\n(?:     .*\n)+", README, re.MULTILINE)[0]
    text, count = re.subn(r"/home/me/tls/\w+\.pem", own, text)
    assert count == 7
    (folder / "tls.yaml").write_text(dedent(text))
    return {"DASK_CONFIG": str(folder / "tls.yaml")}


def by_variables(own: str, folder: Path) -> dict[str, str]:
    """The same in the environment, the keys in the files of the certificates."""
    names = ("CA_FILE", "SCHEDULER__CERT", "WORKER__CERT", "CLIENT__CERT")
    return {f"DASK_DISTRIBUTED__COMM__TLS__{name}": own for name in names}


@pytest.mark.slow
@pytest.mark.parametrize("told", [by_file, by_variables])
def test_a_cluster_with_certificates_computes_and_listens_to_nobody_else(tmp_path, told):
    pytest.importorskip("distributed")
    own, foreign = certificate(tmp_path, "own"), certificate(tmp_path, "foreign")
    with ExitStack() as stack:
        cluster = Cluster(tmp_path, stack, "tls", **told(own, tmp_path))
        stranger = by_variables(foreign, tmp_path)
        stranger["DASK_DISTRIBUTED__COMM__TLS__CA_FILE"] = own
        sweep = start_sweep(cluster, tmp_path / "refused", SHORT, **stranger)
        assert sweep.wait(240) == 2
        log = cluster.folder / "sweep.log"
        (line,) = log.read_text().splitlines()
        assert f"esfem: --scheduler {cluster.address}: cannot be reached: " in line
        sweep = start_sweep(cluster, tmp_path / "out", SHORT)
        assert sweep.wait(240) == 0, log.read_text()[-2000:]
        assert "whoever reaches that port" not in log.read_text()
        assert len(records(tmp_path / "out")) == 4


@pytest.mark.slow
def test_the_cell_of_a_killed_worker_is_computed_elsewhere(cluster, tmp_path, expected):
    out, victim = tmp_path / "out", cluster.workers[0]
    sweep = start_sweep(cluster, out)
    wait_for(lambda: any(f"pid={victim.pid}\n" in text for text in holders(out)), sweep)
    victim.kill()
    victim.wait()
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
