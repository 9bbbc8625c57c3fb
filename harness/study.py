"""Study files: what to solve, with which scheme, on which (h, tau) grid, and what is claimed."""

import re
import tomllib
from collections.abc import Collection, Iterable
from dataclasses import fields
from inspect import signature
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from harness.bad_input import BadInput
from harness.claims import claims
from harness.schemes import SCHEMES
from reference_solutions import SOLUTIONS, ExactSolution
from solver import LAWS

STUDIES = Path(__file__).with_name("studies")
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Section(BaseModel):
    """A table of a study file: unknown keys are errors, values are fixed, types are not bent."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class About(Section):
    """[study]"""

    name: str
    title: str
    claim: str | None = None

    @field_validator("name")
    @classmethod
    def _names_a_folder(cls, name: str) -> str:
        if not re.fullmatch(r"[a-z0-9][a-z0-9-]*", name):
            raise ValueError(
                f"name = {name!r}: must consist of a-z, 0-9 and -, for it names a folder"
            )
        return name

    @field_validator("claim")
    @classmethod
    def _known(cls, claim: str | None) -> str | None:
        return claim if claim is None else one_of("claim", claim, claims())


class Named(BaseModel):
    """A table with a name and numeric parameters that depend on the name."""

    model_config = ConfigDict(extra="allow", frozen=True, strict=True)

    name: str

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters given beside the name."""
        return dict(self.__pydantic_extra__ or {})


class Solution(Named):
    """[solution]"""

    @model_validator(mode="after")
    def _known(self) -> "Solution":
        solution = SOLUTIONS[one_of("name", self.name, SOLUTIONS)]
        known_parameters(
            f"solution '{self.name}'", self.parameters, [f.name for f in fields(solution)]
        )
        self.exact()
        return self

    def exact(self) -> ExactSolution:
        """The exact solution with these parameters."""
        return SOLUTIONS[self.name](**self.parameters)


class Law(Named):
    """[law]"""

    @model_validator(mode="after")
    def _known(self) -> "Law":
        law = LAWS[one_of("name", self.name, LAWS)]
        # A law is called with H, S2, x, t and then its own parameters.
        allowed = list(signature(law).parameters)[4:]
        known_parameters(f"law '{self.name}'", self.parameters, allowed)
        for key in allowed:
            if key not in self.parameters:
                raise ValueError(f"{key}: is missing; law '{self.name}' needs it")
        return self


class SchemeOptions(Section):
    """[scheme]"""

    name: str = "kll"
    degree: Literal[1, 2, 3, 4]
    bdf: Literal[1, 2, 3, 4, 5]
    project: bool
    theta: bool
    tolerance: Annotated[float, Field(gt=0, le=1e-2)] = 1e-10

    @field_validator("name")
    @classmethod
    def _known(cls, name: str) -> str:
        return one_of("name", name, SCHEMES)


class Sweep(Section):
    """[sweep]"""

    vertices: list[Annotated[int, Field(ge=4)]] = Field(min_length=1)
    tau: list[Positive] = Field(min_length=1)
    final_time: Positive

    @field_validator("vertices", "tau")
    @classmethod
    def _distinct(cls, values: list[Any], info: ValidationInfo) -> list[Any]:
        for value in values:
            if values.count(value) > 1:
                raise ValueError(f"{info.field_name} = {values!r}: {value!r} occurs twice")
        return values

    @model_validator(mode="after")
    def _whole_steps(self) -> "Sweep":
        for tau in self.tau:
            steps = self.final_time / tau
            if round(steps) < 1 or abs(steps - round(steps)) > 1e-9 * steps:
                raise ValueError(
                    f"final_time = {self.final_time!r} must be a whole multiple of tau = {tau!r}"
                )
        return self


class Case(BaseModel):
    """One cell of a sweep: all that determines its numbers, mesh and program aside."""

    model_config = ConfigDict(frozen=True)

    solution: Solution
    law: Law
    scheme: SchemeOptions
    vertices: int
    tau: float
    final_time: float

    @property
    def steps(self) -> int:
        """Number of time steps."""
        return round(self.final_time / self.tau)

    @property
    def label(self) -> str:
        """For a line of progress."""
        return f"V={self.vertices} tau={self.tau:g}"


class Study(Section):
    """A whole study file."""

    study: About
    solution: Solution
    law: Law
    scheme: SchemeOptions
    sweep: Sweep

    @model_validator(mode="after")
    def _fit_together(self) -> "Study":
        law = SOLUTIONS[self.solution.name].law
        if self.law.name != law:
            raise ValueError(
                f"[law] name = {self.law.name!r}: solution '{self.solution.name}' solves '{law}'"
            )
        if self.scheme.bdf > min(round(self.sweep.final_time / tau) for tau in self.sweep.tau):
            raise ValueError(
                f"[scheme] bdf = {self.scheme.bdf}: final_time must be at least bdf times tau"
            )
        if self.study.claim is not None:
            objection = claims()[self.study.claim].objection(self.scheme.degree, self.scheme.theta)
            if objection:
                raise ValueError(f"[study] claim = {self.study.claim!r}: {objection}")
        return self

    @property
    def name(self) -> str:
        """The name, which is also that of its folder of results."""
        return self.study.name

    def cases(self) -> list[Case]:
        """The cells of the (h, tau) grid, coarse before fine."""
        return [
            Case(
                solution=self.solution,
                law=self.law,
                scheme=self.scheme,
                vertices=vertices,
                tau=tau,
                final_time=self.sweep.final_time,
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
    try:
        table = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise BadInput(
            f"{path}: is not UTF-8 text: {error.reason} at byte {error.start}"
        ) from error
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"{path}: is not valid TOML: {error}") from error
    try:
        return Study.model_validate(table)
    except ValidationError as error:
        raise BadInput("; ".join(f"{path}: {_explain(e)}" for e in error.errors())) from error


def _explain(error: dict[str, Any]) -> str:
    """One line for one finding of pydantic: key, value, bound."""
    where = error["loc"]
    section = f"[{where[0]}] " if where else ""
    key = "".join(f"[{part}]" if isinstance(part, int) else part for part in where[1:])
    match error["type"]:
        case "extra_forbidden":
            model = {"study": About, "scheme": SchemeOptions, "sweep": Sweep}.get(where[0], Study)
            names = Study.model_fields if len(where) == 1 else model.model_fields
            return f"{section}{key}: unknown key; must be one of {', '.join(names)}".replace(
                " :", ":"
            )
        case "missing":
            return f"{section}{key}: is missing".replace(" :", ":")
        case "value_error":
            return f"{section}{error['ctx']['error']}"
        case _:
            return (
                f"{section}{key} = {error['input']!r}: {error['msg'][0].lower()}{error['msg'][1:]}"
            )


def one_of(key: str, value: str, allowed: Iterable[str]) -> str:
    """The value if it is allowed; ValueError that lists what is."""
    if value not in allowed:
        raise ValueError(f"{key} = {value!r}: must be one of {', '.join(allowed)}")
    return value


def known_parameters(of: str, given: dict[str, Any], allowed: Collection[str]) -> None:
    """ValueError unless all given keys are allowed for ``of`` and all values are numbers."""
    for key, value in given.items():
        if key not in allowed:
            raise ValueError(
                f"{key}: unknown key; {of} takes {', '.join(allowed) or 'no parameter'}"
            )
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"{key} = {value!r}: must be a number")
