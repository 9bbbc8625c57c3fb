"""The computation of a flow: from its start, or from its last checkpoint, to frames and history."""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

from esfem.common.provenance import environment
from esfem.flows.flow_file import FlowFile
from esfem.flows.flow_results import (
    HISTORY,
    OUTCOME,
    Ended,
    frame_path,
    remove_frames,
    write_frame,
    write_outcome,
)
from esfem.flows.history import History
from esfem.flows.start import Start
from esfem.runs.checkpoint import Keeper
from esfem.runs.loop import measured, resumed
from esfem.runs.stepping import states
from esfem.schemes import Problem
from esfem.solver import State
from esfem.solver.laws import velocity_law

# Told of each level: the level, its State, the history so far.
Watcher = Callable[[int, State, History], None]


def identity_of(flow: FlowFile, start: Start) -> dict[str, str]:
    """All that the numbers and the frames of a flow depend on, in words."""
    numbers = flow.model_dump(mode="json", include={"law", "scheme", "time", "start"})
    words = {k: v for k, v in environment().items() if k != "machine"}
    given = {key: json.dumps(value, sort_keys=True) for key, value in numbers.items()}
    frames = hashlib.sha256(repr(flow.framed).encode()).hexdigest()[:16]
    return {**words, **given, "digest": start.digest, "frames": frames}


def problem_of(flow: FlowFile, start: Start) -> Problem:
    """What the flow asks its scheme to solve."""
    law = velocity_law(flow.law.name, **flow.law.parameters)
    return Problem(start.mesh, start.state, law, None, flow.time.tau, flow.scheme)


def compute(
    flow: FlowFile,
    start: Start,
    folder: Path,
    identity: dict[str, str],
    keeper: Keeper,
    watch: Watcher,
) -> tuple[Ended, History]:
    """Run the flow to its end, or to where it stops; that is a result, too.

    Frames and ``history.csv`` are written on the way, the last State before a stop is framed, and
    ``outcome.json`` is written last.
    """
    started = perf_counter()
    history = History(flow.law.energy)
    past = resumed(history.restore, keeper)
    (folder / OUTCOME).unlink(missing_ok=True)  # it tells of another computation
    if past:
        started -= history.rows[-1][-1]
    else:
        remove_frames(folder)
    framed = [n for n in flow.framed if n < len(history.rows)]
    wanted = set(flow.framed)
    latest = len(history.rows) - 1, past[0] if past else start.state

    def keep_frame(n: int, state: State) -> None:
        write_frame(folder, n, state)
        history.write(folder / HISTORY)
        framed.append(n)

    def measure(n: int, state: State) -> None:
        nonlocal latest
        latest = n, state
        history.measure(start.mesh, state, perf_counter() - started)
        if n in wanted:
            keep_frame(n, state)
        watch(n, state, history)
        keeper.keep(n, state, history.arrays)

    flowing = states(problem_of(flow, start), flow.levels, past)
    ending = measured(flowing, measure, first=len(history.rows))
    if latest[0] not in framed and history.rows:
        keep_frame(*latest)
    history.write(folder / HISTORY)
    framed = [n for n in framed if frame_path(folder, n).is_file()]
    seconds = round(perf_counter() - started, 3)
    ended = Ended(identity, ending.status, ending.told, tuple(framed), seconds)
    write_outcome(folder, ended)
    keeper.discard()
    return ended, history
