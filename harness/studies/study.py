"""Study files: what to solve, with which scheme, on which (h, tau) grid, and what is claimed."""

import math
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationInfo, field_validator, model_validator

from esfem.common.input import Section, checking, read
from esfem.studies.case import (
    About,
    AnyScheme,
    Case,
    Derived,
    Law,
    Positive,
    Solution,
    TimeStep,
    TimeSteps,
    one_of,
)
from esfem.studies.claims import Claim, Direction, claims
from esfem.studies.quantities import QUANTITIES, asked_for, measured, requestable

STUDIES = Path(__file__).parent
COMPARED = ("finest", "axisymmetric")  # references that a run is compared with at some times
# Context of validation of stored results that are compared, not judged: what they claimed then may
# not be claimed any more.
CLAIMED_THEN = {"claimed": "then"}
ERRORS = ("error", "interpolation")  # of a variable: u_h - u, and u_h - I_h u
AS_TABLE = (
    "must be a table [study.superconvergent] of sentences that say why, "
    'such as V = "observed on surfaces at rest"'
)


class AboutStudy(About):
    """[study]

    ``superconvergent`` tells by variable, in a sentence, why more than the claimed order is
    expected: of both errors, or of one alone in the tables "error" and "interpolation" in it.
    """

    claim: str | None = None
    superconvergent: dict[str, str | dict[str, str]] = Field(default_factory=dict)

    @field_validator("superconvergent", mode="before")
    @classmethod
    def _sentences(cls, told: Any) -> Any:
        if not isinstance(told, dict):
            raise ValueError(f"superconvergent = {told!r}: {AS_TABLE}")
        of_both = {name: why for name, why in told.items() if name not in ERRORS}
        for where, table in {"": of_both, **{e: told[e] for e in ERRORS if e in told}}.items():
            if not isinstance(table, dict):
                raise ValueError(f"superconvergent.{where} = {table!r}: {AS_TABLE}")
            for name, why in table.items():
                key = f"superconvergent.{where}{'.' * bool(where)}{name}"
                one_of(key, name, QUANTITIES)
                if not isinstance(why, str) or not why.strip():
                    raise ValueError(f"{key} = {why!r}: must be a sentence that says why")
        return told

    def why_more(self, variable: str, error: str) -> str:
        """Why more than the claimed order is expected of that error of the variable, "error" or
        "interpolation"; "" if it is not."""
        own = self.superconvergent.get(error, {})
        why = own.get(variable) if isinstance(own, dict) else None
        both = self.superconvergent.get(variable, "")
        return why or (both if isinstance(both, str) else "")

    @field_validator("claim")
    @classmethod
    def _known(cls, claim: str | None, info: ValidationInfo) -> str | None:
        if claim is None or info.context == CLAIMED_THEN:
            return claim
        return one_of("claim", claim, claims())


class Sweep(TimeSteps):
    """[sweep]"""

    vertices: list[Annotated[int, Field(ge=4)]] = Field(min_length=1)
    tau: list[TimeStep] = Field(min_length=1)
    compare_at: list[Positive] = Field(default_factory=list)

    @field_validator("vertices", "tau", "compare_at")
    @classmethod
    def _distinct(cls, values: list[Any], info: ValidationInfo) -> list[Any]:
        for value in values:
            if values.count(value) > 1:
                raise ValueError(f"{info.field_name} = {values!r}: {value!r} occurs twice")
        return values

    @model_validator(mode="after")
    def _whole_steps(self) -> "Sweep":
        for tau in self.tau:
            self.check_steps(tau)
            for t in self.compare_at:
                self.check_time("compare_at", t, tau)
        return self


class Study(Derived, Section):
    """A whole study file."""

    study: AboutStudy
    solution: Solution
    law: Law
    scheme: AnyScheme
    sweep: Sweep

    @model_validator(mode="after")
    def _fit_together(self) -> "Study":
        solution, plugin = self.initial, self.plugin
        if self.law.name not in plugin.laws:
            raise ValueError(
                f"[law] name = {self.law.name!r}: scheme '{self.scheme.name}' solves "
                f"{', '.join(plugin.laws)}"
            )
        try:
            _ = self.forced
        except ValueError as error:
            raise ValueError(f"[law] {error}") from error
        if not self.sweep.final_time < solution.latest_time:
            raise ValueError(
                f"[sweep] final_time = {self.sweep.final_time!r}: solution '{solution.name}' "
                f"exists before t = {solution.latest_time:.10g} only"
            )
        if self.scheme.order > min(round(self.sweep.final_time / tau) for tau in self.sweep.tau):
            raise ValueError(
                f"[scheme] bdf = {self.scheme.order}: final_time must be at least bdf times tau"
            )
        if self.scheme.first_levels == "exact" and not solution.always_exact:
            raise ValueError(
                f"[scheme] start = 'exact': solution '{solution.name}' is exact at t = 0 only, "
                "start must be 'self'"
            )
        cases = self.cases()
        self._check_first_steps(cases[0].exact_start)
        for case in cases:
            try:
                _ = case.levels
            except ValueError as error:
                raise ValueError(f"[sweep] {error}") from error
        objection = self.scheme.objection(case.exact_start)
        if objection is not None:
            raise ValueError(f"[scheme] {objection}")
        if self.sweep.compare_at and solution.reference not in COMPARED:
            raise ValueError(
                "[sweep] compare_at: is for solution 'surface' only, with a reference that is "
                f"{' or '.join(COMPARED)}"
            )
        if solution.reference == "finest" and len(self.sweep.vertices) < 2:
            raise ValueError("[sweep] vertices: errors against the finest level need two of them")
        if plugin.slides and solution.reference == "finest":
            raise ValueError(
                f"[solution] reference = 'finest': nodes of scheme '{self.scheme.name}' slide and "
                "cannot be compared; reference = 'axisymmetric' can"
            )
        return self

    @model_validator(mode="after")
    def _claim_speaks_of_it(self, info: ValidationInfo) -> "Study":
        claim, solution = self.claimed, self.initial
        if claim is None and solution.reference == "start":
            raise ValueError(
                f"[study] claim: is missing; of solution '{solution.name}', of which the start "
                "alone is known, only what a claim names is measured"
            )
        if claim is None or info.context == CLAIMED_THEN:
            return self
        objection = claim.objection(self)
        known = self._measured
        foreign = [v for v in claim.variables if v not in known]
        if claim.direction == "tau" and solution.reference == "finest":
            objection = "is an order in tau, errors against the finest mesh have none"
        if foreign and objection is None:
            objection = f"judges {', '.join(foreign)}, not measured of '{solution.name}'"
        if objection:
            raise ValueError(f"[study] claim = {self.study.claim!r}: {objection}")
        return self

    def _check_first_steps(self, exact_start: bool) -> None:
        given = f"[sweep] first_steps = {self.sweep.first_steps}"
        if self.sweep.first_steps == 1:
            return
        if not self.plugin.substeps:
            raise ValueError(f"{given}: scheme '{self.scheme.name}' takes equal steps, must be 1")
        if exact_start:
            raise ValueError(
                f"{given}: is for a run that starts itself; solution '{self.solution.name}' gives "
                "exact start values unless [scheme] start = 'self'"
            )

    @cached_property
    def name(self) -> str:
        """The name, which is also that of its folder of results."""
        return self.study.name

    @cached_property
    def title(self) -> str:
        """What it is, in one line."""
        return self.study.title

    @cached_property
    def claimed(self) -> Claim | None:
        """The claim that it tests; None if there is none, or it is not claimed any more."""
        return claims().get(self.study.claim or "")

    @cached_property
    def expected_order(self) -> float:
        """The order that is claimed; NaN if none is."""
        claim = self.claimed
        return claim.expected_order(self.scheme.degree, self.scheme.order) if claim else math.nan

    @cached_property
    def claimed_length(self) -> float | None:
        """The unit of length of the claim; None if it has none, and that of the solution holds."""
        return None if self.claimed is None else self.claimed.length

    @cached_property
    def direction(self) -> Direction:
        """In which parameter it is judged: that of its claim, else that with more levels, which is
        h where there is no error in time."""
        if self.claimed is not None:
            return self.claimed.direction
        if self.initial.reference == "finest" or self.initial.stationary:
            return "h"
        return "tau" if len(self.sweep.tau) > len(self.sweep.vertices) else "h"

    @cached_property
    def variables(self) -> tuple[str, ...]:
        """What tables show and verdicts judge: the errors of the solution, and what the claim
        requests with what is shown beside it; that alone, if the claim is about nothing else."""
        claimed = self.claimed.variables if self.claimed is not None else ()
        requested = asked_for(v for v in claimed if QUANTITIES[v].on_request)
        alone = bool(claimed) and all(QUANTITIES[v].on_request for v in claimed)
        return tuple(
            v for v in self._measured if v in requested or not (alone or QUANTITIES[v].on_request)
        )

    @cached_property
    def _measured(self) -> tuple[str, ...]:
        """The quantities whose errors its runs have, or would have if a claim named them."""
        name = self.scheme.name
        return (*measured(self.initial, name, self.law), *requestable(self.initial, name))

    def _also(self) -> tuple[str, ...]:
        """What its runs measure because the claim names it."""
        named = () if self.claimed is None else self.claimed.variables
        return tuple(v for v in named if QUANTITIES[v].measured_apart)

    def _compare_at(self) -> tuple[float, ...]:
        """The given times; for a flow without any, the final one."""
        if self.initial.reference not in COMPARED:
            return ()
        return tuple(sorted(self.sweep.compare_at)) or (self.sweep.final_time,)

    def cases(self) -> list[Case]:
        """The cells of the (h, tau) grid, coarse before fine."""
        return list(self._cases)

    @cached_property
    def _cases(self) -> list[Case]:
        return [
            Case(
                solution=self.solution,
                law=self.law,
                scheme=self.scheme,
                vertices=vertices,
                tau=tau,
                final_time=self.sweep.final_time,
                first_steps=self.sweep.first_steps,
                compare_at=self._compare_at(),
                also=self._also(),
            )
            for vertices, tau in product(
                sorted(self.sweep.vertices), sorted(self.sweep.tau, reverse=True)
            )
        ]


def load_study(path: Path) -> Study:
    """Read and check a study file.

    Raises
    ------
    BadInput
        Naming the file, the key, the value and what is allowed.
    """
    table = read(path)
    with checking(path, Study):
        return Study.model_validate(table)
