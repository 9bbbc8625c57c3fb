"""The judge: from one table of errors to an outcome by interval, as a pure function."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from harness.judging.advice import Cost, described, next_run
from harness.judging.fits import Array, Hypothesis, hypotheses
from harness.judging.floors import Floor, near_floors
from harness.judging.judgement import Judgement, Outcome
from harness.judging.models import CLOSE, models
from harness.judging.slices import Slice, judged_slice
from harness.judging.validate import Direction, identical, validated
from harness.judging.window import Window, asymptotic_window

REACH = 5.0  # of n log RSS: a hypothesis this close to the best fit is not ruled out
SUSPECT = 1.5  # above the claim, from which a superconvergence must have been declared
FLAT = (-0.2, 0.3)  # an order in here may be no order: the other parameter may rule


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
        More than the order + 1.5 is expected, and no reason for suspicion.
    cost
        Seconds of a run (h, tau), for the estimate of the next one.

    Raises
    ------
    BadInput
        If the table is not one (`harness.judging.validate.validated`).
    """
    runs = validated(table, direction)
    blank = Judgement("inconclusive", order, direction)
    if direction == "tau" and stationary:
        return replace(
            blank, outcome="not exercised", cause="a stationary solution has no error in time"
        )
    if identical(runs["error"].to_numpy()):
        return replace(
            blank, outcome="fail", order=0.0, lower=0.0, upper=0.0, cause="refinement not applied"
        )
    runs = runs.join(near_floors(runs, table, floors))
    part = judged_slice(runs, direction, other_order, stationary)
    blank = replace(blank, masked=part.masked, joint=part.joint)
    other = "tau" if direction == "h" else "h"
    excused = part.joint is None and not stationary and other not in {f.name for f in floors}
    if exact(runs):
        return replace(blank, outcome="not exercised", cause="exact up to rounding")
    which = hypotheses(order, plateaus=excused)
    window = asymptotic_window(part.s, np.log(part.e), which, tolerance)
    if window is None:
        advice = next_run(runs, direction, part.obstacle, len(part.s), 0.0, tolerance)
        return replace(blank, cause=part.obstacle, next_run=described(advice, runs, cost))
    found = _weigh(part, window, which, excused)
    outcome, cause = _decide(found, window, part, order, tolerance, declared_super)
    advice = ""
    if outcome == "inconclusive":
        cause = cause.format(other=other)
        room = max(tolerance - abs(found.order - order), tolerance / 2)
        run = next_run(runs, direction, cause, window.levels, window.fit.scatter, room)
        advice = described(run, runs, cost)
    return _reported(blank, found, window, part, outcome, cause, advice)


def exact(runs: pd.DataFrame) -> bool:
    """Whether all errors are at the floor of rounding or of the solver: there is no order."""
    finite = runs[runs["error"].notna()]
    return len(finite) > 0 and bool(finite["floor"].isin(("rounding", "solver")).all())


@dataclass(frozen=True)
class _Evidence:
    """The interval of the order over all that the data leave possible, and what that is."""

    order: float
    lower: float
    upper: float
    models: tuple
    also: tuple[str, ...]
    plateau: bool
    excused: bool


def _weigh(part: Slice, window: Window, which: tuple[Hypothesis, ...], excused: bool) -> _Evidence:
    """The union of the intervals of all models within reach of the best."""
    fit = window.fit
    free = models(*_logs(part, window), fit)
    left = [h for h, excess in zip(which, window.excess, strict=True) if excess < REACH]
    close = [m for m in free if m.aicc < free[0].aicc + CLOSE and np.isfinite(m.lower)]
    ends = [(fit.lower, fit.upper), *((h.order, h.order) for h in left)]
    ends += [(m.lower, m.upper) for m in close]
    joint = part.joint_over(window.levels)
    if joint is not None:
        ends.append(joint.p_interval)
    lower, upper = np.min(ends), np.max(ends)
    plateau = any(h.kind == "plateau" for h in left)
    names = tuple(h.name for h in left)
    return _Evidence(fit.order, float(lower), float(upper), free, names, plateau, excused)


def _logs(part: Slice, window: Window) -> tuple[Array, Array]:
    s = part.s[-window.levels :]
    return np.log(s / s[-1]), np.log(part.e[-window.levels :])


def _decide(
    found: _Evidence, window: Window, part: Slice, k: float, d: float, declared: bool
) -> tuple[Outcome, str]:
    """The outcome by interval, and its cause; "{other}" stands for the other parameter."""
    if part.joint is not None and part.joint.cancels:
        return "inconclusive", "cancellation"
    flat = FLAT[0] < window.fit.upper and window.fit.lower < FLAT[1]
    if flat and found.excused and not found.lower > k - d:
        return "inconclusive", "{other} plateau"
    if not window.stable:
        return "inconclusive", "{other} plateau" if found.plateau else "pre-asymptotic"
    if k - d <= found.lower and found.upper <= k + d:
        return "pass", ""
    if found.lower > k + d:
        if found.lower > k + SUSPECT and not declared:
            return "suspect", f"more than {SUSPECT:g} above the claim, undeclared"
        return "super", ""
    if found.upper < k - d:
        if window.levels < len(part.s) and found.upper < FLAT[1]:
            return "inconclusive", "rounding"
        return "fail", f"below {k:g} - {d:g}"
    return "inconclusive", _doubt(found, window, k, d)


def _doubt(found: _Evidence, window: Window, k: float, d: float) -> str:
    """Why an interval decides nothing."""
    fit = window.fit
    if found.plateau and fit.order < k - d / 2 and fit.curvature > 0:
        return "{other} plateau"
    if fit.lower < k - d <= fit.upper or fit.lower <= k + d < fit.upper:
        return "noise"
    return "pre-asymptotic"


def _reported(blank, found, window, part, outcome, cause, advice) -> Judgement:
    return replace(
        blank,
        outcome=outcome,
        order=found.order,
        lower=found.lower,
        upper=found.upper,
        constant=float(np.exp(window.fit.intercept) / part.s[-1] ** found.order),
        model=found.models[0].name,
        models=found.models,
        also=found.also,
        window=tuple(float(s) for s in part.s[-window.levels :]),
        cause=cause,
        next_run=advice,
        scatter=window.fit.scatter,
    )
