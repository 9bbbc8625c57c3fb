"""The time levels of a flow: made once, and t is read from them.

All positions are whole numbers of ticks, of which ``parts`` make one tau, so that levels may lie at
unequal distances and still coincide exactly where they shall.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Generic, TypeVar

import numpy as np

Entry = TypeVar("Entry")
NEAR = 1e-9  # a time is that of a level if it is no further from it, relative


@dataclass(frozen=True)
class Stretch:
    """``steps`` equal steps of ``ticks`` ticks each.

    Raises
    ------
    ValueError
        If one of them is not a whole number, 1 at least.
    """

    steps: int
    ticks: int = 1

    def __post_init__(self) -> None:
        _whole("steps", self.steps)
        _whole("ticks", self.ticks)


@dataclass(frozen=True)
class Levels:
    """Levels 0..steps; level n is at t_0 + (ticks to it / parts) tau.

    Attributes
    ----------
    tau : the step that all others are fractions or multiples of, positive.
    stretches : of equal steps, one after the other.
    parts : so many ticks are one tau.
    t_0 : the time of level 0.

    Raises
    ------
    ValueError
        If tau is not positive and finite, parts is not 1 at least, there is no stretch, or a step
        is lost in the rounding of t.
    """

    tau: float
    stretches: tuple[Stretch, ...]
    parts: int = 1
    t_0: float = 0.0

    def __post_init__(self) -> None:
        if not (_is_number(self.tau) and np.isfinite(self.tau) and self.tau > 0):
            raise ValueError(f"tau = {self.tau!r}: must be a positive finite number")
        _whole("parts", self.parts)
        if not self.stretches:
            raise ValueError("stretches = (): must be one at least")
        for last, _ in self._ends[1:]:
            if not self.t(last - 1) < self.t(last) < np.inf:
                raise ValueError(
                    f"tau = {self.tau!r}: a step of it does not change t = {self.t(last)!r}"
                )

    @classmethod
    def equal(cls, tau: float, steps: int, t_0: float = 0.0) -> "Levels":
        """t_0 + n tau, n = 0..steps."""
        return cls(tau, (Stretch(steps),), t_0=t_0)

    @classmethod
    def started(
        cls, tau: float, steps: int, first: int, substeps: int, t_0: float = 0.0
    ) -> "Levels":
        """As `equal`, but each of the first so many steps is made of so many ``substeps``."""
        if substeps == 1:
            return cls.equal(tau, steps, t_0)
        divided = min(first, steps)
        rest = (Stretch(steps - divided, substeps),) if steps > divided else ()
        return cls(tau, (Stretch(divided * substeps), *rest), substeps, t_0)

    @cached_property
    def _ends(self) -> tuple[tuple[int, int], ...]:
        """Level and ticks where each stretch begins, and where the last one ends."""
        steps = accumulate((s.steps for s in self.stretches), initial=0)
        ticks = accumulate((s.steps * s.ticks for s in self.stretches), initial=0)
        return tuple(zip(steps, ticks, strict=True))

    @property
    def steps(self) -> int:
        """Number of all steps, and of the last level."""
        return self._ends[-1][0]

    def t(self, n: int) -> float:
        """The time of level n."""
        return self.t_0 + self._ticks(n) / self.parts * self.tau

    def step(self, n: int) -> float:
        """The size of the step to level n >= 1."""
        return self.stretches[self._stretch(n)].ticks / self.parts * self.tau

    def at(self, t: float) -> int:
        """The level at time t, to rounding.

        Raises
        ------
        ValueError
            If there is none.
        """
        ticks = (t - self.t_0) / self.tau * self.parts
        if not np.isfinite(ticks):
            raise ValueError(f"t = {t!r}: is not the time of a level")
        n = self._level(round(ticks))
        if n is None or abs(ticks - round(ticks)) > NEAR * max(1.0, abs(ticks)):
            raise ValueError(f"t = {t!r}: is not the time of a level")
        return n

    def history(self, n: int, depth: int) -> tuple[int, ...]:
        """The levels that a multistep method may use for level n >= 1, newest first.

        These are the levels at once, twice, ... its step before it, as far as all of them are
        there, and ``depth`` at most. With fewer than the method needs it has to start itself from
        the newest.
        """
        size, end = self.stretches[self._stretch(n)].ticks, self._ticks(n)
        found: list[int] = []
        for j in range(1, depth + 1):
            level = self._level(end - j * size)
            if level is None:
                break
            found.append(level)
        return tuple(found)

    def needed(self, n: int, depth: int) -> tuple[int, ...]:
        """Level n and the earlier ones that levels after it use (`history`), newest first."""
        found = {n}
        for (begin, _), (end, _) in zip(self._ends, self._ends[1:], strict=False):
            # The first ``depth`` levels of a stretch reach back furthest.
            first = max(begin, n) + 1
            for later in range(first, min(first + depth, end + 1)):
                found.update(i for i in self.history(later, depth) if i <= n)
        return tuple(sorted(found, reverse=True))

    def _stretch(self, n: int) -> int:
        """The stretch that the step to level n >= 1 belongs to."""
        if not 1 <= n <= self.steps:
            raise ValueError(f"level {n}: must be 1 to {self.steps} to end a step")
        return bisect_left(self._ends, n, key=lambda end: end[0]) - 1

    def _ticks(self, n: int) -> int:
        if n == 0:
            return 0
        i = self._stretch(n)
        level, ticks = self._ends[i]
        return ticks + (n - level) * self.stretches[i].ticks

    def _level(self, ticks: int) -> int | None:
        """The level at so many ticks, or None."""
        if not 0 <= ticks <= self._ends[-1][1]:
            return None
        i = min(bisect_right(self._ends, ticks, key=lambda end: end[1]), len(self.stretches)) - 1
        level, begin = self._ends[i]
        further, remainder = divmod(ticks - begin, self.stretches[i].ticks)
        return level + further if remainder == 0 else None


class Memory(Generic[Entry]):
    """What is known of those levels that later ones depend on, `depth` levels at most a step.

    A class because it changes from level to level.
    """

    def __init__(self, levels: Levels, depth: int) -> None:
        self._levels, self._depth = levels, depth
        self._entries: dict[int, Entry] = {}

    def add(self, n: int, entry: Entry) -> None:
        """Level n is known; forget what no later level needs."""
        self._entries[n] = entry
        self._entries = {i: self._entries[i] for i in self._levels.needed(n, self._depth)}

    def before(self, n: int) -> list[Entry]:
        """What the step to level n may use, newest first (`Levels.history`)."""
        return [self._entries[i] for i in self._levels.history(n, self._depth)]

    def items(self) -> tuple[tuple[int, Entry], ...]:
        """All levels that are remembered with what is known of them, newest first."""
        return tuple(self._entries.items())

    def restore(self, n: int, entries: Sequence[Entry]) -> None:
        """Take over what another Memory remembered after level n, newest first.

        Raises
        ------
        ValueError
            If there are too few entries.
        """
        needed = self._levels.needed(n, self._depth)
        if len(entries) < len(needed):
            raise ValueError(
                f"past: {len(entries)} States given, {len(needed)} needed after level {n}"
            )
        self._entries = dict(zip(needed, entries, strict=False))


def _whole(name: str, value: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise ValueError(f"{name} = {value!r}: must be a whole number")
    if value < 1:
        raise ValueError(f"{name} = {value!r}: must be at least 1")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool)
