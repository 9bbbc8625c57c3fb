"""The flows of the paper, several at a time, each in a process of one thread."""

import os
import sys
import threading
from collections.abc import Sequence
from functools import partial
from io import StringIO
from pathlib import Path
from time import sleep

from rich.console import Console

from esfem.common.defaults import EVERY_SECONDS
from esfem.flows.flow_file import load_flow
from esfem.flows.run_flow import run_flow
from esfem.runs.executors import LocalProcesses, WorkerLost
from esfem.runs.work import lease_of

POLL_SECONDS = 1.0  # between looks at the parent process
WIDTH = 200  # columns of a line of progress


class Prefixed(StringIO):
    """A text stream that puts a name before each line; a class because a console needs one."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._name, self._rest = name, ""

    def write(self, text: str) -> int:
        """Write whole lines alone, so that those of several processes do not mix."""
        *lines, self._rest = (self._rest + text).split("\n")
        for line in lines:
            sys.stdout.write(f"{self._name}: {line}\n")
        return len(text)

    def flush(self) -> None:
        """Write out what is whole."""
        sys.stdout.flush()


def run_flows(paths: Sequence[Path], out: Path, jobs: int, console: Console) -> None:
    """Compute the flows that are not stored, ``jobs`` at a time, and write all their files.

    Raises
    ------
    BadInput
        If a file is wrong, before anything is computed.
    WorkerLost
        If a process was killed.
    """
    flows = {path: load_flow(path) for path in paths}
    size = {path: (flow.start.vertices or 0) * flow.levels.steps for path, flow in flows.items()}
    longest = sorted(paths, key=size.__getitem__, reverse=True)
    work = partial(evolved, out=out.resolve(), owner=os.getpid(), quiet=console.quiet)
    left = {path.stem for path in paths}
    try:
        with LocalProcesses(jobs) as processes:
            for path, verdicts in processes.run(work, longest):
                left.discard(path.stem)
                told = ", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts))
                console.print(f"flow {path.stem}: {told}", soft_wrap=True)
    except WorkerLost as error:
        raise WorkerLost(f"{error}; not finished: {', '.join(sorted(left))}") from error


def evolved(path: Path, out: Path, owner: int, quiet: bool = False) -> list[str]:
    """The verdicts of one flow; if another process computes it now, that is waited for."""
    flow = load_flow(path)
    ends_with(owner)
    console = Console(file=Prefixed(flow.name), width=WIDTH, quiet=quiet, markup=False, emoji=False)
    with lease_of(out / ".leases" / flow.name):
        checks = run_flow(flow, path.parent, out, EVERY_SECONDS, False, True, console)
    return [check.verdict for check in checks]


def ends_with(owner: int) -> None:
    """End this process soon after the one that started it was killed."""
    if owner == os.getpid():
        return

    def watch() -> None:
        while os.getppid() == owner:
            sleep(POLL_SECONDS)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
