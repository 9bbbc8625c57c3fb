"""The judge: from one table of errors to an outcome by probability, as a pure function."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from esfem.common.bad_input import BadInput
from esfem.judging.advice import Cost, Found, described, next_run
from esfem.judging.causes import Seen, sentence
from esfem.judging.decision import RULES, Course, Odds, continued, decide, odds
from esfem.judging.evidence import Evidence, evidence_of, told_of
from esfem.judging.floors import EPS, Floor, Masked, near_floors, rounding_floor
from esfem.judging.judgement import Judgement, Outcome
from esfem.judging.second_mesh import falls_with_h
from esfem.judging.slices import LEAST_RANGE, TURNED, Slice, judged_slice, obstacle
from esfem.judging.table_columns import Array, Table
from esfem.judging.validate import Direction, Runs, identical, validated

LEVELS_MIN = 4
MOST_LEVELS = 50  # time and memory grow with the third power of their number
FLAT = 0.3  # an order up to here may be none: the other parameter may rule
NOTED = 0.05  # below the claim, from which on it is said that rates fall
SLOWS = 0.8  # of the rate before: errors so small that fall no faster may meet rounding
GROWS = 1.1  # factor from level to level, from which on errors grow
CANCELS = 0.3  # the probability from which on two parts may cancel
TINY = 1e-8  # of the largest value: a floor below it may be rounding, or a solver's tolerance
STEADY = "a stationary solution has no error in time"
EXACT = "exact up to rounding: the errors lie at that floor, and there is no order to see"


@dataclass(frozen=True)
class Asked:
    """The claim, and what is known beside the table; see `judge_table`.

    ``known`` says that the error in the other parameter is measured, or not there, and ``exact``
    that rounding and the solver's tolerance are, so that no floor of that kind is to be guessed.
    """

    order: float
    direction: Direction
    tolerance: float
    other_order: float | None
    known: bool
    exact: bool
    declared_super: bool
    levels_min: int
    cost: Cost | None

    def claim(self, gamma: float) -> float:
        """The order that is judged: on a path tau ~ h^gamma the lower one of both."""
        if np.isnan(gamma) or self.other_order is None or self.known:
            return self.order
        along = self.other_order * gamma if self.direction == "h" else self.other_order / gamma
        return min(self.order, along)


def judge_table(
    table: Table,
    order: float,
    *,
    direction: Direction = "h",
    tolerance: float = 0.2,
    other_order: float | None = None,
    floors: Sequence[Floor] = (),
    stationary: bool = False,
    declared_super: bool = False,
    cost: Cost | None = None,
    levels_min: int = LEVELS_MIN,
) -> Judgement:
    """Whether the errors of a table fall with the claimed order.

    Where h and tau are refined together, tau ~ h^gamma, they are judged along the path, with the
    claim min(order, other_order gamma).  Errors that do not fall with tau are blamed on the mesh
    unless a second one shows that they are not.

    Parameters
    ----------
    table
        Columns h and error, optionally tau, status, seconds, final_time, an entry a run: a mapping
        of columns, a structured array or a DataFrame.
    order
        The claimed order in ``direction``; an upper bound on the error, so more meets it.
    tolerance
        How far the order may lie below the claim.
    other_order
        The order expected in the other parameter, where it is known.
    floors
        Measured floors; runs near them are masked.  Without one of rounding, eps times the largest
        error, or 1 if that is larger, is assumed.
    stationary
        The solution does not move: there is no error in tau.
    declared_super
        More than the order is expected: more than the order + 1.5 is no reason for suspicion.
    cost
        Seconds of a run (h, tau), for the estimate of the next one.
    levels_min
        The fewest levels on which a verdict is given; 3 at least.

    Raises
    ------
    BadInput
        If the table is not one (`esfem.judging.validate.validated`).
    """
    if levels_min < 3:
        raise ValueError(f"levels_min = {levels_min}: an order needs 3 levels at least")
    runs = near_floors(validated(table, direction), floors)
    # A measured part in the other parameter needs no model. Levels within ten times of it are
    # masked, so that on those that are left it makes no plateau.
    known = stationary or ("tau" if direction == "h" else "h") in {floor.name for floor in floors}
    asked = Asked(
        order,
        direction,
        tolerance,
        other_order,
        known,
        {"rounding", "solver"} <= {floor.name for floor in floors},
        declared_super,
        levels_min,
        cost,
    )
    part = judged_slice(runs, direction, known, levels_min)
    if len(part.s) > MOST_LEVELS:
        raise BadInput(
            f"{direction}: has {len(part.s)} levels; at most {MOST_LEVELS} are judged, the finest "
            "say most of the order"
        )
    measured: set[str] = {floor.name for floor in floors}
    blank = _blank(part, asked, measured)
    if direction == "tau" and stationary:
        return replace(blank, outcome="not exercised", code="stationary", cause=STEADY)
    return _without_order(blank, part, asked, measured) or _judged(blank, part, asked)


def _blank(part: Slice, asked: Asked, measured: set[str]) -> Judgement:
    """A judgement before its verdict: the claim, what is masked, what was assumed."""
    claim, notes = asked.claim(part.gamma), []
    if np.isfinite(part.gamma):
        of = "" if asked.other_order is None else f", where order {claim:g} is claimed"
        notes.append(
            f"h and tau are refined together, tau ~ h^{part.gamma:.3g}: judged along that path{of}"
        )
    if not measured & {"rounding"} and (part.runs.floor == "rounding").any():
        least = rounding_floor(part.runs.error)
        notes.append(f"no floor of rounding was given: eps x {least / EPS:.2g} is assumed")
    return Judgement(
        "inconclusive",
        claim,
        asked.direction,
        levels=len(part.s),
        masked=tuple(_masked(part.runs)),
        notes=tuple(notes),
        tolerance=asked.tolerance,
    )


def _masked(runs: Runs) -> list[Masked]:
    """The runs that are not judged, and why."""
    return [
        Masked(float(runs.h[i]), float(runs.tau[i]), str(runs.reason[i]), str(runs.floor[i]))
        for i in np.flatnonzero(~runs.clear)
    ]


def _without_order(
    blank: Judgement, part: Slice, asked: Asked, measured: set[str]
) -> Judgement | None:
    """The judgement where there is no order to judge; None if there is one."""
    finite = part.runs.at(np.isfinite(part.runs.error))
    if not len(finite):
        return None
    if not finite.error.any() and not measured & {"rounding", "solver"}:
        return _undecided(blank, part, asked, "zero")
    exact = np.isin(finite.floor, ("rounding", "solver"))
    if exact.any() and not finite.clear.any() and (finite.reason[~exact] == TURNED).all():
        return replace(blank, outcome="not exercised", code="rounding", cause=EXACT)
    if identical(finite.error) and len(np.unique(finite.parameter(asked.direction))) > 2:
        return _not_falling(blank, part, asked, "identical")
    return None


def _judged(blank: Judgement, part: Slice, asked: Asked) -> Judgement:
    """The judgement by the posterior of the order, if there are levels enough."""
    if len(part.s) < asked.levels_min:
        return _undecided(blank, part, asked, obstacle(part))
    if part.s[0] < LEAST_RANGE * part.s[-1] * (1.0 - 1e-9) and len(part.s) <= LEVELS_MIN:
        return _undecided(blank, part, asked, "close")
    evidence = evidence_of(part, blank.claimed, asked.other_order, plateaus=not asked.known)
    excused = _excused(part, asked)
    seen = odds(evidence.found, blank.claimed, asked.tolerance, excused)
    judgement = told_of(blank, part, evidence, excused, seen.at_least)
    outcome, code = _verdict(judgement, part, evidence, seen, asked)
    levels_off = code == "plateau" or (outcome == "inconclusive" and _flattens(part))
    if levels_off and asked.direction == "tau" and np.isnan(part.gamma):
        return _not_falling(judgement, part, asked, "plateau")
    if outcome == "inconclusive":
        return _undecided(judgement, part, asked, _named(code, part, excused))
    if outcome in ("pass", "super"):
        notes = (*judgement.notes, *_trend_noted(evidence.rates, part.s, judgement.claimed))
        return replace(judgement, outcome=outcome, notes=notes)
    return replace(judgement, outcome=outcome, code=code, cause=_cause(judgement, part, code))


def _excused(part: Slice, asked: Asked) -> float:
    """A floor that may be rounding, or a solver's tolerance, as a multiple of the finest error; 0
    where both were measured."""
    if asked.exact:
        return 0.0
    return TINY * rounding_floor(part.runs.error) / EPS / float(part.e[-1])


def _flattens(part: Slice) -> bool:
    """Whether the errors of the three finest levels hardly fall, and more slowly than before."""
    rates = np.diff(np.log(part.e)) / np.diff(np.log(part.s))
    return bool(rates[-2:].mean() < FLAT and rates[-2:].mean() < rates.mean())


def _trend_noted(rates: Array, s: Array, claim: float) -> list[str]:
    """That rates fall away from the claim, though not so far that it is in doubt."""
    ahead = continued(rates, np.log(s / s[-1]))
    if not (ahead < rates[-1] < claim - NOTED):
        return []
    return [
        f"the rates fall below {claim:g}, to {rates[-1]:.2f}; two levels more may have {ahead:.2f}"
    ]


def _verdict(
    judgement: Judgement, part: Slice, evidence: Evidence, seen: Odds, asked: Asked
) -> tuple[Outcome, str]:
    """The outcome and the word for its cause."""
    x, joint = np.log(part.s / part.s[-1]), evidence.joint
    course = Course(
        judgement.order,
        float(evidence.rates[-1]),
        continued(evidence.rates, x),
        evidence.scatter,
        bool(evidence.off[-1]),
    )
    k, d = judgement.claimed, asked.tolerance
    outcome, code = decide(seen, course, k, d, asked.declared_super)
    if joint is not None and joint.cancels > CANCELS and outcome != "fail":
        return "inconclusive", "cancellation"
    if joint is not None and joint.share > RULES and outcome == "inconclusive":
        return "inconclusive", "plateau"
    flat = outcome == "fail" and judgement.upper < FLAT
    if flat and _excused(part, asked) > 1.0:
        return "inconclusive", "rounding"
    # Errors that do not fall at all may be those in the other parameter, if there is one.
    alone = joint is None and np.isfinite(part.runs.tau).all() and np.isnan(part.gamma)
    if flat and alone and not asked.known:
        return "inconclusive", "plateau"
    return outcome, code


def _named(code: str, part: Slice, excused: float) -> str:
    """A more telling word than trend, noise or plateau, if the finest levels have one."""
    if code not in ("trend", "noise", "plateau"):
        return code
    growth = np.diff(np.log(part.e[-3:]))
    if (growth > np.log(GROWS)).all():
        return "diverges"
    rates = np.diff(np.log(part.e[-3:])) / np.diff(np.log(part.s[-3:]))
    slows = rates[-1] < SLOWS * rates[0]
    met = (part.line.floor == "rounding").any() and code != "plateau"
    return "rounding" if met or (excused >= 1.0 and slows) else code


def _not_falling(judgement: Judgement, part: Slice, asked: Asked, code: str) -> Judgement:
    """The judgement on errors that are one number, or reach a plateau in tau."""
    if np.isnan(judgement.order):
        judgement = replace(judgement, order=0.0, lower=0.0, upper=0.0)
    if asked.direction == "tau":
        if not asked.known and falls_with_h(part.runs, asked.other_order) is not False:
            return _undecided(judgement, part, asked, "plateau")
        cause = "the errors do not fall with tau, nor with h"
        return replace(judgement, outcome="fail", code=code, cause=cause)
    return replace(judgement, outcome="fail", code=code, cause=_cause(judgement, part, code))


def _undecided(judgement: Judgement, part: Slice, asked: Asked, code: str) -> Judgement:
    """INCONCLUSIVE, with its cause and the run that would settle it."""
    room = asked.tolerance / 2
    if np.isfinite(judgement.order):
        room = max(asked.tolerance - abs(judgement.order - judgement.claimed), room)
    found = Found(
        len(part.s), judgement.scatter, room, asked.levels_min, bool(np.isfinite(part.gamma))
    )
    advice = next_run(part.runs, asked.direction, code, found)
    cause = _cause(judgement, part, code, asked.levels_min)
    told = described(advice, part.runs, asked.cost)
    return replace(judgement, outcome="inconclusive", code=code, cause=cause, next_run=told)


def _cause(judgement: Judgement, part: Slice, code: str, fewest: int = LEVELS_MIN) -> str:
    """The sentence for a code."""
    timed = bool(np.isfinite(part.runs.tau).all()) and np.isnan(part.gamma)
    other = {"h": "tau", "tau": "h"}[judgement.direction] if timed else ""
    return sentence(
        code,
        Seen(
            judgement.direction,
            other,
            part.s,
            part.e,
            judgement.claimed,
            judgement.tolerance,
            judgement.lower,
            judgement.upper,
            judgement.scatter,
            fewest,
            judgement.probability,
            judgement.joint.share if judgement.joint is not None else 0.0,
        ),
    )
