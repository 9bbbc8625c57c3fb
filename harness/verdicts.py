"""Verdicts: does the observed order meet the claim?  Pure functions of study, records and claims.

An order in h is a least-squares slope over the finest `LEVELS` meshes at one time step, an order in
tau one over the finest time steps on the finest mesh.  The claim is an upper bound on the error, so
a higher order meets it.

On a stationary solution BDF is exact: at any fixed tau the error falls with h alone.  On a moving
one the error has two parts, and a slope counts only where the other part is small: its share is
estimated from the next coarser level of the other parameter, and runs in which it exceeds `SHARE`
are masked.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from harness.claims import claims
from harness.eoc import Fit, fit_order
from harness.errors import VARIABLES
from harness.study import Study

LEVELS = 4
FEWEST_STEPS = 3  # time steps that an order in tau needs
SHARE = 0.1  # of the error, above which the other parameter counts
# Errors below this on all meshes are rounding and solver tolerance (1e-10 relative): no order.
ROUNDING = 1e-9
NORM = "L-infinity(0,T; H^1(Gamma))"

Direction = Literal["h", "tau"]
Outcome = Literal["pass", "fail", "inconclusive", "not exercised", "no claim"]
# From best to worst for a study as a whole: what was not exercised or claimed does not decide.
SEVERITY: tuple[Outcome, ...] = ("no claim", "not exercised", "pass", "inconclusive", "fail")


@dataclass(frozen=True)
class Verdict:
    """One variable of one study, judged.

    ``expected`` is NaN without a claim, ``observed`` and ``uncertainty`` (its standard error) where
    there was nothing to fit; ``direction`` is "h" or "tau"; ``tau`` and ``vertices`` say which runs
    were judged.
    """

    study: str
    claim: str
    source: str
    variable: str
    norm: str
    direction: Direction
    expected: float
    observed: float
    uncertainty: float
    verdict: Outcome
    reason: str
    tau: tuple[float, ...]
    vertices: tuple[int, ...]


def judge(study: Study, records: pd.DataFrame) -> list[Verdict]:
    """The verdict on each variable, from one row a run (`harness.tables.record_row`)."""
    return [_judge_variable(study, records, name) for name in VARIABLES]


def worst(verdicts: list[Verdict]) -> Outcome:
    """The verdict on all together."""
    return max((v.verdict for v in verdicts), key=SEVERITY.index)


def direction(study: Study) -> Direction:
    """In which parameter the study is judged: that of its claim, h without one."""
    return "h" if study.study.claim is None else claims()[study.study.claim].direction


def judged_runs(records: pd.DataFrame, direction: Direction) -> pd.DataFrame:
    """The runs that are judged, coarse before fine.

    For h the finest `LEVELS` completed meshes at the finest tau at which so many, the finest of the
    sweep among them, ran to the end; for tau all completed time steps on the finest mesh.  No rows
    if there are too few.
    """
    on_finest = records[records["vertices"] == records["vertices"].max()]
    if direction == "tau":
        finished = on_finest[on_finest["status"] == "ok"].sort_values("tau", ascending=False)
        return finished if len(finished) >= FEWEST_STEPS else finished.iloc[:0]
    for tau in sorted(on_finest.loc[on_finest["status"] == "ok", "tau"]):
        of_tau = records[(records["tau"] == tau) & (records["status"] == "ok")]
        if len(of_tau) >= LEVELS:
            return of_tau.sort_values("h", ascending=False).tail(LEVELS)
    return records.iloc[:0]


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
    """What was not judged, by name: finer time steps than the judged one, and runs that stopped."""
    judged = judged_runs(records, direction(study))
    finest = judged["tau"].min() if len(judged) else np.inf
    lines = []
    for t in sorted(records["tau"].unique(), reverse=True):
        stopped = records[(records["tau"] == t) & (records["status"] != "ok")]
        runs = [
            f"V = {r.vertices} ({r.status} at t = {r.stopped_at:g})" for r in stopped.itertuples()
        ]
        if runs:
            lines.append(f"stopped early, tau = {t:g}: {', '.join(runs)}")
        if t < finest:
            lines.append(f"not judged, tau = {t:g}: too few meshes ran to the end")
    return lines


def _judge_variable(study: Study, records: pd.DataFrame, variable: str) -> Verdict:
    claim = claims().get(study.study.claim or "")
    claim = claim if claim is not None and variable in claim.variables else None
    expected, tolerance = float("nan"), float("nan")
    if claim is not None:
        expected = claim.expected_order(study.scheme.degree, study.scheme.bdf)
        tolerance = claim.tolerance
    runs, masked = _unmasked(study, records, variable)
    fit, outcome, reason = _observe(study, runs, variable)
    if outcome == "observed":
        outcome, reason = (
            ("no claim", "observed, without a claim")
            if claim is None
            else compare(fit, expected, tolerance)
        )
    elif outcome == "inconclusive" and claim is None:
        outcome = "no claim"
    return Verdict(
        study=study.name,
        claim="" if claim is None else claim.name,
        source="" if claim is None else claim.source,
        variable=variable,
        norm=NORM,
        direction=direction(study),
        expected=expected,
        observed=fit.order,
        uncertainty=fit.uncertainty,
        verdict=outcome,
        reason=f"{reason}; {masked}" if masked else reason,
        tau=tuple(float(t) for t in dict.fromkeys(runs["tau"])),
        vertices=tuple(int(v) for v in dict.fromkeys(runs["vertices"])),
    )


def _unmasked(study: Study, records: pd.DataFrame, variable: str) -> tuple[pd.DataFrame, str]:
    """The judged runs in which the other parameter does not count, and what was masked."""
    runs = judged_runs(records, direction(study))
    if study.solution.exact().stationary or runs.empty:
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


def _observe(study: Study, runs: pd.DataFrame, variable: str) -> tuple[Fit, str, str]:
    """The fit over the runs; "observed", or why there is none."""
    nothing = Fit(float("nan"), float("nan"), float("nan"), len(runs))
    error = runs[f"err_{variable}"]
    if direction(study) == "tau" and study.solution.exact().stationary:
        return nothing, "not exercised", "a stationary solution has no error in time"
    if len(runs) and error.max() < ROUNDING:
        return nothing, "not exercised", f"exact up to rounding: all errors below {ROUNDING:g}"
    needed = LEVELS if direction(study) == "h" else FEWEST_STEPS
    if len(runs) < needed:
        what = f"{needed} meshes, the finest too," if direction(study) == "h" else f"{needed} steps"
        return nothing, "inconclusive", f"fewer than {what} can be judged"
    finest = runs.tail(LEVELS)
    return fit_order(finest[direction(study)], finest[f"err_{variable}"]), "observed", ""


def compare(fit: Fit, expected: float, tolerance: float) -> tuple[Outcome, str]:
    """Pass, fail or inconclusive for an observed order against the one expected, and why."""
    least = expected - tolerance
    if fit.order - fit.uncertainty >= least:
        relation = "exceeds" if fit.order > expected + tolerance else "meets"
        return "pass", f"{relation} order {expected:g} over {fit.levels} levels"
    if fit.order + fit.uncertainty < least:
        return "fail", f"below {expected:g} - {tolerance:g} over {fit.levels} levels"
    if np.isnan(fit.uncertainty):
        return "inconclusive", "two levels tell no uncertainty"
    return "inconclusive", f"{expected:g} - {tolerance:g} lies within the uncertainty"
