"""Bounds on an error, judged: the finest errors against the limit of a claim."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
from esfem.judging.eoc import Fit, fit_order
from esfem.results.selection import LEVELS, Selection
from esfem.results.verdict import Outcome, Verdict
from esfem.studies.claims import Claim
from esfem.studies.quantities import QUANTITIES

FAR_BELOW = 20.0  # times below its limit, an error need not fall any more


def judge_limit(chosen: Selection, blank: Verdict, claim: Claim) -> Verdict:
    """The verdict on one variable against the limit of its claim; ``blank`` says which."""
    runs, why = chosen.bounded, chosen.unfit
    if not why and len(runs) < LEVELS:
        why = f"at no tau did the {LEVELS} finest meshes all run to the end"
    errors = runs.get(f"err_{blank.variable}", pd.Series(dtype=float))
    if not why and errors.isna().any():
        where = ", ".join(f"V = {r.vertices}" for r in runs[errors.isna()].itertuples())
        why = f"no error at {where}: {QUANTITIES[blank.variable].lacking}"
    if why:
        return replace(blank, verdict="inconclusive", reason=why, limit=claim.limit)
    fit = fitted(runs[blank.direction], errors)
    outcome, reason = compare_limit(fit, list(errors), claim)
    half = 2.0 * fit.uncertainty
    return replace(
        blank,
        verdict=outcome,
        reason=reason,
        limit=claim.limit,
        observed=fit.order,
        lower=fit.order - half,
        upper=fit.order + half,
        constant=fit.constant,
        error=float(errors.iloc[-1]),
        tau=tuple(float(t) for t in dict.fromkeys(runs["tau"])),
        vertices=tuple(int(v) for v in runs["vertices"]),
    )


def fitted(h: Sequence[float], errors: Sequence[float]) -> Fit:
    """The order of errors, coarse before fine; NaN if one of them is zero, and has no logarithm."""
    e = np.asarray(errors)
    if (np.isfinite(e) & (e > 0)).all():
        return fit_order(h, errors)
    return Fit(np.nan, np.nan, np.nan, len(errors))


def compare_limit(fit: Fit, errors: Sequence[float], claim: Claim) -> tuple[Outcome, str]:
    """Pass, fail or inconclusive for errors, coarse before fine, against a limit, and why.

    What is not a number proves nothing. If the errors are claimed to converge, the finest one
    counts, and errors that do not fall prove nothing, unless they are far below the limit.
    Otherwise every error counts.
    """
    limit = claim.limit
    if np.isnan(errors).any():
        return "inconclusive", "an error is not a number"
    judged = errors[-1] if claim.converges else max(errors)
    which = "finest" if claim.converges else "largest"
    if not judged <= limit:
        return "fail", f"the {which} error is {judged:.3g} > {limit:g}"
    falls = fit.order - fit.uncertainty > 0
    if claim.converges and judged > limit / FAR_BELOW and not falls:
        return "inconclusive", f"the finest error is {judged:.3g} <= {limit:g}, but does not fall"
    return "pass", f"the {which} error is {judged:.3g} <= {limit:g}"
