"""Series of errors against h or tau, checked with the place of each run, and what the judge says.

What `esfem judge` reads and what the fixture `esfem_order` is given are judged here, alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from esfem.common.bad_input import BadInput
from esfem.judging import Floor, judge_table
from esfem.judging.judgement import Judgement
from esfem.judging.validate import Direction

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

DISTINCT = 1e-3  # relative distance below which two levels are one level given twice
GROWS = -0.15  # a slope below it says that errors fall as h grows
PATH = 0.05  # how far log tau may lie from a line over log h, where tau ~ h^gamma
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
    series, claim, said = _along_path(series, replace(claim, direction=direction))
    floors, assumed = _with_rounding(series, claim.floors)
    if claim.levels_min != LEVELS_MIN:
        raise BadInput(f"levels_min = {claim.levels_min}: this judge needs {LEVELS_MIN} levels")
    judgement = judge_table(
        as_table(series),
        claim.order,
        direction=direction,
        tolerance=claim.tolerance,
        other_order=claim.other_order,
        floors=floors,
        stationary=claim.steady,
        declared_super=claim.at_least,
    )
    judgement = _zero(judgement, series, claim.floors)
    return Judged(series, claim, _of_one_parameter(judgement, series), (*notes, *said, *assumed))


def as_table(series: Series) -> "pd.DataFrame":
    """The columns that `judge_table` reads; h is 1 in a table of time steps alone."""
    import pandas as pd

    h = np.ones(len(series)) if series.h is None else series.h
    columns = {"h": h, "error": series.error, "status": np.array(series.status, dtype=object)}
    if series.tau is not None:
        columns["tau"] = series.tau
    return pd.DataFrame(columns | series.more)


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


def path_power(series: Series) -> float | None:
    """gamma, if h and tau are refined together with tau ~ h^gamma; NaN if tau is another function
    of h, None if they are not refined together."""
    h, tau = series.h, series.tau
    if h is None or tau is None or len(h) < 2:
        return None
    order = np.argsort(h)
    h, tau = h[order], tau[order]
    if not ((np.diff(h) > 0).all() and (np.diff(tau) > 0).all()):
        return None
    gamma, constant = np.polyfit(np.log(h), np.log(tau), 1)
    off = np.abs(np.log(tau) - gamma * np.log(h) - constant).max()
    return float(gamma) if off <= PATH else float("nan")


def _along_path(series: Series, claim: Claim) -> tuple[Series, Claim, tuple[str, ...]]:
    """Where h and tau are refined together: the series without the other parameter, and the claim
    min(k, q gamma) along the path; an error in h^k + tau^q falls like that."""
    gamma = path_power(series)
    if gamma is None:
        return series, claim, ()
    h_first = claim.direction == "h"
    k, q = (claim.order, claim.other_order) if h_first else (claim.other_order, claim.order)
    power = gamma if np.isfinite(gamma) else None
    path = f"tau ~ h^{power:.3g}" if power else "tau falls with h, though like no power of it"
    claimed = claim.order
    if power and k is not None and q is not None:
        claimed = min(k, q * power) if h_first else min(q, k / power)
    other = "tau" if h_first else "h"
    note = f"h and tau are refined together, {path}: judged along that path, where order "
    note += f"{claimed:.3g} in {claim.direction} is claimed"
    if claim.other_order is None:
        needs = (
            f"; that needs an order of {claimed / power:.3g} in tau" if power and h_first else ""
        )
        note += f"{needs}; --order {other}=Q says what is known of {other}"
    else:
        note += f" = min({k:g}, {q:g} x {power:.3g})" if power and h_first else ""
    alone = replace(series, tau=None) if h_first else replace(series, h=None)
    return alone, replace(claim, order=claimed, other_order=None), (note,)


def _with_rounding(
    series: Series, floors: Sequence[Floor]
) -> tuple[tuple[Floor, ...], tuple[str, ...]]:
    """The floors with one of rounding: eps times the largest error, unless it is given."""
    finite = series.error[np.isfinite(series.error)]
    largest = float(finite.max()) if len(finite) else 0.0
    if not largest or any(floor.name == "rounding" for floor in floors):
        return tuple(floors), ()
    floor = Floor("rounding", float(np.finfo(float).eps) * largest)
    note = f"a rounding floor of {floor.value:.1e} is assumed, eps times the largest error"
    return (*floors, floor), (note,)


def _zero(judgement: Judgement, series: Series, floors: Sequence[Floor]) -> Judgement:
    """Errors that are all zero prove nothing, unless a floor was measured."""
    finite = series.error[np.isfinite(series.error)]
    if floors or not len(finite) or finite.any():
        return judgement
    cause = "all errors are exactly 0: a run compared with itself, or a solution in the space"
    run = "a solution that is not in the space, or --floor rounding=VALUE if zero is right"
    return replace(judgement, outcome="inconclusive", cause=cause, next_run=run)


def _of_one_parameter(judgement: Judgement, series: Series) -> Judgement:
    """The judgement without words about a parameter that the series has not."""
    if series.tau is None and "tau plateau" in judgement.cause:
        cause = (
            "the errors stop falling: a part of them does not depend on h, such as that of "
            "quadrature, of a solver's tolerance or of rounding"
        )
        run = "with less of that part, or with its size given: --floor NAME=VALUE"
        return replace(judgement, cause=cause, next_run=run)
    if series.h is None:
        run = judgement.next_run.replace("h = 1, ", "").replace(", h = 1", "")
        return replace(judgement, next_run=run)
    return judgement
