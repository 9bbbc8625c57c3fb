"""What is stored of a flow, written and read: frames, how it ended, and what was checked of it.

A frame is the State at a chosen time level, a file each, of which pictures and files for ParaView
are made; outcome.json tells that a computation has ended, checks.json of the flow as a whole.
"""

import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from pydantic import TypeAdapter

from esfem.common.bad_input import BadInput
from esfem.common.files import whole, write_text
from esfem.common.provenance import environment
from esfem.flows.flow_file import FlowFile
from esfem.flows.history import History, read_history
from esfem.flows.start import Start
from esfem.judging.outcome import Outcome, worst
from esfem.runs.checkpoint import arrays_of, state_of
from esfem.solver import State
from esfem.solver.laws import Energy

HISTORY, OUTCOME, CHECKS = "history.csv", "outcome.json", "checks.json"
NO_CLAIM = (
    "none: the start is a given triangulation, nu, H, V and z at t = 0 are estimates from local "
    "polynomial fits (osculating jets), not data of a known smooth surface"
)


@dataclass(frozen=True)
class Ended:
    """How a computation ended: ``status`` is ok, diverged or failed; ``framed`` are the levels of
    which there is a frame."""

    identity: dict[str, str]
    status: str
    reason: str
    framed: tuple[int, ...]
    seconds: float


@dataclass(frozen=True)
class Check:
    """``verdict`` is pass or fail, ``measured`` the number that must be at most ``bound``."""

    name: str
    verdict: Outcome
    measured: float
    bound: float
    text: str


@dataclass(frozen=True, kw_only=True)
class CheckedFlow:
    """A flow that has ended, and what was checked of it: the content of checks.json."""

    flow: FlowFile
    nodes: int
    status: str
    reason: str
    order_claim: str = "-"
    seconds: float
    checks: list[Check]
    environment: dict[str, str]

    @property
    def outcome(self) -> Outcome:
        """The worst of its checks, one of which is whether it ran to its end."""
        return worst(self.checks)


@dataclass(frozen=True, kw_only=True)
class FlowResult(CheckedFlow):
    """All that is stored of a flow, with its numbers at each time level."""

    folder: Path
    history: History


def frame_path(folder: Path, n: int) -> Path:
    """Where the frame of time level n lies in the folder of a flow."""
    return folder / "frames" / f"{n:08d}.npz"


def write_frame(folder: Path, n: int, state: State) -> None:
    """Store the State at level n, whole or not at all."""

    with whole(frame_path(folder, n)) as unfinished, unfinished.open("wb") as stream:
        np.savez(stream, **arrays_of(state))


def read_frame(folder: Path, n: int) -> State:
    """The stored State at level n.

    Raises
    ------
    BadInput
        If the file is missing or damaged.
    """
    path = frame_path(folder, n)
    try:
        with np.load(path, allow_pickle=False) as stored:
            return state_of(stored)
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise BadInput(f"{path}: no frame that can be read; --force computes it anew") from error


def read_frames(folder: Path, levels: Iterable[int]) -> Iterator[State]:
    """The stored States at these levels, one at a time."""
    return (read_frame(folder, n) for n in levels)


def stored_levels(folder: Path) -> list[int]:
    """The time levels of which there is a frame, ascending."""
    return sorted(int(path.stem) for path in (folder / "frames").glob("[0-9]*.npz"))


def remove_frames(folder: Path) -> None:
    """Remove the frames of an earlier flow of that name, and what ParaView was given of them."""
    for pattern in ("*.pvd", "vtu/*.vtu", "frames/[0-9]*.npz"):
        for path in folder.glob(pattern):
            path.unlink()


def write_outcome(folder: Path, ended: Ended) -> None:
    """Write outcome.json, the last file of a computation."""
    write_text(folder / OUTCOME, json.dumps(asdict(ended), indent=1) + "\n")


def stored_outcome(
    folder: Path, identity: dict[str, str], energy: Energy
) -> tuple[Ended, History] | None:
    """How a computation of this identity ended, if all of it is there; the energy is that of the
    law."""
    try:
        ended = TypeAdapter(Ended).validate_json((folder / OUTCOME).read_bytes())
        history = read_history(folder / HISTORY, energy)
    except (OSError, ValueError):
        return None
    whole = all(frame_path(folder, n).is_file() for n in ended.framed)
    return (ended, history) if whole and ended.identity == identity else None


def write_checks(
    folder: Path, flow: FlowFile, start: Start, ended: Ended, checks: list[Check]
) -> None:
    """Write checks.json."""
    checked = CheckedFlow(
        flow=flow,
        nodes=start.mesh.node_count,
        status=ended.status,
        reason=ended.reason,
        order_claim=NO_CLAIM if start.estimated else "none is judged here",
        seconds=ended.seconds,
        checks=checks,
        environment=environment(),
    )
    plain = TypeAdapter(CheckedFlow).dump_python(checked, mode="json")
    write_text(folder / CHECKS, json.dumps(plain, indent=1) + "\n")


def read_flows(folder: Path) -> list[FlowResult]:
    """The flows in the folders of a folder, by name; none if it does not exist.

    Raises
    ------
    BadInput
        If the files of a flow are damaged.
    """
    return [_read_flow(path.parent) for path in sorted(folder.glob(f"*/{CHECKS}"))]


def read_checks(folder: Path) -> CheckedFlow:
    """The content of checks.json; BadInput if it is damaged."""
    try:
        return TypeAdapter(CheckedFlow).validate_json((folder / CHECKS).read_bytes())
    except (OSError, ValueError) as error:
        raise _unreadable(folder, error) from error


def _read_flow(folder: Path) -> FlowResult:
    checked = read_checks(folder)
    try:
        history = read_history(folder / HISTORY, checked.flow.law.energy)
    except (OSError, ValueError) as error:
        raise _unreadable(folder, error) from error
    if not history.rows:
        raise BadInput(f"{folder / HISTORY}: holds no time level")
    return FlowResult(**vars(checked), folder=folder, history=history)


def _unreadable(folder: Path, error: Exception) -> BadInput:
    line = " ".join(str(error).split())
    return BadInput(f"{folder}: holds no flow that can be read: {line}")
