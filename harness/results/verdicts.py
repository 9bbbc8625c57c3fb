"""Verdicts: does what was observed of a variable meet the claim?  Pure functions of study, records
and claims.

An order is a claim on both errors of a variable, u_h - u and u_h - I_h u: a theorem that bounds one
bounds the other, by the triangle inequality and the order of interpolation. Each is judged by
itself (`esfem.results.error_verdicts`), and the worst of those that were exercised decides. A bound
on an error (`esfem.results.limits`) is on u_h - u alone.
"""

from dataclasses import dataclass

import pandas as pd

from esfem.judging.floors import Masked
from esfem.judging.outcome import SEVERITY, Outcome
from esfem.results.error_verdicts import NAN, PREFIXES, ErrorVerdict, judge_order
from esfem.results.limits import judge_limit, within_limit
from esfem.results.selection import Selection, selection
from esfem.studies.claims import Direction
from esfem.studies.study import Study


@dataclass(frozen=True)
class Verdict:
    """One variable of one study, judged: what is claimed of it, and the verdict on each error.

    ``expected`` (with ``tolerance``) is NaN unless an order is claimed, ``limit`` unless a bound on
    the error is. ``parts`` are the verdicts on the errors that were judged, at least one.
    """

    study: str
    claim: str
    source: str
    variable: str
    direction: Direction
    parts: tuple[ErrorVerdict, ...]
    expected: float = NAN
    tolerance: float = NAN
    limit: float = NAN

    def __post_init__(self) -> None:
        names = [part.name for part in self.parts]
        if not names or len(set(names)) < len(names):
            raise ValueError(f"parts = {names}: must be different errors, at least one")

    @property
    def deciding(self) -> ErrorVerdict:
        """The part that decides: the worst of those that were exercised, the first of equals."""
        return max(self.parts, key=lambda part: SEVERITY.index(part.outcome))

    @property
    def verdict(self) -> Outcome:
        """That of the deciding part."""
        return self.deciding.outcome

    @property
    def reason(self) -> str:
        """That of the deciding part."""
        return self.deciding.reason

    @property
    def norm(self) -> str:
        """That of the deciding part."""
        return self.deciding.norm

    @property
    def observed(self) -> float:
        """That of the deciding part."""
        return self.deciding.observed

    @property
    def lower(self) -> float:
        """That of the deciding part."""
        return self.deciding.lower

    @property
    def upper(self) -> float:
        """That of the deciding part."""
        return self.deciding.upper

    @property
    def constant(self) -> float:
        """That of the deciding part."""
        return self.deciding.constant

    @property
    def scatter(self) -> float:
        """That of the deciding part."""
        return self.deciding.scatter

    @property
    def error(self) -> float:
        """That of the deciding part."""
        return self.deciding.error

    @property
    def model(self) -> str:
        """That of the deciding part."""
        return self.deciding.model

    @property
    def next_run(self) -> str:
        """That of the deciding part."""
        return self.deciding.next_run

    @property
    def tau(self) -> tuple[float, ...]:
        """That of the deciding part."""
        return self.deciding.tau

    @property
    def vertices(self) -> tuple[int, ...]:
        """That of the deciding part."""
        return self.deciding.vertices

    @property
    def masked(self) -> tuple[Masked, ...]:
        """That of the deciding part."""
        return self.deciding.masked


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
    limit = claim.limit_of(variable) if claim is not None else None
    of_order = claim is not None and claim.order is not None
    if claim is not None and limit is not None and not of_order:
        parts = [judge_limit(study, chosen, variable, limit, claim.converges)]
    else:
        names = [n for n, prefix in PREFIXES.items() if f"{prefix}{variable}" in chosen.runs]
        parts = [judge_order(study, chosen, floors, variable, name) for name in names]
        if limit is not None:
            parts = [within_limit(p, limit) if p.name == "error" else p for p in parts]
    return Verdict(
        study=study.name,
        claim="" if claim is None else claim.name,
        source="" if claim is None else claim.source,
        variable=variable,
        direction=study.direction,
        parts=tuple(parts),
        expected=study.expected_order if of_order else NAN,
        tolerance=claim.tolerance if claim is not None and of_order else NAN,
        limit=NAN if limit is None else limit,
    )
