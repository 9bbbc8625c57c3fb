"""What the data leave possible: the interval of the order over all models within reach."""

from dataclasses import dataclass

import numpy as np

from esfem.judging.fits import Hypothesis
from esfem.judging.models import CLOSE, Model, models
from esfem.judging.slices import Slice
from esfem.judging.window import Window, ruled_out_below

REACH = 5.0  # of n log RSS: a hypothesis this close to the best fit is not ruled out
EXACT = 0.005  # scatter about the best fit, below which it may rule out the pure power
BEATEN = 17.0  # of n log RSS: a pure power so much worse is ruled out


@dataclass(frozen=True)
class Evidence:
    """The interval [``lower``, ``upper``] of the order as the parameter goes to 0.

    It is the union of the interval of the pure power, unless that is beaten by far, the orders of
    the ``left`` hypotheses, the intervals of free ``models`` close to the best by AICc, and that of
    the joint fit.  ``plateau`` if one explains the errors better than the pure power; ``exceeds``
    if no order below the claim is left at all (`esfem.judging.window.ruled_out_below`).
    """

    lower: float
    upper: float
    models: tuple[Model, ...]
    left: tuple[Hypothesis, ...]
    plateau: bool
    exceeds: bool


def weigh(part: Slice, window: Window, which: tuple[Hypothesis, ...], k: float) -> Evidence:
    """The evidence of the levels in the window for and against the pure power, claimed k."""
    s, e = part.s[-window.levels :], part.e[-window.levels :]
    free = models(np.log(s / s[-1]), np.log(e), window.fit)
    left = tuple(h for h, excess in zip(which, window.excess, strict=True) if excess < REACH)
    beaten = bool(left) and window.power_excess > BEATEN and window.closest < EXACT
    rivals = [m for m in free if not (beaten and m.name == "power")]
    close = [m for m in rivals if m.aicc < free[0].aicc + CLOSE and np.isfinite(m.lower)]
    ends = [(h.order, h.order) for h in left] + [(m.lower, m.upper) for m in close]
    if not beaten:
        ends.append((window.fit.lower, window.fit.upper))
    joint = part.joint_over(window.levels)
    if joint is not None:
        ends.append(joint.p_interval)
    plateaus = [e for h, e in zip(which, window.excess, strict=True) if h.kind == "plateau"]
    plateau = min(plateaus, default=np.inf) < window.power_excess - CLOSE
    exceeds = ruled_out_below(s, np.log(e), which, k)
    return Evidence(float(np.min(ends)), float(np.max(ends)), free, left, bool(plateau), exceeds)
