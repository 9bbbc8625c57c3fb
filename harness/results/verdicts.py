"""Verdicts: does the observed order meet the claim?  Pure functions of study, records and claims.

An order is judged by `esfem.judging.judge_table`, from the table of one variable, with the floors
that were measured for the study (`esfem.studies.variations`); a bound on an error by `esfem.results.limits`. Claims
are upper bounds on the error, so that a higher order meets them, unless they are sharp.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
from esfem.judging import Floor, Judgement, judge_table
from esfem.results.limits import judge_limit
from esfem.results.selection import Selection, selection
from esfem.results.verdict import NAN, Outcome, Verdict
from esfem.studies.claims import Claim, Direction
from esfem.studies.quantities import norm
from esfem.studies.study import Study


def judge(study: Study, records: pd.DataFrame, floors: pd.DataFrame | None = None) -> list[Verdict]:
    """The verdict on each variable.

    Parameters
    ----------
    records : one row a run (`esfem.results.rows.record_row`).
    floors : those that were measured (`esfem.studies.variations.floors_table`).
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
    expected = {"h": degree, "tau": bdf}[blank.direction]
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
    if blank.direction == "h" and len(window):
        window = window[window["tau"] == _line(j, window, "tau")]
    elif len(window):
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
