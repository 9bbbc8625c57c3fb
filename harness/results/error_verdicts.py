"""The verdict on one error of a variable: on u_h - u, or on u_h - I_h u, against the interpolation.

An order is judged by `esfem.judging.judge_table`, with the floors that were measured for the study
(`studies.variations`). Claims are upper bounds on the error, so that a higher order meets them;
a sharp one is so on u_h - u alone, for u_h - I_h u may fall faster.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import pandas as pd

from esfem.judging import Floor, Judgement, Masked, judge_table
from esfem.judging.outcome import Outcome
from esfem.measuring.lift import VARIABLES
from esfem.results.selection import Selection
from esfem.studies.claims import Claim
from esfem.studies.quantities import NODAL, QUANTITIES, norm
from esfem.studies.study import Study

NAN = float("nan")
EXERCISED = 10.0  # times the error, that the initial State kept for ever scores at least
NEVER = "the States never change"

ErrorName = Literal["error", "interpolation"]
PREFIXES: dict[ErrorName, str] = {"error": "err_", "interpolation": "nodal_"}
WORDS: dict[ErrorName, str] = {
    "error": "error",
    "interpolation": "error against the interpolation",
}


@dataclass(frozen=True)
class ErrorVerdict:
    """One error of one variable, judged.

    ``name`` says which error, ``norm`` in which norm. ``observed`` is the median of the order as
    the judged parameter goes to 0, [``lower``, ``upper``] hold it with 95 %, ``probability`` is
    that of an order of at least the claimed one less the tolerance, ``constant`` that of E =
    constant s^observed, ``scatter`` the standard deviation of log E about the likely models; NaN
    where there was nothing to fit. ``error`` is that of the finest judged run. ``tau`` and
    ``vertices`` say which runs were judged, ``masked`` which were not, and ``next_run`` what would
    settle an inconclusive case.
    """

    name: ErrorName
    norm: str
    outcome: Outcome
    reason: str
    observed: float = NAN
    lower: float = NAN
    upper: float = NAN
    probability: float = NAN
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

    def column(self, variable: str) -> str:
        """The column of records.csv that was judged."""
        return f"{PREFIXES[self.name]}{variable}"


def judge_order(
    study: Study, chosen: Selection, floors: pd.DataFrame | None, variable: str, name: ErrorName
) -> ErrorVerdict:
    """The verdict on one error against the order that is claimed, or would be expected."""
    claim = study.claimed
    claim = claim if claim is not None and variable in claim.variables else None
    told = NODAL if name == "interpolation" else norm(variable, study.initial)
    blank = ErrorVerdict(name, told, "no claim", "")
    known = _known_beforehand(chosen, f"{PREFIXES[name]}{variable}")
    if known is not None:
        outcome, reason = known
        return replace(blank, outcome=outcome if claim else "no claim", reason=reason)
    table = _table(chosen.runs, variable, name)
    degree, bdf = study.scheme.degree, study.scheme.order
    expected = study.expected_order if claim else {"h": degree, "tau": bdf}[study.direction]
    why_more = study.study.why_more(variable, name)
    judgement = judge_table(
        table,
        expected,
        direction=study.direction,
        tolerance=0.2 if claim is None else claim.tolerance,
        other_order={"h": bdf, "tau": degree}[study.direction],
        floors=_floors_of(study, floors, variable, table),
        stationary=study.initial.stationary or not QUANTITIES[variable].in_time,
        declared_super=bool(why_more),
    )
    found = _from_judgement(blank, judgement, table)
    if claim is None:
        silent = judgement.outcome == "not exercised"
        return replace(
            found, reason=judgement.cause if silent else "observed, without a claim", next_run=""
        )
    found = _against_claim(found, judgement, claim, table, why_more)
    comparable = variable in VARIABLES or table["idle"].notna().any()
    if name == "error" and comparable and found.outcome != "not exercised":
        return _beside_the_start(study, found, table)
    return found


def _known_beforehand(chosen: Selection, column: str) -> tuple[Outcome, str] | None:
    """Outcome and reason where there is no table to judge; None if there is one."""
    if chosen.unfit:
        return "inconclusive", chosen.unfit
    if not chosen.moves:
        return "not exercised", NEVER
    if column in chosen.space_alone:
        return "not exercised", "an error in space alone: it does not depend on tau"
    return None


def _table(runs: pd.DataFrame, variable: str, name: ErrorName) -> pd.DataFrame:
    """The columns that `judge_table` reads, vertices, and ``idle``: the error of the initial State
    kept for ever, NaN where it is not known."""
    columns = ["vertices", "h", "tau", "status", "seconds", "final_time"]
    idle = runs.get(f"idle_{variable}", pd.Series(NAN, index=runs.index))
    return runs[columns].assign(error=runs[f"{PREFIXES[name]}{variable}"], idle=idle)


def _floors_of(
    study: Study, floors: pd.DataFrame | None, variable: str, table: pd.DataFrame
) -> list[Floor]:
    """The measured floors that bind in the direction of the study, an entry a row of the table.

    That of tau was measured at one time step; at larger ones it is larger, by the order in time.
    """
    if floors is None or floors.empty:
        return []
    own = floors[(floors["variable"] == variable) & (floors["floor"] != study.direction)]
    found = []
    for row in own[np.isfinite(own["value"])].itertuples():
        growth = (table["tau"] / row.tau) ** study.scheme.order if row.floor == "tau" else 1.0
        found.append(Floor(row.floor, np.maximum(growth, np.ones(len(table))) * row.value))
    return found


def _from_judgement(blank: ErrorVerdict, j: Judgement, table: pd.DataFrame) -> ErrorVerdict:
    """The numbers of the judgement, and the runs that it is about."""
    window = _window(j, table)
    return replace(
        blank,
        observed=j.order,
        lower=j.lower,
        upper=j.upper,
        probability=j.probability,
        constant=j.constant,
        scatter=j.scatter,
        error=float(window["error"].iloc[-1]) if len(window) else NAN,
        model=j.model,
        next_run=j.next_run,
        tau=tuple(float(t) for t in dict.fromkeys(window["tau"])),
        vertices=tuple(int(v) for v in dict.fromkeys(window["vertices"])),
        masked=j.masked,
    )


def _window(j: Judgement, table: pd.DataFrame) -> pd.DataFrame:
    """The rows of the judged runs, coarse before fine."""
    window = table[table[j.direction].isin(j.window)]
    other = {"h": "tau", "tau": "h"}[j.direction]
    if window[other].duplicated().any():  # else both are refined together, or there is one run
        window = window[window[other] == _line(j, window, other)]
    return window.sort_values(j.direction, ascending=False)


def _line(j: Judgement, window: pd.DataFrame, other: str) -> float:
    """The value of the other parameter on whose line all judged levels lie: the finest such."""
    counts = window[window["status"] == "ok"].groupby(other)["error"].count()
    return float(counts.index[counts >= len(j.window)].min())


def _against_claim(
    found: ErrorVerdict, j: Judgement, claim: Claim, table: pd.DataFrame, why_more: str
) -> ErrorVerdict:
    """What the judgement means for the claim, and why."""
    if claim.sharp and found.name == "error" and j.outcome in ("super", "suspect"):
        reason = f"above {j.claimed:g} + {claim.tolerance:g}, which cannot be"
        return replace(found, outcome="fail", reason=reason)
    meets = {"pass": f"meets order {j.claimed:g}", "super": f"exceeds order {j.claimed:g}"}
    reason = f"{meets.get(j.outcome, j.cause)}{_where(j, _window(j, table))}"
    if why_more and j.outcome in meets:
        reason = f"{reason}; more is declared: {why_more}"
    return replace(found, outcome=j.outcome, reason=reason)


def _where(j: Judgement, window: pd.DataFrame) -> str:
    """On which runs an order was observed."""
    if window.empty:
        return ""
    V, tau = window["vertices"].tolist(), window["tau"].tolist()
    if j.direction == "h":
        return f" over V = {V[0]}..{V[-1]} at tau = {tau[0]:g}"
    return f" over tau = {tau[0]:g}..{tau[-1]:g} at V = {V[0]}"


def _beside_the_start(study: Study, found: ErrorVerdict, table: pd.DataFrame) -> ErrorVerdict:
    """Not exercised where a scheme that does nothing has an error of much the same size.

    What the initial State kept for ever scores on the finest judged run decides; on the finest run
    that ended, if none was judged. A table of an older version does not know it, and says so.
    """
    judged = table[table["vertices"].isin(found.vertices) & table["tau"].isin(found.tau)]
    ended = (judged if len(judged) else table).query("error == error")
    if ended.empty:
        return found
    finest = ended.sort_values(["h", "tau"]).iloc[0]
    idle, error = float(finest["idle"]), float(finest["error"])
    if np.isnan(idle):
        note = "what the initial State kept for ever scores is not known"
        return replace(found, reason=f"{found.reason}; {note}")
    if idle >= EXERCISED * error:
        return found
    score = f"the initial State kept for ever scores {idle:.2g}, less than {EXERCISED:g} times"
    told = f"{score} the error {error:.2g}"
    alone = study.initial.stationary and idle > error / EXERCISED
    reason = f"{told}: it measures the interpolation alone" if alone else told
    return replace(found, outcome="not exercised", reason=reason, next_run="")
