"""One synthetic table with its claim and truth, and the kind that it is of."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from esfem.campaigns.judge.shapes import Rng, log_uniform
from esfem.judging.floors import Floor
from esfem.judging.table_columns import Array
from esfem.judging.validate import Direction

SCATTERS = (0.0, 0.01, 0.02, 0.05, 0.10)
RATIOS = ("2^-1/2", "1/2", "unequal")
LEVELS_MIN = 4  # that the judge asks for by itself


@dataclass(frozen=True)
class Instance:
    """One table with its claim and truth, ``scatter`` and ``levels`` as drawn.

    ``asked`` is the order that the judge is asked for where the claim follows from it, NaN where it
    is the claim itself; ``levels_min`` the fewest levels on which a verdict is asked for.
    """

    table: pd.DataFrame
    claim: float
    truth: float
    scatter: float
    levels: int
    clean: bool = False
    direction: Direction = "h"
    floors: tuple[Floor, ...] = ()
    other_order: float | None = None
    asked: float = float("nan")
    levels_min: int = LEVELS_MIN

    @property
    def order(self) -> float:
        """What the judge is asked for."""
        return self.claim if np.isnan(self.asked) else self.asked


@dataclass(frozen=True)
class Kind:
    """A kind of tables; ``draw`` makes one.

    ``limit``: beyond what a table can tell. ``group``: "today" (the kinds before the simulation
    grew), "grown", "published" or "clean of 4". ``held_out``: nobody tunes on it.
    """

    name: str
    draw: Callable[[Rng], Instance]
    limit: bool = False
    group: str = "today"
    held_out: bool = False


def ladder(rng: Rng, fewest: int = 4) -> Array:
    """Levels, coarse to fine."""
    levels, ratio = int(rng.integers(fewest, 9)), RATIOS[rng.integers(3)]
    steps = {
        "2^-1/2": np.full(levels - 1, 0.5**0.5),
        "1/2": np.full(levels - 1, 0.5),
        "unequal": rng.uniform(0.45, 0.8, levels - 1),
    }[ratio]
    return rng.uniform(0.3, 1.0) * np.cumprod(np.append(1.0, steps))


def draw_scatter(rng: Rng, most: int = len(SCATTERS)) -> float:
    """One of the first so many scatters."""
    return float(rng.choice(SCATTERS[:most]))


def table_of(rng: Rng, h: Array, e: Array, scatter: float) -> pd.DataFrame:
    """The table of errors e, in units of their own, with scatter."""
    e = log_uniform(rng, 1e-3, 1e3) * e * np.exp(scatter * rng.normal(size=len(h)))
    return pd.DataFrame({"h": h, "error": e})
