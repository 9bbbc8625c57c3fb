"""From probabilities of orders to an outcome, and to one word for why there is no better one."""

from dataclasses import dataclass

import numpy as np

from esfem.judging.families import NAMES
from esfem.judging.judgement import Outcome
from esfem.judging.posterior import Posterior
from esfem.judging.table_columns import Array

SUSPECT = 1.5  # above the claim, from which a superconvergence must have been declared
DOUBT_PASS = 0.035  # the probability of what must not be, up to which an order is accepted;
DOUBT_ABOVE = 0.015  # where the finest rates are above the claim,
DOUBT_FAR = 0.004  # where they are and errors scatter, or where they are some way from the order
FALLS, RISES = 0.15, 0.35  # that way, for rates above and for rates below
ROUGH = 0.04  # that scatter
DOUBT_FAIL = 0.01  # up to which it is rejected
DOUBT_SUSPECT = 0.01  # up to which it is not too good
DOUBT_TOO_GOOD = 0.004  # and up to which it is
EXCEEDS = 0.95  # the probability of more than the claim + d, from which it is said
FLAT = 0.3  # an order up to here is none
FASTEST = 2.0  # factor by which a change of the rates may grow from level to level
NOISE = 0.5  # scatter of log E, from which on no order is accepted
FAR = 0.6  # from the finest rate to an order that the table shows
RULES = 0.5  # share of a floor in the finest error, from which on the floor rules
NAMED = 0.25  # the probability from which on a cause is named
CURVED = ("next order", "difference", "saturation", "log factor", "drift")


@dataclass(frozen=True)
class Odds:
    """What decides, as probabilities.

    ``at_least`` the claim minus the tolerance, with no floor that rules (``good``) or with any;
    ``bad`` below it; ``exceeds`` the claim plus the tolerance; ``suspicious``;
    ``ruled`` by a floor; ``turned`` to growth; ``curved``: with a visible further term.
    """

    at_least: float
    good: float
    bad: float
    exceeds: float
    suspicious: float
    ruled: float
    turned: float
    curved: float


def odds(found: Posterior, k: float, d: float, excused: float) -> Odds:
    """The odds of a claim k with tolerance d.

    A floor whose share of the finest error is below ``excused`` may be rounding, and is none that
    counts.
    """
    rules = (found.floor > RULES) & (found.floor > excused)
    low = found.weight * found.cumulative(k - d)
    below, below_ruled = float(low.sum()), float(low @ rules)
    # A further term that hardly falls, or grows, is a floor as well.
    bent = found.family == NAMES.index("next order")
    floor_like = float((found.weight * bent) @ found.cumulative(min(FLAT, k - d)))
    curved = np.isin(found.family, [NAMES.index(name) for name in CURVED])
    return Odds(
        at_least=max(1.0 - below, 0.0),
        good=max(1.0 - below - (found.share(rules) - below_ruled), 0.0),
        bad=below - floor_like,
        exceeds=1.0 - found.below(k + d),
        suspicious=1.0 - found.below(k + SUSPECT),
        ruled=found.share(rules) + floor_like,
        turned=found.share(found.family == NAMES.index("turn")),
        curved=found.share(curved),
    )


@dataclass(frozen=True)
class Course:
    """What the table shows beside the odds, with which an outcome must agree.

    ``order`` is the median of the order, ``finest`` the rate of the finest levels and ``ahead``
    that of two levels more, as `continued`, NaN where floors rule; ``scatter`` that of log E, and
    ``off`` says that the finest level is off the line of the others.
    """

    order: float
    finest: float
    ahead: float
    scatter: float
    off: bool


def decide(
    seen: Odds, course: Course, k: float, d: float, declared_super: bool
) -> tuple[Outcome, str]:
    """The outcome, and the word for its cause.

    No order is accepted from which the finest rate is far, which a trend leaves in two levels more,
    or which rests on a finest level off the line; none is rejected which a trend reaches.
    """
    if seen.good >= 1.0 - _doubt(course, k):
        return _accepted(seen, course, k, d, declared_super)
    if seen.bad >= 1.0 - DOUBT_FAIL:
        return ("inconclusive", "trend") if course.ahead >= k - d else ("fail", "below")
    if seen.ruled > NAMED:
        return "inconclusive", "plateau"
    if seen.turned > NAMED:
        return "inconclusive", "diverges"
    return "inconclusive", "trend" if seen.curved > 0.5 else "noise"


def _doubt(course: Course, k: float) -> float:
    """The probability of what must not be, up to which an order is accepted: the less, the further
    the finest rates are from it. A lower power hides behind rates above the claim, if anywhere, and
    best where errors scatter."""
    fall = course.finest - course.order
    if fall > FALLS or fall < -RISES:
        return DOUBT_FAR
    if course.finest - k > FALLS:
        return DOUBT_FAR if course.scatter > ROUGH else DOUBT_ABOVE
    return DOUBT_PASS


def _accepted(
    seen: Odds, course: Course, k: float, d: float, declared_super: bool
) -> tuple[Outcome, str]:
    """What the odds accept, if the table shows it."""
    if course.off:
        return "inconclusive", "finest"
    if course.scatter > NOISE:
        return "inconclusive", "noise"
    if abs(course.finest - course.order) > FAR or course.finest < k - FAR or course.ahead < k - d:
        return "inconclusive", "trend"
    if declared_super or seen.suspicious <= DOUBT_SUSPECT:
        return ("super" if seen.exceeds >= EXCEEDS else "pass"), ""
    if seen.suspicious >= 1.0 - DOUBT_TOO_GOOD and not course.ahead < k + SUSPECT:
        return "suspect", "suspect"
    return "inconclusive", "above"


def continued(rates: Array, x: Array) -> float:
    """The rate two levels beyond the finest, if the trend of the last rates goes on.

    ``rates`` are those from level to level at x.  From step to step the change grows or falls by
    the factor by which it did last, but by no more than `FASTEST`.
    """
    if len(rates) < 2:
        return float(rates[-1])
    middle = 0.5 * (x[:-1] + x[1:])
    change = np.diff(rates) / -np.diff(middle)
    factor = 1.0
    if len(change) > 1 and change[-1] * change[-2] > 0:
        factor = float(np.clip(change[-1] / change[-2], 0.0, FASTEST))
    step = float(x[0]) / (len(x) - 1)
    return float(rates[-1] + change[-1] * step * sum(factor**i for i in (1, 2)))
