"""A case: solution, law, scheme, vertices and time step, all that determines a run's numbers."""

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields
from functools import cached_property
from typing import Annotated, Any, Protocol

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    SerializeAsAny,
    ValidationError,
    model_validator,
)

from esfem.common.input import Fixed, FolderName, Section, Title, explain
from esfem.reference_solutions import STARTS, InitialSurface
from esfem.schemes import (
    ALL_LAWS,
    DEFAULT_SCHEME,
    Plugin,
    SchemeOptions,
    named_scheme,
    scheme_names,
)
from esfem.solver import Levels
from esfem.solver.laws import Energy, VelocityLaw, energy_of

LARGEST = 1e6  # lengths and curvatures are dimensionless numbers of moderate size


def one_of(key: str, value: str, allowed: Iterable[str]) -> str:
    """The value if it is allowed; ValueError that lists what is."""
    if value not in allowed:
        raise ValueError(f"{key} = {value!r}: must be one of {', '.join(allowed)}")
    return value


class Named(Fixed):
    """A table with a name and parameters, numbers or words, that depend on the name."""

    model_config = ConfigDict(extra="allow", frozen=True, strict=True)

    name: str

    @property
    def parameters(self) -> dict[str, Any]:
        """The parameters given beside the name."""
        return dict(self.__pydantic_extra__ or {})


class About(Section):
    """What a file is about: its name, which is also that of its folder of results, and a title."""

    name: FolderName
    title: Title


class Solution(Named):
    """[solution]"""

    @model_validator(mode="after")
    def _known(self) -> "Solution":
        solution = STARTS[one_of("name", self.name, STARTS)]
        takes, given = fields(solution), self.parameters
        centre = given.pop("centre", None)
        own = [f for f in takes if f.name != "centre"]
        known_parameters(
            f"solution '{self.name}'",
            given,
            {f.name: f.type for f in own},
            {f.name: f.metadata["power"] for f in own if "power" in f.metadata},
        )
        for f in own:
            if f.default is MISSING and f.name not in given:
                raise ValueError(f"{f.name}: is missing; solution '{self.name}' needs it")
        check_centre(centre, STARTS[self.name](**given).scale)
        return self

    def initial(self) -> InitialSurface:
        """The exact solution, or the surface to start from, with these parameters."""
        return STARTS[self.name](**self.parameters)


class Law(Named):
    """[law]"""

    @model_validator(mode="after")
    def _known(self) -> "Law":
        law = ALL_LAWS[one_of("name", self.name, ALL_LAWS)]
        allowed = law.parameters if isinstance(law, VelocityLaw) else ()
        known_parameters(f"law '{self.name}'", self.parameters, dict.fromkeys(allowed, float))
        for key in allowed:
            if key not in self.parameters:
                raise ValueError(f"{key}: is missing; law '{self.name}' needs it")
        return self

    @cached_property
    def energy(self) -> Energy:
        """What the flow decreases where nothing forces it."""
        return energy_of(self.name, **self.parameters)


def _of_the_named_scheme(given: Any) -> Any:
    """The options in the class of the scheme that is named; ValueError with all findings."""
    if not isinstance(given, dict):
        return given
    name = one_of("name", given.get("name", DEFAULT_SCHEME), scheme_names())
    options = named_scheme(name).options
    try:
        return options.model_validate({"name": name, **given})
    except ValidationError as error:
        found = (explain(e, options) for e in error.errors())
        raise ValueError("; ".join(found)) from error


LEAST_STEP = 1e-30  # a length of 1e-6, the least that is allowed, has times of 1e-24


def _not_lost(tau: float) -> float:
    if tau < LEAST_STEP:
        raise ValueError(f"tau = {tau!r}: must be at least {LEAST_STEP:g}")
    return tau


TimeStep = Annotated[float, Field(gt=0, allow_inf_nan=False), AfterValidator(_not_lost)]


class FirstSteps(Fixed):
    """``first_steps``: each of the first q steps, of BDF q, is made of so many substeps."""

    first_steps: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 1

    def said_of_first_steps(self, order: int) -> str:
        """In words, to follow a scheme of that order; "" if its first steps are whole."""
        if self.first_steps == 1:
            return ""
        which = "first step" if order == 1 else f"each of the first {order} steps"
        return f", {which} in {self.first_steps} substeps"


Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
MOST_STEPS = 10_000_000


class TimeSteps(FirstSteps, Section):
    """What the [sweep] of a study and the [time] of a flow share: whole steps to the final time."""

    final_time: Positive

    def check_steps(self, tau: float) -> None:
        """ValueError unless so many whole steps lead to the final time, and not too many."""
        if not self.final_time / tau <= MOST_STEPS:
            raise ValueError(
                f"tau = {tau!r}: final_time / tau must be at most {MOST_STEPS:,} steps"
            )
        if round(self.final_time / tau) < 1 or not _is_multiple(self.final_time, tau):
            raise ValueError(
                f"final_time = {self.final_time!r}: must be a whole multiple of tau = {tau!r}"
            )

    def check_time(self, key: str, t: float, tau: float) -> None:
        """ValueError unless whole steps lead to t, which lies before the final time or is it."""
        if not t <= self.final_time or not _is_multiple(t, tau):
            raise ValueError(
                f"{key} = {t!r}: must be a whole multiple of tau = {tau!r}, "
                f"and final_time = {self.final_time!r} at most"
            )


def _is_multiple(t: float, tau: float) -> bool:
    """Whether t / tau is a whole number, to rounding."""
    return abs(t / tau - round(t / tau)) <= 1e-9 * t / tau


AnyScheme = Annotated[SerializeAsAny[SchemeOptions], BeforeValidator(_of_the_named_scheme)]


class Setup(Protocol):
    """What is solved and how: a `Case`, or a `esfem.studies.study.Study`."""

    @property
    def solution(self) -> Solution: ...

    @property
    def law(self) -> Law: ...

    @property
    def scheme(self) -> SchemeOptions: ...

    @property
    def initial(self) -> InitialSurface: ...

    @property
    def forced(self) -> bool: ...


class Derived:
    """What follows from the tables of a `Setup`, derived once."""

    @cached_property
    def initial(self: Setup) -> InitialSurface:
        """The exact solution, or the surface to start from."""
        return self.solution.initial()

    @cached_property
    def plugin(self: Setup) -> Plugin:
        """The scheme."""
        return named_scheme(self.scheme.name)

    @cached_property
    def forced(self: Setup) -> bool:
        """Whether the law is forced, so that its energy need not decrease."""
        return self.initial.forcing(self.law.name, self.law.parameters) is not None


class Case(Derived, FirstSteps):
    """One cell of a sweep: all that determines its numbers, mesh and program aside."""

    solution: Solution
    law: Law
    scheme: AnyScheme
    vertices: int
    tau: float
    final_time: float
    compare_at: tuple[float, ...] = ()  # times of comparison with a reference that is no function
    disturbance: float = 0.0  # of the start values, relative, to measure rounding
    also: tuple[str, ...] = ()  # quantities measured because the claim of the study names them

    @cached_property
    def levels(self) -> Levels:
        """The time levels."""
        whole = round(self.final_time / self.tau)
        return Levels.started(self.tau, whole, self.scheme.order, self.first_steps)

    @property
    def steps(self) -> int:
        """Number of time steps, all substeps counted."""
        return self.levels.steps

    @property
    def label(self) -> str:
        """For a line of progress."""
        return f"V={self.vertices} tau={self.tau:g}"

    @cached_property
    def iterates(self) -> bool:
        """Whether some step iterates, so that its tolerance is part of the error."""
        return self.scheme.iterates(self.exact_start)

    @cached_property
    def exact_start(self) -> bool:
        """Whether the first levels of a multistep method are exact, not computed."""
        return self.initial.always_exact and self.scheme.first_levels != "self"


def law_statement(name: str) -> str:
    """What a law is, in one line."""
    law = ALL_LAWS[name]
    formula = law.Q if isinstance(law, VelocityLaw) else law
    return (formula.__doc__ or "").partition("\n")[0]


def check_centre(centre: Any, size: float) -> None:
    """ValueError unless it is None, or three numbers that do not take a surface too far away."""
    if centre is None:
        return
    numbers = centre if isinstance(centre, list | tuple) else ()
    if len(numbers) != 3 or any(
        isinstance(x, bool) or not isinstance(x, int | float) for x in numbers
    ):
        raise ValueError(f"centre = {centre!r}: must be three numbers, [x, y, z]")
    if not all(abs(x) <= LARGEST * size for x in numbers):
        raise ValueError(
            f"centre = {centre!r}: each must be {LARGEST * size:g} at most in size, "
            f"{LARGEST:g} times that of the surface"
        )


def known_parameters(
    of: str, given: dict[str, Any], allowed: dict[str, Any], powers: Mapping[str, int] | None = None
) -> None:
    """ValueError unless all given keys are allowed for ``of``, and all values of their type and not
    out of the range of lengths, or of the ``powers`` of lengths that they are."""
    for key, value in given.items():
        if key not in allowed:
            raise ValueError(
                f"{key}: unknown key; {of} takes {', '.join(allowed) or 'no parameter'}"
            )
        if allowed[key] is str:
            if not isinstance(value, str):
                raise ValueError(f"{key} = {value!r}: must be a word in quotes")
            continue
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"{key} = {value!r}: must be a number")
        largest = LARGEST ** (powers or {}).get(key, 1)
        if value != 0 and not 1 / largest <= abs(value) <= largest:
            shown = repr(value)[:20]
            raise ValueError(f"{key} = {shown}: must be of size {1 / largest:g} to {largest:g}")
