"""Verdicts: does the observed order meet the claim?  Pure functions of study, records and claims.

An order is judged by `esfem.judging.judge_table`, from the table of one variable, with the floors
that were measured for the study (`studies.variations`); a bound on an error by `judge_limit`.
Claims are upper bounds on the error, so that a higher order meets them, unless they are sharp.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from esfem.judging import Floor, Judgement, Masked, judge_table
from esfem.judging.eoc import Fit, fit_order
from esfem.judging.outcome import Outcome
from esfem.results.selection import LEVELS, Selection, selection
from esfem.studies.claims import Claim, Direction
from esfem.studies.quantities import QUANTITIES, norm
from esfem.studies.study import Study

NAN = float("nan")
FAR_BELOW = 20.0  # times below its limit, an error need not fall any more


@dataclass(frozen=True)
class Verdict:
    """One variable of one study, judged.

    ``expected`` (with ``tolerance``) is NaN unless an order is claimed, ``limit`` unless a bound on
    the error is. ``observed`` is the order, the median of what is possible, [``lower``, ``upper``]
    hold it with 95 %, ``constant`` is that of E = constant s^observed over the judged window, and
    ``scatter`` the standard deviation of log E; NaN where there was nothing to fit. ``error`` is
    that of the finest judged run. ``tau`` and ``vertices`` say which runs were judged, ``masked``
    which were not, and ``next_run`` what would settle an inconclusive case.
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

    def error_at(self, s: float) -> float:
        """The fitted error at h or tau = s."""
        return self.constant * s**self.observed


def judge(study: Study, records: pd.DataFrame, floors: pd.DataFrame | None = None) -> list[Verdict]:
    """The verdict on each variable.

    Parameters
    ----------
    records : one row a run (`esfem.results.records.record_row`).
    floors : those that were measured (`esfem.results.records.floors_table`).
    """
    chosen = selection(study, records)
    return [_judge_variable(study, chosen, floors, name) for name in study.variables]


def _judge_variable(
    study: Study, chosen: Selection, floors: pd.DataFrame | None, variable: str
) -> Verdict:
    claim = study.claimed
    claim = claim if claim is not None and variable in claim.variables else None
    blank = Verdict(
        study=study.name,
        claim="" if claim is None else claim.name,
        source="" if claim is None else claim.source,
        variable=variable,
        norm=norm(variable, study.initial),
        direction=study.direction,
        verdict="no claim",
        reason="",
    )
    if claim is not None and claim.limit is not None:
        return judge_limit(chosen, blank, claim)
    return _judge_order(study, chosen, floors, blank, claim)


def _judge_order(
    study: Study,
    chosen: Selection,
    floors: pd.DataFrame | None,
    blank: Verdict,
    claim: Claim | None,
) -> Verdict:
    degree, bdf = study.scheme.degree, study.scheme.order
    expected: float = {"h": degree, "tau": bdf}[blank.direction]
    if claim is not None:
        expected = study.expected_order
        blank = replace(blank, expected=expected, tolerance=claim.tolerance)
    if chosen.unfit:
        return replace(blank, verdict="inconclusive" if claim else "no claim", reason=chosen.unfit)
    if blank.variable in chosen.space_alone:
        reason = "an error in space alone: it does not depend on tau"
        return replace(blank, verdict="not exercised", reason=reason)
    table = _table(chosen.runs, blank.variable)
    judgement = judge_table(
        table,
        expected,
        direction=blank.direction,
        tolerance=0.2 if claim is None else claim.tolerance,
        other_order={"h": bdf, "tau": degree}[blank.direction],
        floors=_floors_of(floors, blank.variable, blank.direction),
        stationary=study.initial.stationary,
        declared_super=blank.variable in study.study.superconvergent,
    )
    return _from_judgement(blank, judgement, table, claim)


def _table(runs: pd.DataFrame, variable: str) -> pd.DataFrame:
    """The columns that `judge_table` reads, and vertices."""
    columns = ["vertices", "h", "tau", "status", "seconds", "final_time"]
    return runs[columns].assign(error=runs[f"err_{variable}"])


def _floors_of(floors: pd.DataFrame | None, variable: str, parameter: Direction) -> list[Floor]:
    """The measured floors that bind in this direction."""
    if floors is None or floors.empty:
        return []
    own = floors[(floors["variable"] == variable) & (floors["floor"] != parameter)]
    return [Floor(row.floor, row.value) for row in own.itertuples() if np.isfinite(row.value)]


def _from_judgement(
    blank: Verdict, j: Judgement, table: pd.DataFrame, claim: Claim | None
) -> Verdict:
    window = table[table[blank.direction].isin(j.window)]
    other = {"h": "tau", "tau": "h"}[blank.direction]
    if not window[other].duplicated().any():
        pass  # both are refined together, or there is one run
    elif blank.direction == "h":
        window = window[window["tau"] == _line(j, window, "tau")]
    else:
        window = window[window["h"] == window["h"].min()]
    window = window.sort_values(blank.direction, ascending=False)
    outcome, reason = _outcome(j, claim)
    return replace(
        blank,
        verdict=outcome,
        reason=f"{reason}{_where(j, window)}" if claim is not None else reason,
        observed=j.order,
        lower=j.lower,
        upper=j.upper,
        constant=j.constant,
        scatter=j.scatter,
        error=float(window["error"].iloc[-1]) if len(window) else NAN,
        model=j.model,
        next_run="" if claim is None else j.next_run,
        tau=tuple(float(t) for t in dict.fromkeys(window["tau"])),
        vertices=tuple(int(v) for v in dict.fromkeys(window["vertices"])),
        masked=j.masked,
    )


def _line(j: Judgement, window: pd.DataFrame, other: str) -> float:
    """The value of the other parameter on whose line all judged levels lie: the finest such."""
    counts = window[window["status"] == "ok"].groupby(other)["error"].count()
    return float(counts.index[counts >= len(j.window)].min())


def _outcome(j: Judgement, claim: Claim | None) -> tuple[Outcome, str]:
    """What the judgement means for the claim, and why."""
    if claim is None:
        known = j.outcome == "not exercised"
        return (j.outcome, j.cause) if known else ("no claim", "observed, without a claim")
    if claim.sharp and j.outcome in ("super", "suspect"):
        return "fail", f"above {j.claimed:g} + {claim.tolerance:g}, which cannot be"
    meets = {"pass": f"meets order {j.claimed:g}", "super": f"exceeds order {j.claimed:g}"}
    return j.outcome, meets.get(j.outcome, j.cause)


def _where(j: Judgement, window: pd.DataFrame) -> str:
    """On which runs an order was observed."""
    if window.empty:
        return ""
    V, tau = window["vertices"].tolist(), window["tau"].tolist()
    if j.direction == "h":
        return f" over V = {V[0]}..{V[-1]} at tau = {tau[0]:g}"
    return f" over tau = {tau[0]:g}..{tau[-1]:g} at V = {V[0]}"


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
        return replace(blank, verdict="inconclusive", reason=why, limit=_limit(claim))
    fit = fitted(runs[blank.direction], errors)
    outcome, reason = compare_limit(fit, list(errors), claim)
    half = 2.0 * fit.uncertainty
    return replace(
        blank,
        verdict=outcome,
        reason=reason,
        limit=_limit(claim),
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
    limit = _limit(claim)
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


def _limit(claim: Claim) -> float:
    return NAN if claim.limit is None else claim.limit
