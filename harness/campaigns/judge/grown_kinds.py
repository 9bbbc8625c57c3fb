"""The kinds of tables by which the simulation grew.

Unless a kind says otherwise k = 1..5, there are 4 to 8 levels at ratios 2^(-1/2), 1/2 or unequal,
and scatter is 0, 1, 2, 5 or 10 %, log-normal.  *1/2 below* is 0.4, 0.5 or 0.6 below the claim.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from esfem.campaigns.judge import shapes
from esfem.campaigns.judge.instance import (
    LEVELS_MIN,
    SCATTERS,
    Instance,
    Kind,
    draw_scatter,
    ladder,
)
from esfem.campaigns.judge.shapes import Rng, Shape, log_uniform, root_of_squares
from esfem.judging.table_columns import Array
from esfem.judging.validate import Direction

Noise = Callable[[Rng, Array, float], Array]  # of log E, for levels and a size
RIGHT, HALF, ONE = (0.0,), (0.4, 0.5, 0.6), (1.0,)


def white(rng: Rng, h: Array, size: float) -> Array:
    """Independent and alike."""
    return size * rng.normal(size=len(h))


def random_walk(rng: Rng, h: Array, size: float) -> Array:
    """Steps of that size from level to level."""
    return np.cumsum(size * rng.normal(size=len(h)))


def heteroscedastic(rng: Rng, h: Array, size: float) -> Array:
    """Sizes that differ by a factor of e, or that fall with h from five times as much."""
    if rng.integers(2):
        return size * np.exp(rng.normal(size=len(h))) * rng.normal(size=len(h))
    return 5.0 * size * h / h[0] * rng.normal(size=len(h))


def heavy_tails(rng: Rng, h: Array, size: float) -> Array:
    """Student's, of three degrees of freedom."""
    return size * rng.standard_t(3, size=len(h))


@dataclass(frozen=True)
class Ladder:
    """So many levels, from fewest to most, at one of the ratios; those of `ladder` if none."""

    fewest: int = 4
    most: int = 8
    ratios: tuple[float, ...] = ()

    def draw(self, rng: Rng) -> Array:
        """Levels, coarse to fine."""
        if not self.ratios:
            return ladder(rng, self.fewest)
        n = int(rng.integers(self.fewest, self.most + 1))
        coarsest, ratio = rng.uniform(0.3, 1.0), float(rng.choice(self.ratios))
        return np.array([coarsest * ratio**level for level in range(n)])


FOUR_TO_EIGHT = Ladder()


def printed(e: Array, digits: int) -> Array:
    """Rounded to so many significant digits."""
    return np.array([float(f"{value:.{digits - 1}e}") for value in e])


def lines(
    shape: Shape,
    below: tuple[float, ...],
    *,
    levels: Ladder = FOUR_TO_EIGHT,
    scatters: tuple[float, ...] = SCATTERS,
    noise: Noise = white,
    digits: tuple[int, ...] = (),
    orders: tuple[int, int] = (1, 5),
    levels_min: int = LEVELS_MIN,
) -> Callable[[Rng], Instance]:
    """Tables of one line of ``shape`` whose order is one of ``below`` under the claim.

    ``orders`` bound the claim; ``digits``: those printed, one of them; as computed if there are
    none.
    """

    def draw(rng: Rng) -> Instance:
        gap = float(rng.choice(below))
        least = max(orders[0], 2) if gap >= 1.0 else orders[0]
        k, h = float(rng.integers(least, orders[1] + 1)), levels.draw(rng)
        scatter = float(rng.choice(scatters))
        e = shape(rng, h, k - gap) * np.exp(noise(rng, h, scatter))
        e = e * log_uniform(rng, 1e-3, 1e3)
        e = printed(e, int(rng.choice(digits))) if digits else e
        table = pd.DataFrame({"h": h, "error": e})
        return Instance(table, k, k - gap, scatter, len(h), levels_min=levels_min)

    return draw


def grid_in_squares(
    shift: float,
    direction: Direction = "h",
    share: tuple[float, float] = (0.02, 0.6),
    lines: tuple[int, int] = (2, 4),
) -> Callable[[Rng], Instance]:
    """s^(k + shift) and B o^q added in squares with rho in [-1, 1] over a grid, see `grid`."""

    def draw(rng: Rng) -> Instance:
        k, q = float(rng.integers(2, 5)), float(rng.integers(1, 4))
        levels, others = int(rng.integers(5, 8)), int(rng.integers(lines[0], lines[1] + 1))
        scatter = draw_scatter(rng)
        s = rng.uniform(0.3, 1.0) * 0.5 ** (np.arange(levels) / (2.0 if direction == "h" else 1.0))
        o = 0.1 * 0.5 ** np.arange(others)
        S, O = (a.ravel() for a in np.meshgrid(s, o))
        first = (S / s[-1]) ** (k + shift)
        second = log_uniform(rng, *share) * (O / o[-1]) ** q
        noise = rng.normal(size=levels) if rng.integers(2) else rng.normal(size=(others, levels))
        noise = np.broadcast_to(noise, (others, levels)).ravel()
        e = root_of_squares(first, second, rng.uniform(-1.0, 1.0)) * np.exp(scatter * noise)
        other = "tau" if direction == "h" else "h"
        table = pd.DataFrame({direction: S, other: O, "error": e})
        return Instance(table, k, k + shift, scatter, levels, direction=direction, other_order=q)

    return draw


def diagonal(gamma: int, shift: float) -> Callable[[Rng], Instance]:
    """h^(k + shift) and tau^q with tau ~ h^gamma on 4 to 7 levels, added in squares.

    The claim is min(k, q gamma); with ``shift`` q gamma >= k, so that the part in space is what is
    missing.  What rules as h -> 0 is the larger part on the finest level; equal powers are one.
    """

    def draw(rng: Rng) -> Instance:
        k, h = float(rng.integers(2, 5)), Ladder(4, 7, (0.5, 0.5**0.5)).draw(rng)
        least = int(np.ceil(k / gamma)) if shift else 1
        q, scatter = float(rng.integers(least, least + 3)), draw_scatter(rng)
        low, high = sorted((k + shift, q * gamma))
        s, part = h / h[-1], log_uniform(rng, 0.02, 0.9)
        e = root_of_squares(s**low, part * s**high, rng.uniform(-1.0, 1.0))
        e = e * np.exp(scatter * rng.normal(size=len(h))) * log_uniform(rng, 1e-3, 1e3)
        table = pd.DataFrame({"h": h, "tau": 0.1 * s**gamma, "error": e})
        claim = min(k, q * gamma)
        return Instance(table, claim, low, scatter, len(h), other_order=q, asked=k)

    return draw


FEW = (0.25, 0.5, 0.62, 0.5**0.5, 0.8)  # ratios of few levels
PAPER = (0.0, 0.01, 0.02, 0.03)  # scatter of published tables


def published(levels: int, below: tuple[float, ...]) -> Callable[[Rng], Instance]:
    """As tables are printed: ratio 1/2, scatter of 3 % at most, a visible next term, 2-4 digits."""
    return lines(
        shapes.next_term,
        below,
        levels=Ladder(levels, levels, (0.5,)),
        scatters=PAPER,
        digits=(2, 3, 4),
        orders=(1, 4),
    )


def grown_kinds() -> tuple[Kind, ...]:
    """The kinds that joined together, in one go, before any new verdict was seen."""
    pure = shapes.pure(0.0)
    four, three = Ladder(4, 4, FEW), Ladder(3, 3, FEW)
    five = Ladder(5)
    exact = (0.0, 0.001, 0.003)
    low = ((0.3,), (0.4, 0.5, 0.6))
    grown = (
        ("fractional sum", lines(shapes.fractional_sum, RIGHT)),
        ("fractional sum, 1/2 below", lines(shapes.fractional_sum, HALF)),
        ("fractional sum, 1 below", lines(shapes.fractional_sum, ONE)),
        ("fractional saturation", lines(shapes.fractional_saturation, RIGHT)),
        ("fractional saturation, 1/2 below", lines(shapes.fractional_saturation, HALF)),
        ("fractional difference", lines(shapes.fractional_difference, RIGHT)),
        ("fractional difference, 1/2 below", lines(shapes.fractional_difference, HALF)),
        ("log-periodic", lines(shapes.log_periodic, RIGHT)),
        ("log-periodic, 1/2 below", lines(shapes.log_periodic, HALF)),
        ("log-periodic, 1 below", lines(shapes.log_periodic, ONE)),
        ("random walk", lines(pure, RIGHT, noise=random_walk)),
        ("random walk, 1/2 below", lines(pure, HALF, noise=random_walk)),
        ("random walk, 1 below", lines(pure, ONE, noise=random_walk)),
        ("heteroscedastic", lines(pure, RIGHT, noise=heteroscedastic)),
        ("heteroscedastic, 1/2 below", lines(pure, HALF, noise=heteroscedastic)),
        ("heteroscedastic, 1 below", lines(pure, ONE, noise=heteroscedastic)),
        ("h^k log h", lines(shapes.log_factor, RIGHT)),
        ("h^k log h, 1 below", lines(shapes.log_factor, ONE)),
        ("squares on a line", lines(shapes.squares, RIGHT)),
        ("squares on a line, 1/2 below", lines(shapes.squares, HALF)),
        ("squares on a line, 1 below", lines(shapes.squares, ONE)),
        ("wild coarse levels", lines(shapes.wild_coarse, RIGHT, levels=five)),
        ("wild coarse levels, 1/2 below", lines(shapes.wild_coarse, HALF, levels=five)),
        ("wild coarse levels, 1 below", lines(shapes.wild_coarse, ONE, levels=five)),
        ("4 levels, any ratio", lines(pure, RIGHT, levels=four)),
        ("4 levels, any ratio, 1/2 below", lines(pure, HALF, levels=four)),
        ("4 levels, any ratio, 1 below", lines(pure, ONE, levels=four)),
        ("4 levels, next term", lines(shapes.next_term, RIGHT, levels=four)),
        ("4 levels, next term, 1 below", lines(shapes.next_term, ONE, levels=four)),
        ("3 levels", lines(pure, RIGHT, levels=three)),
        ("3 levels, 1 below", lines(pure, ONE, levels=three)),
        ("3 levels asked for", lines(pure, RIGHT, levels=three, levels_min=3)),
        ("3 levels asked for, 1/2 below", lines(pure, HALF, levels=three, levels_min=3)),
        ("3 levels asked for, 1 below", lines(pure, ONE, levels=three, levels_min=3)),
        (
            "3 levels asked for, next term",
            lines(shapes.next_term, RIGHT, levels=three, levels_min=3),
        ),
        (
            "3 levels asked for, next term, 1 below",
            lines(shapes.next_term, ONE, levels=three, levels_min=3),
        ),
        ("printed", lines(pure, RIGHT, digits=(2, 3, 4, 5, 6))),
        ("printed, 1/2 below", lines(pure, HALF, digits=(2, 3, 4, 5, 6))),
        ("printed, 1 below", lines(pure, ONE, digits=(2, 3, 4, 5, 6))),
        (
            "printed, fractional sum, 1/2 below",
            lines(shapes.fractional_sum, HALF, digits=(2, 3, 4, 5, 6)),
        ),
        ("squares, in h", grid_in_squares(0.0)),
        ("squares, in h, 1/2 below", grid_in_squares(-0.5)),
        ("squares, in h, 1 below", grid_in_squares(-1.0)),
        ("squares, in tau", grid_in_squares(0.0, "tau")),
        ("squares, in tau, 1 below", grid_in_squares(-1.0, "tau")),
        ("squares, much of tau", grid_in_squares(0.0, share=(0.3, 3.0))),
        ("squares, much of tau, 1 below", grid_in_squares(-1.0, share=(0.3, 3.0))),
        ("squares, tau rules, 1 below", grid_in_squares(-1.0, share=(10.0, 1000.0))),
        ("diagonal, tau ~ h", diagonal(1, 0.0)),
        ("diagonal, tau ~ h, 1 below", diagonal(1, -1.0)),
        ("diagonal, tau ~ h^2", diagonal(2, 0.0)),
        ("diagonal, tau ~ h^2, 1 below", diagonal(2, -1.0)),
        (
            "L-shaped, as 1",
            lines(
                shapes.singular,
                (1.0 / 3.0,),
                levels=Ladder(5, 7, (0.5,)),
                scatters=exact,
                orders=(1, 1),
            ),
        ),
        ("three powers", lines(shapes.three_powers, RIGHT)),
        ("three powers, 1/2 below", lines(shapes.three_powers, HALF)),
        ("heavy tails", lines(pure, RIGHT, noise=heavy_tails)),
        ("heavy tails, 1/2 below", lines(pure, HALF, noise=heavy_tails)),
        ("parity", lines(shapes.parity, RIGHT)),
        ("parity, 1 below", lines(shapes.parity, ONE)),
        ("exponential start", lines(shapes.exponential_start, RIGHT)),
        ("exponential start, 1/2 below", lines(shapes.exponential_start, HALF)),
    )
    limits = (
        ("fractional sum, 0.3 below", lines(shapes.fractional_sum, low[0])),
        ("fractional saturation, 0.3 below", lines(shapes.fractional_saturation, low[0])),
        (
            "L-shaped with scatter, as 1",
            lines(
                shapes.singular,
                (1.0 / 3.0,),
                levels=Ladder(5, 7, (0.5,)),
                scatters=(0.01, 0.02, 0.05),
                orders=(1, 1),
            ),
        ),
    )
    small = (0.0, 0.01, 0.02)
    return (
        *(Kind(name, draw, group="grown", held_out=name in HELD_OUT) for name, draw in grown),
        *(Kind(name, draw, limit=True, group="grown") for name, draw in limits),
        *(
            Kind(f"published, {n} levels{words}", published(n, below), group="published")
            for n in (4, 5)
            for below, words in ((RIGHT, ""), (ONE, ", 1 too high"))
        ),
        *(
            Kind(f"published, {n} levels, 1/2 too high", published(n, HALF), group="grown")
            for n in (4, 5)
        ),
        Kind(
            "clean, 4 levels",
            lines(pure, RIGHT, levels=Ladder(4, 4, (0.5,)), scatters=small),
            group="clean of 4",
        ),
        Kind(
            "clean, 4 levels at 2^-1/2",
            lines(pure, RIGHT, levels=Ladder(4, 4, (0.5**0.5,)), scatters=small[:2]),
            group="grown",
        ),
    )


HELD_OUT = frozenset(
    {
        *("fractional difference, 1/2 below", "log-periodic, 1/2 below", "random walk, 1 below"),
        *("heteroscedastic, 1/2 below", "h^k log h, 1 below", "squares on a line, 1/2 below"),
        *("wild coarse levels, 1/2 below", "4 levels, next term, 1 below"),
        *("3 levels asked for, 1/2 below", "printed, 1/2 below", "squares, in tau, 1 below"),
        *("squares, much of tau, 1 below", "diagonal, tau ~ h^2, 1 below"),
        *("three powers", "three powers, 1/2 below", "heavy tails", "heavy tails, 1/2 below"),
        *("parity", "parity, 1 below", "exponential start", "exponential start, 1/2 below"),
    }
)
