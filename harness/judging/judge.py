"""The judge: from one table of errors to an outcome by interval, as a pure function."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from esfem.judging.advice import Cost, described, next_run
from esfem.judging.evidence import Evidence, weigh
from esfem.judging.fits import hypotheses
from esfem.judging.floors import Floor, near_floors
from esfem.judging.judgement import Judgement, Outcome
from esfem.judging.second_mesh import falls_with_h
from esfem.judging.slices import Slice, judged_slice
from esfem.judging.validate import Direction, identical, validated
from esfem.judging.window import Window, asymptotic_window

NOISE = 0.5  # scatter of log E, from which on no order is green
SUSPECT = 1.5  # above the claim, from which a superconvergence must have been declared
FLAT = (-0.2, 0.3)  # an order in here may be no order: the other parameter may rule
H_PLATEAU = "h plateau"


def judge_table(
    table: pd.DataFrame,
    order: float,
    *,
    direction: Direction = "h",
    tolerance: float = 0.2,
    other_order: float | None = None,
    floors: Sequence[Floor] = (),
    stationary: bool = False,
    declared_super: bool = False,
    cost: Cost | None = None,
) -> Judgement:
    """Whether the errors of a table fall with the claimed order.

    Errors that do not fall with tau are blamed on the mesh only if a second one shows it.

    Parameters
    ----------
    table
        Columns h and error, optionally tau, status, seconds, final_time; a row a run.
    order
        The claimed order in ``direction``; an upper bound on the error, so more meets it.
    tolerance
        How far the interval of the order may reach from the claim.
    other_order
        The order expected in the other parameter, where it is known.
    floors
        Measured floors; runs near them are masked.
    stationary
        The solution does not move: there is no error in tau.
    declared_super
        More than the order is expected: an interval from the order to above it passes, and more
        than the order + 1.5 is no reason for suspicion.
    cost
        Seconds of a run (h, tau), for the estimate of the next one.

    Raises
    ------
    BadInput
        If the table is not one (`esfem.judging.validate.validated`).
    """
    runs = validated(table, direction)
    runs = runs.join(near_floors(runs, table, floors))
    other = "tau" if direction == "h" else "h"
    # A measured part in the other parameter needs no model. Levels within ten times of it are
    # masked, so that on those that are left it makes no plateau.
    known = stationary or other in {f.name for f in floors}
    part = judged_slice(runs, direction, other_order, separate=known)
    blank = Judgement("inconclusive", order, direction, masked=part.masked, joint=part.joint)
    exercised = _exercised(blank, runs, stationary)
    if exercised is not None:
        return exercised
    if identical(runs["error"].to_numpy()):
        return _not_falling(blank, runs, other_order, cost)
    measured = known or part.joint is not None
    which = hypotheses(order, plateaus=not measured)
    window = asymptotic_window(part.s, np.log(part.e), which, tolerance)
    if window is None:
        if part.obstacle == H_PLATEAU:
            return _not_falling(blank, runs, other_order, cost)
        advice = next_run(runs, direction, part.obstacle, len(part.s), 0.0, tolerance)
        return replace(blank, cause=part.obstacle, next_run=described(advice, runs, cost))
    found = weigh(part, window, which, order)
    judgement = _with_evidence(blank, found, window, part)
    outcome, cause = decide(judgement, found, window, tolerance, measured, declared_super)
    if cause == H_PLATEAU:
        return _not_falling(judgement, runs, other_order, cost)
    judgement = replace(judgement, outcome=outcome, cause=cause)
    if outcome != "inconclusive":
        return judgement
    room = max(tolerance - abs(judgement.order - order), tolerance / 2)
    advice = next_run(runs, direction, cause, window.levels, judgement.scatter, room)
    return replace(judgement, next_run=described(advice, runs, cost))


def decide(
    judgement: Judgement,
    found: Evidence,
    window: Window,
    d: float,
    measured: bool,
    declared_super: bool,
) -> tuple[Outcome, str]:
    """The outcome by interval with tolerance ``d``, and its cause.

    ``measured`` says that the error in the other parameter is known, so that errors which do not
    fall are no work of its own.
    """
    k, lower, upper = judgement.claimed, found.lower, found.upper
    plateau = "tau plateau" if judgement.direction == "h" else H_PLATEAU
    flat = FLAT[0] < window.fit.upper and window.fit.lower < FLAT[1]
    if judgement.joint is not None and judgement.joint.cancels:
        return "inconclusive", "cancellation"
    if flat and not measured and lower <= k - d:
        return "inconclusive", plateau
    if not window.stable and not _settles(found, k):
        return "inconclusive", plateau if found.plateau else "pre-asymptotic"
    if window.fit.scatter > NOISE and lower > k - d:
        return "inconclusive", "noise"
    if k - d <= lower and (upper <= k + d or (declared_super and lower <= k + d)):
        return "pass", ""
    if lower > k + d and found.exceeds:
        if lower > k + SUSPECT and not declared_super:
            return "suspect", f"more than {SUSPECT:g} above the claim, and not declared"
        return "super", ""
    if upper < k - d:
        if upper < FLAT[1] and window.levels < judgement.levels:
            return "inconclusive", "rounding"
        return "fail", f"below {k:g} - {d:g}"
    return "inconclusive", _doubt(found, window, k, d, plateau)


def _settles(found: Evidence, k: float) -> bool:
    """Whether terms of higher order than the claimed one, and they alone, explain a trend."""
    return bool(found.left) and all(h.kind != "plateau" and h.order == k for h in found.left)


def _exercised(blank: Judgement, runs: pd.DataFrame, stationary: bool) -> Judgement | None:
    """The judgement where there is no order to judge; None if there is one."""
    if blank.direction == "tau" and stationary:
        why = "a stationary solution has no error in time"
        return replace(blank, outcome="not exercised", cause=why)
    finite = runs[runs["error"].notna()]
    if len(finite) and finite["floor"].isin(("rounding", "solver")).all():
        return replace(blank, outcome="not exercised", cause="exact up to rounding")
    return None


def _not_falling(
    found: Judgement, runs: pd.DataFrame, order_in_h: float | None, cost: Cost | None
) -> Judgement:
    """The judgement on errors that are one number, or reach a plateau in tau."""
    if np.isnan(found.order):
        found = replace(found, order=0.0, lower=0.0, upper=0.0)
    if found.direction == "h":
        return replace(found, outcome="fail", cause="refinement not applied")
    falls = falls_with_h(runs, order_in_h)
    if falls is False:
        return replace(found, outcome="fail", cause="does not fall with tau, nor with h")
    advice = described(next_run(runs, "tau", H_PLATEAU, 0, 0.0, 0.0), runs, cost)
    return replace(found, outcome="inconclusive", cause=H_PLATEAU, next_run=advice)


def _doubt(found: Evidence, window: Window, k: float, d: float, plateau: str) -> str:
    """Why an interval decides nothing."""
    fit = window.fit
    if found.plateau and fit.order < k - d / 2 and fit.curvature > 0:
        return plateau
    if fit.lower < k - d <= fit.upper or fit.lower <= k + d < fit.upper:
        return "noise"
    return "pre-asymptotic"


def _with_evidence(blank: Judgement, found: Evidence, window: Window, part: Slice) -> Judgement:
    fit = window.fit
    return replace(
        blank,
        order=fit.order,
        lower=found.lower,
        upper=found.upper,
        constant=float(np.exp(fit.intercept) / part.s[-1] ** fit.order),
        model=found.models[0].name,
        models=found.models,
        also=tuple(h.name for h in found.left),
        levels=len(part.s),
        window=tuple(float(s) for s in part.s[-window.levels :]),
        scatter=fit.scatter,
    )
