"""Series of errors against h or tau, checked with the place of each run, and what the judge says.

What `esfem judge` reads and what the fixture `esfem_order` is given are judged here, alike.
"""

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from esfem.common.bad_input import BadInput
from esfem.judging import Floor, judge_table
from esfem.judging.judgement import Judgement
from esfem.judging.validate import Direction

Array = NDArray[np.float64]

DISTINCT = 1e-3  # relative distance below which two levels are one level given twice
GROWS = -0.15  # a slope below it says that errors fall as h grows
LEVELS_MIN = 4  # fewer are judged on request alone


@dataclass(frozen=True)
class Series:
    """Errors of runs, in their order.

    ``h`` or ``tau`` is None where there is none; a missing error is NaN; ``places`` says where each
    run was read, for messages, and ``h_name`` what its h was called.
    """

    name: str
    h: Array | None
    tau: Array | None
    error: Array
    status: tuple[str, ...]
    places: tuple[str, ...]
    h_name: str = "h"
    more: dict[str, Array] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.error)

    def at(self, chosen: NDArray[Any]) -> "Series":
        """The runs at these places."""
        return replace(
            self,
            h=None if self.h is None else self.h[chosen],
            tau=None if self.tau is None else self.tau[chosen],
            error=self.error[chosen],
            status=tuple(np.array(self.status, dtype=object)[chosen]),
            places=tuple(np.array(self.places, dtype=object)[chosen]),
            more={name: values[chosen] for name, values in self.more.items()},
        )


@dataclass(frozen=True)
class Claim:
    """What is claimed of a series, and what is known of it.

    ``order`` is that in ``direction``, which is None where the table decides; ``other_order`` that
    in the other parameter, where it is known; ``levels`` are the first to judge, where the coarsest
    is 0, and the one behind the last.
    """

    order: float
    direction: Direction | None = None
    tolerance: float = 0.2
    other_order: float | None = None
    at_least: bool = False
    steady: bool = False
    floors: tuple[Floor, ...] = ()
    levels: tuple[int, int | None] = (0, None)
    levels_min: int = LEVELS_MIN


@dataclass(frozen=True)
class Judged:
    """A series with its judgement; ``notes`` say what was assumed of it, a line each."""

    series: Series
    claim: Claim
    judgement: Judgement
    notes: tuple[str, ...] = ()


def judged(series: Series, claim: Claim) -> Judged:
    """What the judge says of a series.

    Raises
    ------
    BadInput
        Naming the run and what is allowed, if the series is none that can be judged.
    """
    _check(series)
    direction = claim.direction or _direction(series)
    if (direction == "h" and series.h is None) or (direction == "tau" and series.tau is None):
        raise BadInput(f"direction {direction}: the table has no {direction}")
    series, notes = _at_levels(series, direction, claim.levels)
    judgement = judge_table(
        as_table(series),
        claim.order,
        direction=direction,
        tolerance=claim.tolerance,
        other_order=claim.other_order,
        floors=claim.floors,
        stationary=claim.steady,
        declared_super=claim.at_least,
        levels_min=claim.levels_min,
    )
    if series.h is None:
        run = judgement.next_run.replace("h = 1, ", "")
        judgement = replace(judgement, next_run=run)
    return Judged(series, claim, judgement, (*notes, *judgement.notes))


def as_table(series: Series) -> dict[str, NDArray[Any]]:
    """The columns that `judge_table` reads; h is 1 in a table of time steps alone."""
    h = np.ones(len(series)) if series.h is None else series.h
    columns: dict[str, NDArray[Any]] = {
        "h": h,
        "error": series.error,
        "status": np.array(series.status, dtype=object),
    }
    if series.tau is not None:
        columns["tau"] = series.tau
    return columns | series.more


def _check(series: Series) -> None:
    for name, values in ((series.h_name, series.h), ("tau", series.tau)):
        if values is None:
            continue
        for i in np.flatnonzero(~(np.isfinite(values) & (values > 0))):
            shown = "is missing" if np.isnan(values[i]) else f"{values[i]:g}"
            raise BadInput(
                f"{series.places[i]}, column {name}: {shown}: must be positive and finite"
            )
    for i in np.flatnonzero(series.error < 0):
        of = f", column {series.name}" if series.name else ""
        value = f"the error {series.error[i]:g} is negative"
        raise BadInput(f"{series.places[i]}{of}: {value}; errors are norms")
    _check_levels(series)
    _check_growth(series)


def _check_levels(series: Series) -> None:
    """No two runs at one level."""
    columns = [values for values in (series.h, series.tau) if values is not None]
    order = np.lexsort(tuple(reversed(columns)))
    for i, j in pairwise(order):
        if all(abs(c[i] - c[j]) <= DISTINCT * max(c[i], c[j]) for c in columns):
            first, second = sorted((int(i), int(j)))
            what = " and ".join(
                n for n, c in (("h", series.h), ("tau", series.tau)) if c is not None
            )
            raise BadInput(
                f"{series.places[first]} and {series.places[second]}: {what} = "
                f"{columns[0][first]:g} is given twice; levels must differ by 0.1 % at least"
            )


def _check_growth(series: Series) -> None:
    """Refuses numbers of cells called h: they grow from run to run as the errors fall, or in no
    order are whole."""
    h, e = series.h, series.error
    if h is None or series.h_name.startswith(GIVEN) or len(np.unique(h)) != len(h):
        return
    seen = np.isfinite(e) & (e > 0)
    if seen.sum() < 2:
        return
    slope = np.polyfit(np.log(h[seen]), np.log(e[seen]), 1)[0]
    steps = np.diff(h)
    whole = (h == np.rint(h)).all() and not (steps < 0).all()
    if slope < GROWS and ((steps > 0).all() or whole):
        name = series.h_name
        raise BadInput(
            f"column {name}: grows from {h.min():g} to {h.max():g} while the errors fall: is it a "
            f"number of cells? Then say --cells {name} (in Python give 1 / {name}); if it is the "
            f"mesh width, and the errors do grow as it falls, --h {name} (in Python coarse first)"
        )


GIVEN = "given "  # begins the name of an h that a user chose, which is believed


def _direction(series: Series) -> Direction:
    """tau, if it alone changes."""
    if series.h is None or (
        series.tau is not None and len(np.unique(series.h)) == 1 and len(np.unique(series.tau)) > 1
    ):
        return "tau"
    return "h"


def _at_levels(
    series: Series, direction: Direction, levels: tuple[int, int | None]
) -> tuple[Series, tuple[str, ...]]:
    """The runs at these levels of the judged parameter, which are counted from the coarsest."""
    values = series.h if direction == "h" else series.tau
    assert values is not None
    ladder = np.unique(values)[::-1]
    kept = ladder[slice(*levels)]
    if len(kept) == len(ladder):
        return series, ()
    if not len(kept):
        raise BadInput(f"levels: none of {len(ladder)} is chosen")
    chosen = np.isin(values, kept)
    text = f"{len(kept)} of {len(ladder)} levels are judged as asked, {direction} = "
    return series.at(chosen), (f"{text}{kept[0]:.3g} to {kept[-1]:.3g}",)
