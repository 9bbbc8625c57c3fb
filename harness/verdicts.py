"""Verdicts: does the observed order meet the claim?  Pure functions of study, records and claims.

An order is judged by `harness.judging.judge_table`, from the table of one variable, with the floors
that were measured for the study (`harness.floors`); a bound on an error by `compare_limit`. Claims
are upper bounds on the error, so a higher order meets them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

import numpy as np
import pandas as pd

from harness.claims import Claim, claims
from harness.eoc import Fit, fit_order
from harness.judging import Floor, Judgement, Masked, judge_table
from harness.quantities import is_self_convergence, norm
from harness.self_convergence import APART
from harness.study import Study

LEVELS = 4  # that a bound is judged on
INDEPENDENT = 0.02  # relative spread over all time steps, below which an error is all in space
SHARE = 0.1  # of the error, from which on the part in space is all of it
NEARLY = 0.98  # meshes of V and 4 V vertices differ in h by 2, but for a few per cent
FAR_BELOW = 20.0  # times below its limit, an error need not fall any more

Direction = Literal["h", "tau"]
Outcome = Literal["pass", "super", "fail", "suspect", "inconclusive", "not exercised", "no claim"]
# From best to worst for a study as a whole: what was not exercised or claimed does not decide.
SEVERITY: tuple[Outcome, ...] = (
    *("no claim", "not exercised", "pass", "super", "inconclusive", "suspect", "fail"),
)
NAN = float("nan")


@dataclass(frozen=True)
class Verdict:
    """One variable of one study, judged.

    ``expected`` (with ``tolerance``) is NaN unless an order is claimed, ``limit`` unless a bound on
    the error is. ``observed`` is the order over the judged window, [``lower``, ``upper``] its
    interval over all models within reach, ``constant`` that of E = constant s^observed, ``scatter``
    the standard deviation of log E about it; NaN where there was nothing to fit. ``error`` is that
    of the finest judged run. ``tau`` and ``vertices`` say which runs were judged, ``masked`` which
    were not, and ``next_run`` what would settle an inconclusive case.
    """

    study: str
    claim: str
    source: str
    variable: str
    norm: str
    direction: Direction
    verdict: Outcome
    reason: str
    expected: float = NAN
    tolerance: float = NAN
    limit: float = NAN
    observed: float = NAN
    lower: float = NAN
    upper: float = NAN
    constant: float = NAN
    scatter: float = NAN
    error: float = NAN
    model: str = ""
    next_run: str = ""
    tau: tuple[float, ...] = ()
    vertices: tuple[int, ...] = ()
    masked: tuple[Masked, ...] = ()


def judge(study: Study, records: pd.DataFrame, floors: pd.DataFrame | None = None) -> list[Verdict]:
    """The verdict on each variable.

    Parameters
    ----------
    records : one row a run (`harness.tables.record_row`).
    floors : those that were measured (`harness.floors.floors_table`).
    """
    return [_judge_variable(study, records, floors, name) for name in study.variables]


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
    """The runs on which a bound is judged, coarse before fine; no rows if there are too few.

    In h the finest `LEVELS` meshes of the sweep, at the finest tau at which all of them ran to the
    end: a hole in the ladder is not bridged. In tau all completed time steps on the finest mesh.
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


def exclusions(study: Study, records: pd.DataFrame) -> list[str]:
    """What was not judged, by name: missing and stopped runs, and levels near a reference."""
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
    return lines


def _judge_variable(
    study: Study, records: pd.DataFrame, floors: pd.DataFrame | None, variable: str
) -> Verdict:
    claim = claims().get(study.study.claim or "")
    claim = claim if claim is not None and variable in claim.variables else None
    blank = Verdict(
        study=study.name,
        claim="" if claim is None else claim.name,
        source="" if claim is None else claim.source,
        variable=variable,
        norm=norm(variable, study.solution.initial()),
        direction=direction(study),
        verdict="no claim",
        reason="",
    )
    if claim is not None and claim.limit is not None:
        return _judge_limit(study, records, blank, claim)
    return _judge_order(study, records, floors, blank, claim)


def _judge_limit(study: Study, records: pd.DataFrame, blank: Verdict, claim: Claim) -> Verdict:
    runs = judged_runs(study, records)
    unfit = _unfit(study, records)
    if not unfit and len(runs) < LEVELS:
        unfit = f"at no tau did the {LEVELS} finest meshes all run to the end"
    if unfit:
        return replace(blank, verdict="inconclusive", reason=unfit, limit=claim.limit)
    errors = runs[f"err_{blank.variable}"]
    fit = fit_order(runs[blank.direction], errors)
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


def _judge_order(
    study: Study,
    records: pd.DataFrame,
    floors: pd.DataFrame | None,
    blank: Verdict,
    claim: Claim | None,
) -> Verdict:
    degree, bdf = study.scheme.degree, study.scheme.bdf
    stationary = study.solution.initial().stationary
    expected = {"h": degree, "tau": bdf}[blank.direction]
    if claim is not None:
        expected = claim.expected_order(degree, bdf)
        blank = replace(blank, expected=expected, tolerance=claim.tolerance)
    unfit = _unfit(study, records)
    if unfit:
        return replace(blank, verdict="inconclusive" if claim else "no claim", reason=unfit)
    if blank.direction == "tau" and not stationary and _in_space_alone(study, records, blank):
        reason = "an error in space alone: it does not depend on tau"
        return replace(blank, verdict="not exercised", reason=reason)
    table = judged_table(study, records, blank.variable)
    judgement = judge_table(
        table,
        expected,
        direction=blank.direction,
        tolerance=0.2 if claim is None else claim.tolerance,
        other_order={"h": bdf, "tau": degree}[blank.direction],
        floors=_floors_of(floors, blank.variable, blank.direction),
        stationary=stationary,
        declared_super=blank.variable in study.study.superconvergent,
    )
    return _from_judgement(blank, judgement, table, claim is not None)


def judged_table(study: Study, records: pd.DataFrame, variable: str) -> pd.DataFrame:
    """The columns that `judge_table` reads, and vertices, of all runs that may be judged."""
    runs = records[~records["vertices"].isin(too_fine(study, records))]
    columns = ["vertices", "h", "tau", "status", "seconds", "final_time"]
    return runs[columns].assign(error=runs[f"err_{variable}"])


def _floors_of(floors: pd.DataFrame | None, variable: str, parameter: Direction) -> list[Floor]:
    """The measured floors that bind in this direction."""
    if floors is None or floors.empty:
        return []
    own = floors[(floors["variable"] == variable) & (floors["floor"] != parameter)]
    return [Floor(row.floor, row.value) for row in own.itertuples() if np.isfinite(row.value)]


def _from_judgement(blank: Verdict, j: Judgement, table: pd.DataFrame, claimed: bool) -> Verdict:
    window = table[table[blank.direction].isin(j.window)]
    if blank.direction == "h" and len(window):
        window = window[window["tau"] == _line(j, window, "tau")]
    elif len(window):
        window = window[window["h"] == window["h"].min()]
    window = window.sort_values(blank.direction, ascending=False)
    outcome = j.outcome if claimed or j.outcome == "not exercised" else "no claim"
    return replace(
        blank,
        verdict=outcome,
        reason=_reason(j, window, claimed),
        observed=j.order,
        lower=j.lower,
        upper=j.upper,
        constant=j.constant,
        scatter=j.scatter,
        error=float(window["error"].iloc[-1]) if len(window) else NAN,
        model=j.model,
        next_run=j.next_run if claimed else "",
        tau=tuple(float(t) for t in dict.fromkeys(window["tau"])),
        vertices=tuple(int(v) for v in dict.fromkeys(window["vertices"])),
        masked=j.masked,
    )


def _line(j: Judgement, window: pd.DataFrame, other: str) -> float:
    """The value of the other parameter on whose line all judged levels lie: the finest such."""
    counts = window[window["status"] == "ok"].groupby(other)["error"].count()
    return float(counts.index[counts >= len(j.window)].min())


def _reason(j: Judgement, window: pd.DataFrame, claimed: bool) -> str:
    where = ""
    if len(window):
        V, tau = window["vertices"].tolist(), window["tau"].tolist()
        where = (
            f" over V = {V[0]}..{V[-1]} at tau = {tau[0]:g}"
            if j.direction == "h"
            else f" over tau = {tau[0]:g}..{tau[-1]:g} at V = {V[0]}"
        )
    if not claimed:
        return j.cause if j.outcome == "not exercised" else "observed, without a claim"
    if j.outcome == "pass":
        return f"meets order {j.claimed:g}{where}"
    if j.outcome == "super":
        return f"exceeds order {j.claimed:g}{where}"
    return f"{j.cause}{where}"


def _unfit(study: Study, records: pd.DataFrame) -> str:
    """Why nothing can be judged; "" if it can."""
    missing = missing_runs(study, records)
    failed = int((records["status"] == "failed").sum())
    if missing or failed:
        return f"{len(missing)} runs missing, {failed} with solver failure"
    return ""


def _in_space_alone(study: Study, records: pd.DataFrame, blank: Verdict) -> bool:
    """Whether the error is the same at all time steps, and measured to be that of the mesh."""
    finished = records[records["status"] == "ok"]
    column = f"err_{blank.variable}"
    by_mesh = [runs for _, runs in finished.groupby("h")]  # fine before coarse
    if len(by_mesh) < 2 or len(by_mesh[0]) < 2:
        return False
    error, coarser = by_mesh[0].set_index("tau")[column], by_mesh[1].set_index("tau")[column]
    growth = (by_mesh[1]["h"].iloc[0] / by_mesh[0]["h"].iloc[0]) ** study.scheme.degree - 1.0
    share = (coarser - error).abs() / growth / error
    constant = error.max() < (1 + INDEPENDENT) * error.min()
    return bool(constant and (share.reindex(error.index) > SHARE).all())


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
