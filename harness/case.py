"""A case: solution, law, scheme, vertices and time step, all that determines a run's numbers."""

from collections.abc import Collection, Iterable
from dataclasses import fields
from inspect import signature
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from reference_solutions import SOLUTIONS, ExactSolution
from solver import LAWS

LARGEST = 1e6  # lengths and curvatures are dimensionless numbers of moderate size


class Section(BaseModel):
    """A table of a study file: unknown keys are errors, values are fixed, types are not bent."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


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
    degree: Annotated[int, Field(ge=1, le=4)]
    bdf: Annotated[int, Field(ge=1, le=5)]
    project: bool
    theta: bool
    start: Literal["exact", "self"] = "exact"
    tolerance: Annotated[float, Field(gt=0, le=1e-2)] = 1e-10


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
        if value != 0 and not 1 / LARGEST <= abs(value) <= LARGEST:
            shown = repr(value)[:20]
            raise ValueError(f"{key} = {shown}: must be of size {1 / LARGEST:g} to {LARGEST:g}")
