"""When the factors of an older surface are used again."""

from dataclasses import dataclass
from typing import ClassVar


@dataclass
class Reuse:
    """Whether the factors of an older surface pay: iterations decide, so that a run repeats itself.

    A factorisation costs about as much as `MORE` iterations. When older factors fail at once, they
    are left alone for `PAUSE` steps.
    """

    MORE: ClassVar[int] = 2
    PAUSE: ClassVar[int] = 10

    fresh: int = 0  # iterations with the factors of the very surface
    age: int = 0  # steps that have used the factors again
    pause: int = 0
    promising: bool = False

    def factored(self, iterations: int) -> None:
        """A step was solved with factors of its own."""
        self.fresh, self.age = iterations, 0
        self.promising, self.pause = self.pause == 0, max(self.pause - 1, 0)

    def reused(self, iterations: int) -> None:
        """A step was solved, or tried, with older ones."""
        self.age += 1
        self.promising = iterations < self.fresh + self.MORE
        if not self.promising and self.age == 1:
            self.pause = self.PAUSE
