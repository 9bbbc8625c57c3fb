"""What a table shows: the posterior of the order, rates, levels off the line, maybe rounding."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from esfem.judging.decision import RULES
from esfem.judging.families import shapes
from esfem.judging.floors import Masked
from esfem.judging.judgement import Alternative, Judgement
from esfem.judging.plane import JointFit, plane_posterior
from esfem.judging.posterior import Posterior, line_posterior
from esfem.judging.scatter import patterns
from esfem.judging.slices import Slice
from esfem.judging.table_columns import Array

SHOWN = 0.02  # the least probability of an alternative that is listed
OFF = "off the line that the other levels make: an outlier, or pre-asymptotic"
ROUNDED = "where the errors stop falling, at what may be rounding or a solver's tolerance"
NEAR_ROUNDING = (
    "the errors stop falling near {:.1e}, maybe by rounding: the levels above are judged"
)


@dataclass(frozen=True)
class Evidence:
    """The posterior of the order, and what the table shows beside it.

    ``rates`` are the mean ones from level to level on a line, NaN on a grid; ``off`` the levels off
    the line of the others; ``scatter`` that of log E.
    """

    found: Posterior
    rates: Array
    off: NDArray[np.bool_]
    scatter: float
    joint: JointFit | None


def evidence_of(part: Slice, claim: float, other_order: float | None, plateaus: bool) -> Evidence:
    """That of a grid, or of a line.

    Parameters
    ----------
    claim, other_order : the claimed order, and that which is expected in the other parameter.
    plateaus : whether errors may stop falling, by a part in the other parameter.
    """
    x, y = np.log(part.s / part.s[-1]), np.log(part.e)
    if part.grid is not None and part.grid.enough:
        found, joint = plane_posterior(part.grid, claim, other_order)
        none = np.full(len(x) - 1, np.nan)
        return Evidence(found, none, np.zeros(len(x), dtype=bool), joint.scatter, joint)
    noise = patterns(part.e, x)
    models = shapes(x, claim, float(x[0]) / (len(x) - 1), plateaus=plateaus)
    found, rates = line_posterior(y, x, claim, models, noise)
    off = found.weight @ noise.off[found.pattern] > 0.5
    scatter = float(np.exp(found.weight @ np.log(noise.size[found.pattern])))
    return Evidence(found, rates, off, scatter, None)


def told_of(
    blank: Judgement, part: Slice, evidence: Evidence, excused: float, probability: float
) -> Judgement:
    """The judgement with what the posterior says, before its verdict."""
    found = evidence.found
    reasons = np.where(evidence.off, OFF, np.where(_rounded(found, part.e, excused), ROUNDED, ""))
    lower, order, upper = found.quantile(0.025, 0.5, 0.975)
    kept = np.asarray(reasons == "")
    level = np.log(part.e[kept]) - order * np.log(part.s[kept])
    alternatives = tuple(
        Alternative(name, share, found.mean_in(name))
        for name, share in found.families().items()
        if share >= SHOWN
    )
    clear = part.line.at(part.line.clear)
    out = [
        Masked(
            float(clear.h[i]),
            float(clear.tau[i]),
            str(reasons[i]),
            "rounding" if reasons[i] == ROUNDED else "",
        )
        for i in np.flatnonzero(~kept)
    ]
    rounded = part.e[reasons == ROUNDED]
    notes = (NEAR_ROUNDING.format(rounded[-1]),) if len(rounded) else ()
    return replace(
        blank,
        order=order,
        lower=lower,
        upper=upper,
        probability=probability,
        constant=float(np.exp(np.clip(level.mean(), -700.0, 700.0))),
        model=alternatives[0].name,
        alternatives=alternatives,
        window=tuple(float(s) for s in part.s[kept]),
        masked=(*blank.masked, *out),
        notes=(*blank.notes, *notes),
        scatter=evidence.scatter,
        joint=evidence.joint,
    )


def _rounded(found: Posterior, e: Array, excused: float) -> NDArray[np.bool_]:
    """The finest levels if half of their error is a floor that may be rounding."""
    rules = (found.floor > RULES) & (found.floor <= excused)
    weight = found.weight * rules
    if weight.sum() <= RULES:
        return np.zeros(len(e), dtype=bool)
    floor = float(weight @ found.floor / weight.sum()) * e[-1]
    near = e < 2.0 * floor
    return np.asarray(np.minimum.accumulate(near[::-1])[::-1])
