"""The computation of a flow: from its start, or from its last checkpoint, to frames and history."""

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from time import perf_counter

from harness.checkpoint import Keeper
from harness.flows.flow_file import FlowFile
from harness.flows.history import History
from harness.flows.start import Start
from harness.flows.store import (
    HISTORY,
    OUTCOME,
    Ended,
    frame_path,
    remove_frames,
    write_frame,
    write_outcome,
)
from harness.provenance import environment
from harness.schemes.kll import scheme_of
from solver import Diverged, SolverFailure, State, evolve
from solver.laws import velocity_law

# Told of each level: the level, its State, the history so far.
Watcher = Callable[[int, State, History], None]


def identity_of(flow: FlowFile, start: Start) -> dict[str, str]:
    """All that the numbers and the frames of a flow depend on, in words."""
    numbers = flow.model_dump(mode="json", include={"law", "scheme", "time", "start"})
    words = {k: v for k, v in environment().items() if k != "machine"}
    given = {key: json.dumps(value, sort_keys=True) for key, value in numbers.items()}
    frames = hashlib.sha256(repr(flow.framed).encode()).hexdigest()[:16]
    return {**words, **given, "digest": start.digest, "frames": frames}


def states(flow: FlowFile, start: Start, past: Sequence[State]) -> Iterator[State]:
    """The States of the flow, the first one included unless it goes on after ``past``."""
    scheme = scheme_of(flow.scheme, velocity_law(flow.law.name, **flow.law.parameters))
    return evolve(start.mesh, start.state, scheme, flow.levels, past=past)


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
    history, past = History(flow.law.energy), ()
    kept = keeper.resume()
    (folder / OUTCOME).unlink(missing_ok=True)  # it tells of another computation
    if kept is None:
        remove_frames(folder)
    else:
        past = kept.past
        history.restore(kept.arrays)
        started -= history.rows[-1][-1]
    framed = [n for n in flow.framed if n < len(history.rows)]
    wanted, status, reason = set(flow.framed), "ok", ""
    n, state = len(history.rows) - 1, past[0] if past else start.state

    def keep_frame() -> None:
        write_frame(folder, n, state)
        history.write(folder / HISTORY)
        framed.append(n)

    try:
        for n, state in enumerate(states(flow, start, past), start=len(history.rows)):
            history.measure(start.mesh, state, perf_counter() - started)
            if n in wanted:
                keep_frame()
            watch(n, state, history)
            keeper.keep(n, state, history.arrays)
    except Diverged as stop:
        status, reason = "diverged", str(stop)
    except SolverFailure as stop:
        status, reason = "failed", str(stop)
    if n not in framed and history.rows:
        keep_frame()
    history.write(folder / HISTORY)
    framed = [n for n in framed if frame_path(folder, n).is_file()]
    seconds = round(perf_counter() - started, 3)
    ended = Ended(identity, status, reason, tuple(framed), seconds)
    write_outcome(folder, ended)
    keeper.discard()
    return ended, history
