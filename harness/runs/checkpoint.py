"""Checkpoints: from its last one an evolution that was killed goes on, to the last bit the same.

After a level that `esfem.solver.resumable` allows, a flow depends on a few earlier States alone
(`esfem.solver.Memory`). A checkpoint holds these and what the caller has measured, as exact arrays,
and the identity of the evolution: another program, library or case is refused. What the solver
carries beyond the States, such as factors of an older surface, it drops after regular levels,
interrupted or not; only these are resumable, so nothing of it need be stored.

The bits are the same on the same machine with the same number of threads. Another machine may go
on too, with another rounding.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from time import monotonic
from typing import Any
from zipfile import BadZipFile

import numpy as np

from esfem.common.bad_input import BadInput
from esfem.common.defaults import EVERY_SECONDS
from esfem.common.files import remove, whole
from esfem.solver import Levels, Memory, State, remembered, resumable
from esfem.solver.reference_element import Array

FORMAT = 1
LEAST_SHARE = 20.0  # between two checkpoints lies at least so many times what writing one took
NODAL = tuple(f.name for f in fields(State) if f.name not in ("t", "work", "own_v"))
PAST, BESIDE = "past", "beside"  # the first and the second evolution in a file
OWN = "own_v"  # nodal too, of States whose v is not V nu


@dataclass(frozen=True)
class Checkpoint:
    """The States that later ones depend on, newest first, and the arrays of the caller; ``beside``
    are the States of a second evolution, if there is one."""

    past: tuple[State, ...]
    arrays: dict[str, Array]
    beside: tuple[State, ...] = ()


def refuse(line: str) -> None:
    """Raise BadInput with the line: what a command does that was told to resume."""
    raise BadInput(line)


class History:
    """The States of one evolution that later ones depend on.

    A class because it changes from level to level.

    Attributes
    ----------
    level : that was reached, -1 before the first one.
    latest : the States, newest first, at the last level after which it can go on.
    """

    def __init__(self, levels: Levels, order: int) -> None:
        self._levels, self.level = levels, -1
        self._memory: Memory[State] = Memory(levels, remembered(order))
        self.latest: tuple[State, ...] = ()

    def add(self, n: int, state: State) -> None:
        """Level n was reached."""
        self._memory.add(n, state)
        self.level = n
        if resumable(n):
            self.latest = tuple(state for _, state in self._memory.items())

    def restore(self, past: tuple[State, ...]) -> None:
        """Take over the ``latest`` of another one."""
        self.level, self.latest = self._levels.at(past[0].t), past
        self._memory.restore(self.level, past)


class Keeper:
    """Keeps the checkpoint of one evolution: `resume` first, `keep` at each level, `discard` last.

    Of two that go on side by side, `remember` takes the levels of either, and `write_if_due`
    follows when both have got to a time at which both have a level. They need not be resumable at
    the same times: the first one is kept as it is, the other one as it was when it last was
    resumable, so that it computes again what comes after that.

    A class because it remembers States and when it last wrote.

    Parameters
    ----------
    path : of the checkpoint, one file.
    identity : names and words; what all of the trajectory depends on.
    levels : of the evolution.
    order : of the BDF.
    seconds, steps : a checkpoint is written when so many seconds or steps have passed since the
        last one, whichever comes first; a shorter run writes none. None: never for that reason.
    say : is told, in one line, that a checkpoint could not be written.
    refused : is told, in one line, why the file that is there cannot be used. If it returns, the
        evolution starts from the beginning.
    beside : levels and order of the BDF of the second evolution, if there is one.
    """

    def __init__(
        self,
        path: Path,
        identity: Mapping[str, str],
        levels: Levels,
        order: int,
        seconds: float | None = EVERY_SECONDS,
        steps: int | None = None,
        say: Callable[[str], None] = lambda line: None,
        refused: Callable[[str], None] = refuse,
        beside: tuple[Levels, int] | None = None,
    ) -> None:
        self.path, self._identity = path, {"format": str(FORMAT), **identity}
        self._history = History(levels, order)
        self._beside = None if beside is None else History(*beside)
        self._seconds, self._steps = seconds, steps
        self._say, self._refused = say, refused
        self._written, self._level = monotonic(), 0
        self._pause, self._failing = 0.0, False

    def resume(self) -> Checkpoint | None:
        """What the file holds, or None if there is none or it is refused."""
        try:
            found = read_checkpoint(self.path, self._identity)
        except FileNotFoundError:
            return None
        except BadInput as error:
            self._refused(str(error))
            return None
        self._history.restore(found.past)
        if self._beside is not None:
            self._beside.restore(found.beside)
        return found

    def keep(self, n: int, state: State, arrays: Callable[[], dict[str, Array]]) -> None:
        """The evolution has reached level n; ``arrays`` gives what shall be kept beside it."""
        self.remember(n, state)
        self.write_if_due(arrays)

    def remember(self, n: int, state: State, beside: bool = False) -> None:
        """The evolution, or the one ``beside`` it, has reached level n."""
        history = self._beside if beside else self._history
        assert history is not None  # a keeper of one evolution is told of no other
        history.add(n, state)

    def write_if_due(self, arrays: Callable[[], dict[str, Array]]) -> None:
        """All up to the level reached is in what ``arrays`` gives."""
        n = self._history.level
        if resumable(n) and self._due(n):
            self._write(n, arrays())

    def discard(self) -> None:
        """The evolution is done: remove the file, and what killed writers left of theirs."""
        remove(self.path)

    def _due(self, n: int) -> bool:
        passed = monotonic() - self._written
        if self._seconds is not None and passed >= max(self._seconds, self._pause):
            return True
        return self._steps is not None and n - self._level >= self._steps

    def _write(self, n: int, arrays: dict[str, Array]) -> None:
        started = monotonic()
        try:
            beside = () if self._beside is None else self._beside.latest
            checkpoint = Checkpoint(self._history.latest, arrays, beside)
            write_checkpoint(self.path, self._identity, checkpoint)
            self._failing = False
        except OSError as error:
            if not self._failing:  # told once, not every time
                kept = "the one before is kept" if self.path.exists() else "there is none yet"
                why = error.strerror or error
                self._say(f"{self.path}: checkpoint not written ({why}); {kept}")
            self._failing = True
        self._written, self._level = monotonic(), n
        self._pause = LEAST_SHARE * (self._written - started)


def arrays_of(state: State) -> dict[str, Any]:
    """All of a State but what it cost, by name, as `state_of` reads it."""
    own = () if state.own_v is None else (OWN,)
    return {name: getattr(state, name) for name in ("t", *NODAL, *own)}


def state_of(arrays: Mapping[str, Any]) -> State:
    """The State of these arrays; KeyError if one is missing."""
    nodal = {name: arrays[name] for name in NODAL}
    return State(t=float(arrays["t"]), **nodal, own_v=arrays.get(OWN))


def write_checkpoint(path: Path, identity: Mapping[str, str], checkpoint: Checkpoint) -> None:
    """Write the whole file or leave the one before."""
    states = {
        f"{evolution}/{j}/{name}": array
        for evolution, past in ((PAST, checkpoint.past), (BESIDE, checkpoint.beside))
        for j, state in enumerate(past)
        for name, array in arrays_of(state).items()
    }
    kept = {f"kept/{name}": array for name, array in checkpoint.arrays.items()}
    words = np.array(json.dumps(dict(identity)))
    with whole(path) as unfinished, open(unfinished, "wb") as stream:
        np.savez(stream, **{"identity": words, **states, **kept})


def read_checkpoint(path: Path, identity: Mapping[str, str]) -> Checkpoint:
    """The checkpoint in a file.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    BadInput
        If it is damaged, or of an evolution with another identity.
    """
    try:
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as stored:
            differs = list(_differences(json.loads(str(stored["identity"])), identity))
            if differs:
                raise BadInput(f"{path}: not a checkpoint of this run: {'; '.join(differs)}")
            return _from_arrays({name: stored[name] for name in stored.files})
    except (FileNotFoundError, BadInput):
        raise
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror or error}") from error
    except (BadZipFile, EOFError, KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{path}: damaged checkpoint ({error})") from error


def _differences(there: Mapping[str, str], here: Mapping[str, str]) -> Iterator[str]:
    for name in dict.fromkeys((*there, *here)):
        if there.get(name) != here.get(name):
            yield f"{name} is {there.get(name, 'absent')} there, {here.get(name, 'absent')} here"


def _from_arrays(stored: dict[str, Array]) -> Checkpoint:
    past, beside = (_states_below(evolution, stored) for evolution in (PAST, BESIDE))
    return Checkpoint(past, _below("kept/", stored), beside)


def _states_below(evolution: str, stored: dict[str, Array]) -> tuple[State, ...]:
    depth = len({path.split("/")[1] for path in stored if path.startswith(f"{evolution}/")})
    return tuple(state_of(_below(f"{evolution}/{j}/", stored)) for j in range(depth))


def _below(prefix: str, stored: dict[str, Array]) -> dict[str, Array]:
    return {name[len(prefix) :]: a for name, a in stored.items() if name.startswith(prefix)}
