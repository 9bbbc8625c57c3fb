"""Leases: one process holds, a dead one loses."""

import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from harness import leases
from harness.leases import acquire, is_held, start_of


@pytest.fixture
def path(tmp_path):
    return tmp_path / "progress" / "key.lease"


@pytest.fixture
def ended():
    """The number and start of a process that does not run any more."""
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    started = start_of(process.pid)
    process.communicate()
    return {"pid": process.pid, "started": started}


def left_by(path, **holder):
    """A lease as another process left it."""
    with acquire(path):
        content = json.loads(path.read_text())
    path.write_text(json.dumps({**content, "token": "other", **holder}))


def test_a_lease_is_given_once_and_again_when_it_is_free(path):
    with acquire(path):
        assert is_held(path)
        assert acquire(path) is None
    assert not is_held(path)
    assert acquire(path) is not None


def test_what_is_free_leaves_no_file(path):
    with acquire(path):
        acquire(path)
        is_held(path)
    assert list(path.parent.iterdir()) == []


def test_many_that_ask_at_once_get_it_once(path):
    with ThreadPoolExecutor(16) as pool:
        got = list(pool.map(lambda _: acquire(path), range(64)))
    assert sum(lease is not None for lease in got) == 1


def test_a_killed_holder_loses_it_at_once(path, ended):
    left_by(path, **ended)
    assert not is_held(path)
    with acquire(path):
        assert is_held(path)


def test_a_number_used_again_is_another_process(path):
    left_by(path, pid=os.getpid(), started="0")
    assert not is_held(path)


def test_a_holder_elsewhere_keeps_it_while_it_touches_it(path, ended):
    left_by(path, host="elsewhere", **ended)
    assert is_held(path) and acquire(path) is None
    old = time.time() - 2 * leases.STALE
    os.utime(path, (old, old))
    assert not is_held(path)
    assert acquire(path) is not None


def test_a_holder_touches_it(path, monkeypatch):
    monkeypatch.setattr(leases, "BEAT", 0.01)
    with acquire(path):
        os.utime(path, (0, 0))
        deadline = time.monotonic() + 10
        while not is_held(path):
            assert time.monotonic() < deadline
            time.sleep(0.01)


def test_a_file_that_is_no_lease_has_no_holder(path):
    path.parent.mkdir()
    path.write_text("{")
    assert not is_held(path)
    assert acquire(path) is not None


def test_who_lost_it_leaves_that_of_the_next_alone(path):
    with acquire(path):
        left_by(path.with_name("next"))
        os.replace(path.with_name("next"), path)
    assert path.exists()


def test_a_lease_renewed_before_it_is_set_aside_is_put_back(path, ended):
    left_by(path, **ended)
    stale = leases._holder(path)
    path.unlink()
    with acquire(path):
        assert not leases._set_aside(path, stale)
        assert is_held(path)
