"""Leases: of all processes that share a folder, one computes a cell, the others leave it alone.

A lease is a small file, made by a hard link, which succeeds for one process alone, also on network
file systems. Its holder touches it every few seconds. A holder that was killed has lost it: at once
if it was on this host, else after `STALE` seconds without a touch. Should two processes compute a
cell after all, they write the same record, each whole: leases save work, nothing hangs on them.
"""

import json
import os
import platform
import threading
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from time import time
from typing import Self
from uuid import uuid4

BEAT = 5.0  # seconds from touch to touch
STALE = 60.0  # a lease untouched for so long has no holder any more


@dataclass(frozen=True)
class Holder:
    """Who holds a lease: a process, known by its start, for numbers are used again."""

    host: str = field(default_factory=platform.node)
    pid: int = field(default_factory=os.getpid)
    started: str = field(default_factory=lambda: start_of(os.getpid()))
    token: str = field(default_factory=lambda: uuid4().hex)

    @property
    def is_killed(self) -> bool:
        """Whether it is known not to run any more."""
        return self.host == platform.node() and start_of(self.pid) != self.started


class Lease:
    """A lease that this process holds while its ``with`` block runs.

    A class because it owns a file and the thread that touches it.
    """

    def __init__(self, path: Path, holder: Holder) -> None:
        self._path, self._holder, self._over = path, holder, threading.Event()
        self._thread = threading.Thread(target=self._beat, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._over.set()
        self._thread.join()
        if _holder(self._path) == self._holder:
            self._path.unlink(missing_ok=True)

    def _beat(self) -> None:
        while not self._over.wait(BEAT):
            with suppress(OSError):  # the file is gone, or the disk: the run goes on
                os.utime(self._path)


def acquire(path: Path) -> Lease | None:
    """The lease of that path, or None if another process holds it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    holder = Holder()
    own = path.with_name(f".{path.name}.{holder.token}")
    try:
        own.write_text(json.dumps(asdict(holder)))
        if _link(own, path):
            return Lease(path, holder)
        stale = _holder(path)
        if _is_held(path, stale, own.stat().st_mtime) or not _set_aside(path, stale):
            return None
        return Lease(path, holder) if _link(own, path) else None
    finally:
        own.unlink(missing_ok=True)


def is_held(path: Path) -> bool:
    """Whether a process that seems to be alive holds that lease."""
    return path.exists() and _is_held(path, _holder(path), _now(path.parent))


def start_of(pid: int) -> str:
    """When the process started, in a word that it keeps; "" if it does not run."""
    try:
        words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return "" if words[0] == "Z" else words[19]
    except OSError:
        pass
    if Path("/proc/self").exists():
        return ""
    try:  # no /proc on this system: the number alone has to do
        os.kill(pid, 0)
    except ProcessLookupError:
        return ""
    except PermissionError:
        pass
    return "running"


def _now(folder: Path) -> float:
    """The time by the clock of the file system, which may not be ours."""
    probe = folder / f".now.{uuid4().hex}"
    try:
        probe.touch()
        return probe.stat().st_mtime
    except OSError:  # a full disk
        return time()
    finally:
        probe.unlink(missing_ok=True)


def _is_held(path: Path, holder: Holder | None, now: float) -> bool:
    try:
        fresh = now - path.stat().st_mtime < STALE
    except FileNotFoundError:
        return False
    return fresh and holder is not None and not holder.is_killed


def _holder(path: Path) -> Holder | None:
    try:
        return Holder(**json.loads(path.read_text()))
    except (OSError, ValueError, TypeError):
        return None


def _link(own: Path, path: Path) -> bool:
    try:
        os.link(own, path)
    except FileExistsError:
        return False
    return True


def _set_aside(path: Path, stale: Holder | None) -> bool:
    """Take away a lease without a holder; False if another process was faster."""
    aside = path.with_name(f".{path.name}.{uuid4().hex}")
    try:
        os.rename(path, aside)
    except FileNotFoundError:
        return True
    mine = _holder(aside) == stale
    if not mine:  # it had been taken over in the meantime: back with it
        _link(aside, path)
    aside.unlink(missing_ok=True)
    return mine
