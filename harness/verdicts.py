"""Verdicts: does the observed order meet the claim?  Pure functions of study, records and claims.

The order is a least-squares slope over the finest `LEVELS` meshes at one time step, with its
standard error.  The claim is an upper bound on the error, so a higher order meets it.

The solutions judged here stand still, and BDF is exact on constants: at any fixed tau the error
falls with h alone, and the time step only changes by how much the defects in space are amplified.
A moving solution has an error in time beside that in space, which these slopes cannot tell apart.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from harness.claims import Claim, claims
from harness.eoc import Fit, fit_order
from harness.errors import VARIABLES
from harness.study import Study

LEVELS = 4
TOLERANCE = 0.2
# Errors below this on all meshes are rounding and solver tolerance (1e-10 relative): no order.
ROUNDING = 1e-9
NORM = "L-infinity(0,T; H^1(Gamma))"

Outcome = Literal["pass", "fail", "inconclusive", "not exercised", "no claim"]
# From best to worst for a study as a whole: what was not exercised or claimed does not decide.
SEVERITY: tuple[Outcome, ...] = ("no claim", "not exercised", "pass", "inconclusive", "fail")


@dataclass(frozen=True)
class Verdict:
    """One variable of one study, judged.

    ``expected`` is NaN without a claim, ``observed`` and ``uncertainty`` (its standard error) where
    there was nothing to fit; ``tau`` and ``vertices`` say which runs were judged.
    """

    study: str
    claim: str
    source: str
    variable: str
    norm: str
    expected: float
    observed: float
    uncertainty: float
    verdict: Outcome
    reason: str
    tau: float
    vertices: tuple[int, ...]


def judge(study: Study, records: pd.DataFrame) -> list[Verdict]:
    """The verdict on each variable, from one row a run (`harness.tables.record_row`)."""
    tau, levels = judged_levels(records)
    return [_judge_variable(study, name, tau, levels) for name in VARIABLES]


def worst(verdicts: list[Verdict]) -> Outcome:
    """The verdict on all together."""
    return max((v.verdict for v in verdicts), key=SEVERITY.index)


def judged_levels(records: pd.DataFrame) -> tuple[float, pd.DataFrame]:
    """The finest tau at which `LEVELS` meshes, the finest of the sweep among them, ran to the end.

    Returns that tau and the rows of its finest `LEVELS` completed meshes; NaN and no rows if there
    is no such tau.
    """
    finest_mesh = records["vertices"].max()
    for tau in sorted(records["tau"].unique()):
        of_tau = records[(records["tau"] == tau) & (records["status"] == "ok")]
        finished = of_tau.sort_values("h", ascending=False)
        if len(finished) >= LEVELS and finished["vertices"].iloc[-1] == finest_mesh:
            return float(tau), finished.tail(LEVELS)
    return float("nan"), records.iloc[:0]


def exclusions(records: pd.DataFrame) -> list[str]:
    """What was not judged, by name: time steps finer than the judged one, and runs that stopped."""
    tau, _ = judged_levels(records)
    lines = []
    for t in sorted(records["tau"].unique(), reverse=True):
        stopped = records[(records["tau"] == t) & (records["status"] != "ok")]
        runs = [
            f"V = {r.vertices} ({r.status} at t = {r.stopped_at:g})" for r in stopped.itertuples()
        ]
        if runs:
            lines.append(f"stopped early, tau = {t:g}: {', '.join(runs)}")
        if not t >= tau:
            lines.append(f"not judged, tau = {t:g}: too few meshes ran to the end")
    return lines


def _judge_variable(study: Study, variable: str, tau: float, levels: pd.DataFrame) -> Verdict:
    claim = claims().get(study.study.claim or "")
    claim = claim if claim is not None and variable in claim.variables else None
    expected = float("nan") if claim is None else claim.expected_order(study.scheme.degree)
    fit, outcome, reason = _observe(study, claim, expected, levels["h"], levels[f"err_{variable}"])
    return Verdict(
        study=study.name,
        claim="" if claim is None else claim.name,
        source="" if claim is None else claim.source,
        variable=variable,
        norm=NORM,
        expected=expected,
        observed=fit.order,
        uncertainty=fit.uncertainty,
        verdict=outcome,
        reason=reason,
        tau=tau,
        vertices=tuple(int(v) for v in levels["vertices"]),
    )


def _observe(
    study: Study, claim: Claim | None, expected: float, h: pd.Series, error: pd.Series
) -> tuple[Fit, Outcome, str]:
    nothing = Fit(float("nan"), float("nan"), float("nan"), len(error))
    undecided: Outcome = "no claim" if claim is None else "inconclusive"
    if len(error) == 0:
        return nothing, undecided, f"at no tau did {LEVELS} meshes, the finest too, run to the end"
    if error.max() < ROUNDING:
        return nothing, "not exercised", f"exact up to rounding: all errors below {ROUNDING:g}"
    fit = fit_order(h, error)
    if not study.solution.exact().stationary:
        return (
            fit,
            undecided,
            "the solution moves: its error in time is not separated from that in h",
        )
    if claim is None:
        return fit, "no claim", "observed, without a claim"
    return fit, *compare(fit, expected)


def compare(fit: Fit, expected: float) -> tuple[Outcome, str]:
    """Pass, fail or inconclusive for an observed order against the one expected, and why."""
    least = expected - TOLERANCE
    if fit.order - fit.uncertainty >= least:
        relation = "exceeds" if fit.order > expected + TOLERANCE else "meets"
        return "pass", f"{relation} order {expected:g} over the {fit.levels} finest meshes"
    if fit.order + fit.uncertainty < least:
        return "fail", f"below {expected:g} - {TOLERANCE:g} on the {fit.levels} finest meshes"
    if np.isnan(fit.uncertainty):
        return "inconclusive", "two levels tell no uncertainty"
    return "inconclusive", f"{expected:g} - {TOLERANCE:g} lies within the uncertainty"
