"""The kinds of tables that the simulation had before it grew.

Every kind draws k = 1..5, 4 to 8 levels at ratios 2^(-1/2), 1/2 or unequal, and scatter of 0, 1, 2,
5 or 10 % (log-normal) unless its docstring says otherwise.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd

from esfem.campaigns.judge import shapes
from esfem.campaigns.judge.instance import Instance, Kind, draw_scatter, ladder, table_of
from esfem.campaigns.judge.shapes import Rng, Shape, log_uniform, two_powers
from esfem.judging.floors import Floor
from esfem.judging.validate import Direction


def clean(rng: Rng) -> Instance:
    """A pure power, as claimed, of five levels or more with scatter of 2 % at most."""
    k, h = float(rng.integers(1, 6)), ladder(rng, fewest=5)
    scatter = draw_scatter(rng, 3)
    return Instance(table_of(rng, h, h**k, scatter), k, k, scatter, len(h), clean=True)


def one_line(
    shape: Shape, gain: float = 0.0, truth: float = 0.0, least: int = 1
) -> Callable[[Rng], Instance]:
    """Tables of ``shape`` about k, claimed to be k + ``gain``, in truth of order k + ``truth``."""

    def draw(rng: Rng) -> Instance:
        k, h = float(rng.integers(least, 6)), ladder(rng)
        scatter = draw_scatter(rng)
        table = table_of(rng, h, shape(rng, h, k), scatter)
        return Instance(table, k + gain, k + truth, scatter, len(h))

    return draw


def rounding(gain: float, measured: bool) -> Callable[[Rng], Instance]:
    """h^k down to a floor that grows like 1/h, reached on one of the last three levels."""

    def draw(rng: Rng) -> Instance:
        k, h = float(rng.integers(1, 6)), ladder(rng, fewest=6)
        scatter = draw_scatter(rng)
        at = h[-int(rng.integers(1, 4))]
        floor = at**k * (at / h) * np.exp(0.3 * rng.normal(size=len(h)))
        e = h**k * np.exp(scatter * rng.normal(size=len(h))) + floor
        floors = (Floor("rounding", tuple(at**k * (at / h))),) if measured else ()
        table = pd.DataFrame({"h": h, "error": e})
        return Instance(table, k + gain, k, scatter, len(h), floors=floors)

    return draw


def identical(rng: Rng) -> Instance:
    """One error on all levels: the refinement did not reach the computation."""
    made = one_line(shapes.flat)(rng)
    table = made.table.assign(error=float(made.table["error"].iloc[0]))
    return replace(made, table=table, truth=0.0, scatter=0.0)


def missing(shift: float) -> Callable[[Rng], Instance]:
    """h^(k + shift), one or two levels without error."""

    def draw(rng: Rng) -> Instance:
        made = one_line(shapes.pure(shift), truth=shift, least=2)(rng)
        gone = rng.choice(made.levels, int(rng.integers(1, 3)), replace=False)
        table = made.table.copy()
        table.loc[gone, "error"] = np.nan
        return replace(made, table=table)

    return draw


def grid(
    shift: float,
    direction: Direction = "h",
    share: tuple[float, float] = (0.02, 0.6),
    sign: float = 1.0,
) -> Callable[[Rng], Instance]:
    """s^(k + shift) + sign B o^q on 5 to 7 levels s and 2 or 3 values o of the other parameter.

    The scatter is that of the meshes, the same for all time steps, in every other table.
    ``share`` is that of the second term, to the first, at the finest levels of both.  With sign -1
    the terms cancel somewhere and there is no truth that a slope could show.
    """

    def draw(rng: Rng) -> Instance:
        k, q = float(rng.integers(2, 5)), float(rng.integers(1, 4))
        levels, lines, scatter = int(rng.integers(5, 8)), int(rng.integers(2, 4)), draw_scatter(rng)
        s = rng.uniform(0.3, 1.0) * 0.5 ** (np.arange(levels) / (2.0 if direction == "h" else 1.0))
        o = 0.1 * 0.5 ** np.arange(lines)
        S, O = (a.ravel() for a in np.meshgrid(s, o))
        part = log_uniform(rng, *share)
        first, second = (S / s[-1]) ** (k + shift), part * (O / o[-1]) ** q
        noise = rng.normal(size=levels) if rng.integers(2) else rng.normal(size=(lines, levels))
        noise = np.broadcast_to(noise, (lines, levels)).ravel()
        e = np.abs(first + sign * second) * np.exp(scatter * noise)
        other = "tau" if direction == "h" else "h"
        table = pd.DataFrame({direction: S, other: O, "error": e})
        truth = k + shift if sign > 0 else float("nan")
        return Instance(table, k, truth, scatter, levels, direction=direction, other_order=q)

    return draw


def todays_kinds() -> tuple[Kind, ...]:
    """The kinds of the simulation before it grew."""
    above, hidden = (0.5, 0.95), (0.1, 0.5)
    return (
        Kind("clean", clean),
        Kind("pure, order as claimed", one_line(shapes.pure(0.0))),
        Kind("pure, 1/2 below the claim", one_line(shapes.pure(-0.5), truth=-0.5)),
        Kind("pure, 1 below", one_line(shapes.pure(-1.0), truth=-1.0)),
        Kind("pure, 1/2 above", one_line(shapes.pure(0.5), truth=0.5)),
        Kind("pure, 1 above", one_line(shapes.pure(1.0), truth=1.0)),
        Kind("pure, 2 above", one_line(shapes.pure(2.0), truth=2.0)),
        Kind("plateau", one_line(shapes.plateau(0.0))),
        Kind("plateau, 1 below", one_line(shapes.plateau(-1.0), truth=-1.0, least=2)),
        Kind("pre-asymptotic from above", one_line(shapes.from_above)),
        Kind("pre-asymptotic from below", one_line(shapes.from_below)),
        Kind("pre-asymptotic, slowly", one_line(shapes.from_below_slowly)),
        Kind("pre-asymptotic, difference", one_line(shapes.from_below_difference)),
        Kind("from above, 1 below the claim", one_line(shapes.from_above, gain=1.0)),
        Kind("from below, 1 below the claim", one_line(shapes.from_below, gain=1.0)),
        Kind("10 h^3 + 0.03 h as 2", one_line(two_powers(-1, 1, above), truth=-1.0)),
        Kind("10 h^3 + 0.03 h as 3", one_line(two_powers(-1, 1, above), gain=1.0, truth=-1.0)),
        Kind("two powers, odd gaps", one_line(shapes.odd_powers, truth=-0.75)),
        Kind("h^k + h^(k-1)", one_line(two_powers(-1, 0, above), truth=-1.0, least=2)),
        Kind("rounding, floor measured", rounding(0.0, True)),
        Kind("rounding, not measured", rounding(0.0, False)),
        Kind("rounding, 1 below, measured", rounding(1.0, True)),
        Kind("rounding, 1 below", rounding(1.0, False)),
        Kind("diverging", one_line(lambda rng, h, k: h ** -rng.uniform(0.3, 2.0), truth=-9.0)),
        Kind("diverging on the fine end", one_line(shapes.grows_late, truth=-9.0)),
        Kind("identical errors", identical),
        Kind("constant with scatter", one_line(shapes.flat, truth=-9.0)),
        Kind("no order at all", one_line(shapes.wild, truth=-9.0)),
        Kind("30-60 % scatter", one_line(shapes.noisy(0.0))),
        Kind("30-60 % scatter, 1 below", one_line(shapes.noisy(-1.0), truth=-1.0)),
        Kind("zigzag", one_line(shapes.zigzag(0.0))),
        Kind("zigzag, 1 below", one_line(shapes.zigzag(-1.0), truth=-1.0)),
        Kind("one outlier", one_line(shapes.outlier(0.0))),
        Kind("one outlier, 1 below", one_line(shapes.outlier(-1.0), truth=-1.0)),
        Kind("missing cells", missing(0.0)),
        Kind("missing cells, 1 below", missing(-1.0)),
        Kind("h and tau, in h", grid(0.0)),
        Kind("h and tau, in h, 1/2 below", grid(-0.5)),
        Kind("h and tau, in h, 1 below", grid(-1.0)),
        Kind("h and tau, in tau", grid(0.0, "tau")),
        Kind("h and tau, in tau, 1 below", grid(-1.0, "tau")),
        Kind("tau rules, 1 below in h", grid(-1.0, share=(10.0, 1000.0))),
        Kind("h^k - tau^q", grid(0.0, share=(0.3, 5.0), sign=-1.0)),
        Kind("h^(k-1) - tau^q", grid(-1.0, share=(0.3, 5.0), sign=-1.0)),
        Kind("hidden, as k + 1", one_line(two_powers(-1, 1, hidden), 1.0, -1.0), limit=True),
        Kind("hidden, as k", one_line(two_powers(-1, 1, hidden), truth=-1.0), limit=True),
        Kind("close", one_line(two_powers(-0.5, 0.5, (0.5, 0.8)), truth=-0.5), limit=True),
    )
