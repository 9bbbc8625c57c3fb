"""Leases: one process holds, a dead one loses."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from filelock import SoftFileLease

from esfem.runs import work
from esfem.runs.work import held, lease_of

ASK = """
import sys, time
from pathlib import Path
from esfem.runs.work import held, lease_of
path = Path(sys.argv[1])
print("ready", flush=True)
while not path.with_name("start").exists():
    time.sleep(0.001)
with held(lease_of(path)) as ours:
    print(ours, flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def path(tmp_path):
    (tmp_path / "progress").mkdir()
    return tmp_path / "progress" / "key.lease"


def is_given(lease: SoftFileLease) -> bool:
    with held(lease) as ours:
        return ours


def is_free(path: Path) -> bool:
    return is_given(lease_of(path))


@contextmanager
def asker(path: Path):
    """A process that asks once when it is told to start, and holds what it got."""
    quiet = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    process = subprocess.Popen([sys.executable, "-c", ASK, str(path)], **quiet)
    try:
        assert process.stdout.readline() == "ready\n"
        yield process
    finally:
        process.kill()
        process.communicate()


@contextmanager
def holder(path: Path):
    """A process that holds the lease."""
    with asker(path) as process:
        path.with_name("start").touch()
        assert process.stdout.readline() == "True\n"
        path.with_name("start").unlink()
        yield process


def left_by(path: Path, old: str, new: str) -> None:
    """A lease as another process left it."""
    with held(lease_of(path)):
        text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def left_by_another_start(path: Path) -> None:
    """A lease as a process left it that had our number before us."""
    line = line_of(path, "start=")
    left_by(path, line, f"start={int(line.partition('=')[2]) - 1}")


def line_of(path: Path, name: str) -> str:
    """The line of a lease that says this of its holder."""
    with held(lease_of(path)):
        return next(line for line in path.read_text().splitlines() if line.startswith(name))


def test_a_lease_is_given_once_and_again_when_it_is_free(path):
    with held(lease_of(path)) as ours:
        assert ours
        assert not is_free(path)
    assert is_free(path)


def test_what_is_free_leaves_no_file(path):
    with held(lease_of(path)):
        is_free(path)
    assert list(path.parent.iterdir()) == []


@pytest.mark.parametrize("free", [True, False])
def test_many_threads_that_ask_at_once_get_it_once(path, free):
    """Also if all of them have to take it over."""
    if not free:
        left_by_another_start(path)
    asked = threading.Barrier(16)

    def ask(_: int) -> bool:
        lease = lease_of(path)
        asked.wait()
        with held(lease) as ours:
            asked.wait()
            return ours

    with ThreadPoolExecutor(16) as pool:
        assert sum(pool.map(ask, range(16))) == 1


def test_many_processes_that_ask_at_once_get_it_once(path):
    with ExitStack() as stack:
        asking = [stack.enter_context(asker(path)) for _ in range(3)]
        path.with_name("start").touch()
        assert sorted(each.stdout.readline() for each in asking) == 2 * ["False\n"] + ["True\n"]


@pytest.mark.parametrize("waited_for", [True, False])
def test_a_killed_holder_loses_it_at_once(path, waited_for):
    """Also one that nobody has waited for, a zombie."""
    with holder(path) as process:
        assert not is_free(path)
        process.send_signal(signal.SIGKILL)
        if waited_for:
            process.wait()
        else:
            os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        assert is_free(path)
    assert list(path.parent.iterdir()) == []


def test_a_number_used_again_is_another_process(path):
    left_by_another_start(path)
    assert is_free(path)


@pytest.mark.parametrize("clock", [0.0, 1e9])
def test_a_holder_elsewhere_keeps_it_while_it_touches_it(path, monkeypatch, clock):
    """Whatever the clock of its machine says."""
    monkeypatch.setattr(work, "STALE", 0.5)
    monkeypatch.setattr(work, "BEAT", 0.1)
    left_by(path, line_of(path, "host="), "host=elsewhere")
    lease, began = lease_of(path), time.monotonic()
    while time.monotonic() < began + 1.0:
        os.utime(path, (clock, clock))
        with held(lease) as ours:
            assert not ours
        time.sleep(0.05)
    touched = time.monotonic()
    while not is_given(lease):
        assert time.monotonic() < touched + 10
        time.sleep(0.05)
    assert time.monotonic() - touched >= 0.4


def test_a_slow_holder_keeps_it_and_a_suspended_one_does_not(path, monkeypatch):
    monkeypatch.setattr(work, "STALE", 1.0)
    monkeypatch.setattr(work, "BEAT", 0.1)
    lease, other = lease_of(path), lease_of(path)
    with held(lease) as ours:
        began = time.monotonic()
        while time.monotonic() < began + 2.0:
            assert ours and not is_given(other)
            time.sleep(0.1)
        lease._claim.heartbeat.stop.set()  # as if its process were suspended
        while not is_given(other):
            assert time.monotonic() < began + 20
            time.sleep(0.1)
        with held(other):
            taken = path.read_text()
            lease.release()
            assert path.read_text() == taken  # it leaves that of the next alone
    assert not path.exists()


@pytest.mark.parametrize("text", ["", "{"])
def test_a_file_that_is_no_lease_has_no_holder(path, text):
    path.write_text(text)
    os.utime(path, (0.0, 0.0))
    lease, began = lease_of(path), time.monotonic()
    while not is_given(lease):
        assert time.monotonic() < began + 10
        time.sleep(0.1)
    assert not path.exists()


def test_a_lease_that_is_just_being_written_is_held(path):
    path.touch()
    assert not is_free(path)
