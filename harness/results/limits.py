"""The verdict on an error that a claim bounds by a number, not by an order."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from esfem.judging.eoc import Fit, fit_order
from esfem.judging.outcome import Outcome
from esfem.results.error_verdicts import NEVER, ErrorVerdict
from esfem.results.selection import LEVELS, Selection
from esfem.studies.quantities import QUANTITIES, norm
from esfem.studies.study import Study

FAR_BELOW = 20.0  # times below its limit, an error need not fall any more


def within_limit(found: ErrorVerdict, limit: float) -> ErrorVerdict:
    """The verdict on an order, with a limit beside it that the finest judged error must hold.

    Where no run was judged there is no such error, and the verdict stays.
    """
    if not found.error > limit:  # False of NaN
        return found
    why = f"the finest judged error is {found.error:.3g} > {limit:g}"
    held = found.outcome in ("fail", "suspect")
    return replace(found, outcome="fail", reason=f"{found.reason}; {why}" if held else why)


def judge_limit(
    study: Study, chosen: Selection, variable: str, limit: float, converges: bool
) -> ErrorVerdict:
    """The verdict on the error of one variable against a limit alone; ``converges`` says whether
    its errors are claimed to."""
    told = norm(variable, study.initial)
    runs, why = chosen.bounded, chosen.unfit
    if not why and not chosen.moves:
        return ErrorVerdict("error", told, "not exercised", NEVER)
    if not why and len(runs) < LEVELS:
        why = f"at no tau did the {LEVELS} finest meshes all run to the end"
    errors = runs.get(f"err_{variable}", pd.Series(dtype=float))
    if not why and errors.isna().any():
        where = ", ".join(f"V = {r.vertices}" for r in runs[errors.isna()].itertuples())
        why = f"no error at {where}: {QUANTITIES[variable].lacking}"
    if why:
        return ErrorVerdict("error", told, "inconclusive", why)
    fit = fitted(runs[study.direction], errors)
    outcome, reason = compare_limit(fit, list(errors), limit, converges)
    half = 2.0 * fit.uncertainty
    return ErrorVerdict(
        "error",
        told,
        outcome,
        reason,
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


def compare_limit(
    fit: Fit, errors: Sequence[float], limit: float, converges: bool = True
) -> tuple[Outcome, str]:
    """Pass, fail or inconclusive for errors, coarse before fine, against a limit, and why.

    What is not a number proves nothing. If the errors are claimed to converge, the finest one
    counts, and errors that do not fall prove nothing, unless they are far below the limit.
    Otherwise every error counts.
    """
    if np.isnan(errors).any():
        return "inconclusive", "an error is not a number"
    judged = errors[-1] if converges else max(errors)
    which = "finest" if converges else "largest"
    if not judged <= limit:
        return "fail", f"the {which} error is {judged:.3g} > {limit:g}"
    falls = fit.order - fit.uncertainty > 0
    if converges and judged > limit / FAR_BELOW and not falls:
        return "inconclusive", f"the finest error is {judged:.3g} <= {limit:g}, but does not fall"
    return "pass", f"the {which} error is {judged:.3g} <= {limit:g}"
