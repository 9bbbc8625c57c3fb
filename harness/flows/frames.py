"""Frames: the States at chosen time levels, a file each, from which all pictures are made."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from harness.bad_input import BadInput
from harness.checkpoint import arrays_of, state_of
from harness.files import whole
from solver import State


def frame_path(folder: Path, n: int) -> Path:
    """Where the frame of time level n lies in the folder of a flow."""
    return folder / "frames" / f"{n:08d}.npz"


def write_frame(folder: Path, n: int, state: State) -> None:
    """Store the State at level n, whole or not at all."""
    with whole(frame_path(folder, n)) as unfinished, open(unfinished, "wb") as stream:
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


def stored_levels(folder: Path) -> list[int]:
    """The time levels of which there is a frame, ascending."""
    return sorted(int(path.stem) for path in (folder / "frames").glob("[0-9]*.npz"))


def remove_frames(folder: Path) -> None:
    """Remove the frames of an earlier flow of that name."""
    for n in stored_levels(folder):
        frame_path(folder, n).unlink()


def frames(folder: Path, levels: Iterable[int]) -> Iterator[State]:
    """The stored States at these levels, one at a time."""
    return (read_frame(folder, n) for n in levels)
