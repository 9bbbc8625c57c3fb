"""Verdicts: does the observed order meet the claim?  Pure functions of study, records and claims.

An order in h is a least-squares slope over the finest `LEVELS` meshes at one time step, an order in
tau one over the finest time steps on the finest mesh.  The claim is an upper bound on the error, so
a higher order meets it.

On a stationary solution BDF is exact: at any fixed tau the error falls with h alone.  On a moving
one the error has two parts, and a slope counts only where the other part is small: its share is
estimated from the next coarser level of the other parameter, and runs in which it exceeds `SHARE`
are masked.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
import pandas as pd

from harness.claims import Claim, claims
from harness.eoc import Fit, fit_order, rates
from harness.quantities import is_self_convergence, norm
from harness.self_convergence import APART
from harness.study import Study

LEVELS = 4
FEWEST_STEPS = 3  # time steps that an order in tau needs
SHARE = 0.1  # of the error, above which the other parameter counts
# Errors below this on all meshes are rounding and solver tolerance (1e-10 relative): no order.
ROUNDING = 1e-9
INDEPENDENT = 0.02  # relative spread over all time steps, below which an error is all in space
NEARLY = 0.98  # meshes of V and 4 V vertices differ in h by 2, but for a few per cent
FAR_BELOW = 20.0  # times below its limit, an error need not fall any more
SCATTER = 0.5  # uncertainty of an order, above which it tells nothing

Direction = Literal["h", "tau"]
Outcome = Literal["pass", "fail", "inconclusive", "not exercised", "no claim"]
# From best to worst for a study as a whole: what was not exercised or claimed does not decide.
SEVERITY: tuple[Outcome, ...] = ("no claim", "not exercised", "pass", "inconclusive", "fail")


@dataclass(frozen=True)
class Verdict:
    """One variable of one study, judged.

    ``expected`` is NaN unless an order is claimed, ``limit`` unless a bound on the error is;
    ``observed`` and ``uncertainty`` (its standard error) are NaN where there was nothing to fit;
    ``direction`` is "h" or "tau"; ``tau`` and ``vertices`` say which runs were judged.
    """

    study: str
    claim: str
    source: str
    variable: str
    norm: str
    direction: Direction
    expected: float
    limit: float
    observed: float
    uncertainty: float
    verdict: Outcome
    reason: str
    tau: tuple[float, ...]
    vertices: tuple[int, ...]


def judge(study: Study, records: pd.DataFrame) -> list[Verdict]:
    """The verdict on each variable, from one row a run (`harness.rows.record_row`)."""
    return [_judge_variable(study, records, name) for name in study.variables]


def worst(verdicts: list[Verdict]) -> Outcome:
    """The verdict on all together."""
    return max((v.verdict for v in verdicts), key=SEVERITY.index)


def direction(study: Study) -> Direction:
    """In which parameter the study is judged: that of its claim, else that with more levels."""
    if study.study.claim is not None:
        return claims()[study.study.claim].direction
    if is_self_convergence(study.solution.initial()):
        return "h"
    return "tau" if len(study.sweep.tau) > len(study.sweep.vertices) else "h"


def judged_runs(study: Study, records: pd.DataFrame) -> pd.DataFrame:
    """The runs that are judged, coarse before fine; no rows if there are too few.

    In h the finest `LEVELS` meshes of the sweep, at the finest tau at which all of them ran to the
    end: a hole in the ladder is not bridged.  In tau all completed time steps on the finest mesh.
    """
    finished = records[records["status"] == "ok"]
    if direction(study) == "tau":
        runs = finished[finished["vertices"] == max(study.sweep.vertices)]
        return runs.sort_values("tau", ascending=False)
    finest = sorted(set(study.sweep.vertices) - set(too_fine(study, records)))[-LEVELS:]
    for tau in sorted(study.sweep.tau):
        runs = finished[(finished["tau"] == tau) & finished["vertices"].isin(finest)]
        if len(runs) == LEVELS:
            return runs.sort_values("h", ascending=False)
    return records.iloc[:0]


def too_fine(study: Study, records: pd.DataFrame) -> list[int]:
    """The meshes too near to the finest level to be judged against it, that level included."""
    if not is_self_convergence(study.solution.initial()):
        return []
    finest = records.loc[records["vertices"] == max(study.sweep.vertices), "h"].min()
    return sorted(records.loc[~(records["h"] >= APART * NEARLY * finest), "vertices"].unique())


def missing_runs(study: Study, records: pd.DataFrame) -> list[tuple[int, float]]:
    """The cells (V, tau) of the sweep that have no record."""
    there = set(zip(records["vertices"], records["tau"], strict=True))
    return [cell for cell in product(study.sweep.vertices, study.sweep.tau) if cell not in there]


def other_share(study: Study, records: pd.DataFrame, run: pd.Series, variable: str) -> float:
    """The estimated share in a run's error of the part that the judged parameter does not govern.

    With the next coarser completed level of the other parameter, of step s' against s and order p,
    that part is about |e(s') - e(s)| / ((s'/s)^p - 1).  NaN if there is no such level.
    """
    other, same, order = (
        ("tau", "vertices", study.scheme.bdf)
        if direction(study) == "h"
        else ("h", "tau", study.scheme.degree)
    )
    coarser = records[
        (records[same] == run[same]) & (records[other] > run[other]) & (records["status"] == "ok")
    ]
    e = run[f"err_{variable}"]
    if coarser.empty or e == 0:
        return float("nan")
    next_one = coarser.sort_values(other).iloc[0]
    growth = (next_one[other] / run[other]) ** order - 1.0
    return float(abs(next_one[f"err_{variable}"] - e) / growth / e)


def exclusions(study: Study, records: pd.DataFrame) -> list[str]:
    """What was not judged, by name: missing and stopped runs, time steps finer than the judged."""
    judged = judged_runs(study, records)
    finest = judged["tau"].min() if len(judged) else np.inf
    lines = [
        f"missing: V = {v}, tau = {t:g} has no record" for v, t in missing_runs(study, records)
    ]
    if is_self_convergence(study.solution.initial()):
        meshes = ", ".join(map(str, too_fine(study, records)))
        lines.append(f"not judged: V = {meshes}, the finest level or within a factor 2 of its h")
    for t in sorted(records["tau"].unique(), reverse=True):
        stopped = records[(records["tau"] == t) & ~records["status"].isin(("ok", "reference"))]
        runs = [
            f"V = {r.vertices} ({r.status} at t = {r.stopped_at:g})" for r in stopped.itertuples()
        ]
        if runs:
            lines.append(f"stopped early, tau = {t:g}: {', '.join(runs)}")
        if t < finest:
            lines.append(f"not judged, tau = {t:g}: not all of the finest meshes ran to the end")
    return lines


def _judge_variable(study: Study, records: pd.DataFrame, variable: str) -> Verdict:
    claim = claims().get(study.study.claim or "")
    claim = claim if claim is not None and variable in claim.variables else None
    expected = limit = float("nan")
    if claim is not None:
        expected = claim.expected_order(study.scheme.degree, study.scheme.bdf)
        limit = float("nan") if claim.limit is None else claim.limit
    runs, masked = _unmasked(study, records, variable)
    fit, outcome, reason = _observe(study, records, runs, variable)
    if claim is None:
        outcome = "not exercised" if outcome == "not exercised" else "no claim"
        reason = reason or "observed, without a claim"
    elif outcome == "observed":
        if claim.limit is not None:
            outcome, reason = compare_limit(fit, list(runs[f"err_{variable}"]), claim)
        else:
            last = float(rates(runs[direction(study)].tail(2), runs[f"err_{variable}"].tail(2))[0])
            outcome, reason = compare(fit, last, expected, claim.tolerance)
        if claim.sharp and fit.order - fit.uncertainty > expected + claim.tolerance:
            outcome, reason = "fail", f"above {expected:g} + {claim.tolerance:g}, which cannot be"
        reason = f"{reason} {_where(study, runs)}"
    return Verdict(
        study=study.name,
        claim="" if claim is None else claim.name,
        source="" if claim is None else claim.source,
        variable=variable,
        norm=norm(variable, study.solution.initial()),
        direction=direction(study),
        expected=expected,
        limit=limit,
        observed=fit.order,
        uncertainty=fit.uncertainty,
        verdict=outcome,
        reason=f"{reason}; {masked}" if masked else reason,
        tau=tuple(float(t) for t in dict.fromkeys(runs["tau"])),
        vertices=tuple(int(v) for v in dict.fromkeys(runs["vertices"])),
    )


def _unmasked(study: Study, records: pd.DataFrame, variable: str) -> tuple[pd.DataFrame, str]:
    """The judged runs in which the other parameter does not count, and what was masked."""
    runs = judged_runs(study, records)
    claim = claims().get(study.study.claim or "")
    bounded = claim is not None and claim.limit is not None and variable in claim.variables
    if study.solution.initial().stationary or bounded or runs.empty:
        return runs, ""
    shares = np.array([other_share(study, records, run, variable) for _, run in runs.iterrows()])
    kept = runs[shares <= SHARE]
    axis, other = ("vertices", "time") if direction(study) == "h" else ("tau", "space")
    notes = [
        f"{axis} = {value:g} ({'not measured' if np.isnan(share) else f'{100 * share:.0f} %'})"
        for value, share in zip(runs[axis], shares, strict=True)
        if not share <= SHARE
    ]
    return (
        kept,
        f"masked for the share of the error in {other}: {', '.join(notes)}" if notes else "",
    )


def _observe(
    study: Study, records: pd.DataFrame, runs: pd.DataFrame, variable: str
) -> tuple[Fit, str, str]:
    """The fit over the runs; "observed", or why there is none."""
    nothing = Fit(float("nan"), float("nan"), float("nan"), len(runs))
    missing = missing_runs(study, records)
    failed = int((records["status"] == "failed").sum())
    if missing or failed:
        return nothing, "inconclusive", f"{len(missing)} runs missing, {failed} with solver failure"
    if direction(study) == "tau" and study.solution.initial().stationary:
        return nothing, "not exercised", "a stationary solution has no error in time"
    error = runs[f"err_{variable}"]
    if len(runs) and error.max() < ROUNDING:
        return nothing, "not exercised", f"exact up to rounding: all errors below {ROUNDING:g}"
    if direction(study) == "tau" and _in_space_alone(study, records, variable):
        return nothing, "not exercised", "an error in space alone: it does not depend on tau"
    needed = LEVELS if direction(study) == "h" else FEWEST_STEPS
    if len(runs) < needed:
        what = f"the {needed} finest meshes" if direction(study) == "h" else f"{needed} time steps"
        return nothing, "inconclusive", f"at no tau can {what} all be judged"
    finest = runs.tail(LEVELS)
    return fit_order(finest[direction(study)], finest[f"err_{variable}"]), "observed", ""


def _in_space_alone(study: Study, records: pd.DataFrame, variable: str) -> bool:
    """Whether the error is the same at all time steps, and measured to be that of the mesh."""
    runs = judged_runs(study, records)
    error = runs[f"err_{variable}"]
    shares = [other_share(study, records, run, variable) for _, run in runs.iterrows()]
    constant = error.max() < (1 + INDEPENDENT) * error.min()
    return bool(constant and all(share > SHARE for share in shares))


def _where(study: Study, runs: pd.DataFrame) -> str:
    """On which runs an order was observed."""
    finest = runs.tail(LEVELS)
    V, tau = finest["vertices"].tolist(), finest["tau"].tolist()
    if direction(study) == "h":
        return f"over V = {V[0]}..{V[-1]} at tau = {tau[0]:g}"
    return f"over tau = {tau[0]:g}..{tau[-1]:g} at V = {V[0]}"


def compare(fit: Fit, last: float, expected: float, tolerance: float) -> tuple[Outcome, str]:
    """Pass, fail or inconclusive for an observed order against the one expected, and why.

    ``last`` is the rate of the finest pair: a fit that passes while its finest pair does not is a
    plateau or scatter, and is inconclusive; so is one with an uncertainty above `SCATTER`.
    """
    least = expected - tolerance
    if fit.order + fit.uncertainty < least:
        return "fail", f"below {expected:g} - {tolerance:g}"
    if not fit.uncertainty <= SCATTER:
        return "inconclusive", f"the rates scatter by more than {SCATTER:g}"
    if fit.order - fit.uncertainty < least:
        return "inconclusive", f"{expected:g} - {tolerance:g} lies within the uncertainty"
    if last < least:
        return "inconclusive", f"the finest pair has rate {last:.2f} only"
    relation = "exceeds" if fit.order > expected + tolerance else "meets"
    return "pass", f"{relation} order {expected:g}"


def compare_limit(fit: Fit, errors: Sequence[float], claim: Claim) -> tuple[Outcome, str]:
    """Pass, fail or inconclusive for errors, coarse before fine, against a limit, and why.

    If they are claimed to converge, the finest error counts, and errors that do not fall prove
    nothing, unless they are far below the limit. Otherwise every error counts.
    """
    limit = claim.limit
    judged = errors[-1] if claim.converges else max(errors)
    which = "finest" if claim.converges else "largest"
    if not judged <= limit:
        return "fail", f"the {which} error is {judged:.3g} > {limit:g}"
    falls = fit.order - fit.uncertainty > 0
    if claim.converges and judged > limit / FAR_BELOW and not falls:
        return "inconclusive", f"the finest error is {judged:.3g} <= {limit:g}, but does not fall"
    return "pass", f"the {which} error is {judged:.3g} <= {limit:g}"
