"""Flow files: one surface, one law, one mesh, one time step; what is written, what is checked."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from esfem.common.input import Section, checking, read
from esfem.reference_solutions import SurfaceFlow
from esfem.reference_solutions.surfaces import named_surface
from esfem.schemes.kll import SCHEME, FlowOptions
from esfem.solver import Levels
from esfem.studies.case import About, Law, Positive, TimeStep, TimeSteps
from esfem.studies.words import asked

MOST_FRAMES = 2000
MOST_PICTURES = 60  # beside and below each other in one file
Time = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class StartOptions(Section):
    """[start]: a named surface and its number of vertices, or the file of a triangulation."""

    surface: str | None = None
    vertices: Annotated[int, Field(ge=4)] | None = None
    mesh: str | None = None
    scale: Positive = 1.0

    @model_validator(mode="after")
    def _one_of_both(self) -> "StartOptions":
        if (self.surface is None) == (self.mesh is None):
            raise ValueError("surface, mesh: exactly one of them must be given")
        if (self.surface is None) != (self.vertices is None):
            raise ValueError("vertices: belongs to surface; a mesh brings its own")
        if self.surface is not None and self.scale != 1.0:
            raise ValueError(f"scale = {self.scale!r}: is for a mesh only")
        if self.surface is not None:
            named_surface(self.surface)
        return self


class Steps(TimeSteps):
    """[time]"""

    tau: TimeStep

    @property
    def whole_steps(self) -> int:
        """How many times tau is the final time."""
        return round(self.final_time / self.tau)

    @model_validator(mode="after")
    def _whole_steps(self) -> "Steps":
        self.check_steps(self.tau)
        return self


class Output(Section):
    """[output]: times between the frames of the files, times of the pictures."""

    every: Positive | None = None
    pictures: list[Time] = Field(default_factory=list)


class Checks(Section):
    """[checks]: what the flow is expected to do; nothing is checked that is not named."""

    energy_decreases: bool = False
    ends_at: Literal["sphere", "clifford_torus"] | None = None
    ends_within: Positive = 1e-2
    stationary_from: Positive | None = None
    stationary_within: Positive = 1e-2
    reference: Literal["axisymmetric"] | None = None
    reference_at: list[Positive] = Field(default_factory=list)
    reference_within: Positive = 1e-3


class FlowFile(Section):
    """A whole flow file."""

    flow: About
    start: StartOptions
    law: Law
    scheme: FlowOptions
    time: Steps
    output: Output = Output()
    checks: Checks = Checks()

    @property
    def name(self) -> str:
        """The name, which is also that of its folder of results."""
        return self.flow.name

    @property
    def levels(self) -> Levels:
        """The time levels."""
        time = self.time
        return Levels.started(time.tau, time.whole_steps, self.scheme.bdf, time.first_steps)

    @property
    def solution(self) -> SurfaceFlow:
        """The flow of the named surface, with the reference that it is compared with, if any."""
        assert self.start.surface is not None  # asked of a named surface only
        return SurfaceFlow(self.start.surface, self.checks.reference or "finest")

    @property
    def pictured(self) -> list[int]:
        """The time levels of the pictures: those given, or the first and the last."""
        times = self.output.pictures or [0.0, self.time.final_time]
        return sorted({self.levels.at(t) for t in times})

    @property
    def framed(self) -> list[int]:
        """The time levels that are kept: pictures, every so often, the first and the last, and
        that from which on the surface is expected to be at rest."""
        levels, last, since = self.levels, self.time.whole_steps, self.checks.stationary_from
        stride = last if self.output.every is None else round(self.output.every / self.time.tau)
        regular = (levels.at(n * self.time.tau) for n in range(0, last + 1, stride))
        compared = set() if since is None else {levels.at(since)}
        return sorted({*regular, levels.steps, *self.pictured, *compared})

    @model_validator(mode="after")
    def _times_fit(self) -> "FlowFile":
        final_time, since = self.time.final_time, self.checks.stationary_from
        times: dict[str, Sequence[float | None]] = {
            "[output] every": [self.output.every],
            "[output] pictures": self.output.pictures,
            "[checks] stationary_from": [since],
            "[checks] reference_at": self.checks.reference_at,
        }
        for key, given in times.items():
            for t in given:
                if t is not None:
                    self.time.check_time(key, t, self.time.tau)
        every = self.output.every or final_time
        if final_time / every + len(self.output.pictures) > MOST_FRAMES:
            raise ValueError(f"[output] every: gives more than {MOST_FRAMES} frames")
        if len(self.pictured) > MOST_PICTURES:
            raise ValueError(
                f"[output] pictures: {len(self.pictured)} times, must be {MOST_PICTURES} at most"
            )
        if since is not None and self.levels.at(since) == self.levels.steps:
            raise ValueError(
                f"[checks] stationary_from = {since!r}: must be before final_time = {final_time!r}"
            )
        return self

    @model_validator(mode="after")
    def _scheme_fits(self) -> "FlowFile":
        if self.scheme.bdf > self.time.whole_steps:
            raise ValueError(f"[scheme] bdf = {self.scheme.bdf}: final_time is fewer steps")
        if self.scheme.name != "kll":
            raise ValueError(f"[scheme] name = {self.scheme.name!r}: must be 'kll'")
        if self.law.name not in SCHEME.laws:
            allowed = ", ".join(SCHEME.laws)
            raise ValueError(f"[law] name = {self.law.name!r}: must be one of {allowed}")
        objection = self.scheme.objection(exact_start=False)
        if objection is not None:
            raise ValueError(f"[scheme] {objection}")
        if self.scheme.start == "exact":
            raise ValueError("[scheme] start = 'exact': a flow starts itself, must be 'self'")
        if self.start.mesh is not None and self.scheme.theta:
            raise ValueError("[scheme] theta = True: needs exact data, a mesh gives estimates")
        return self

    @model_validator(mode="after")
    def _reference_fits(self) -> "FlowFile":
        if (self.checks.reference is None) != (not self.checks.reference_at):
            raise ValueError("[checks] reference, reference_at: only both together")
        levels = [round(t / self.time.tau) for t in self.checks.reference_at]
        for t, level in zip(self.checks.reference_at, levels, strict=True):
            if levels.count(level) > 1:
                raise ValueError(f"[checks] reference_at = {t!r}: occurs twice")
        if self.checks.reference is not None:
            if self.start.surface is None:
                raise ValueError("[checks] reference: is for a named surface only")
            _ = self.solution
        return self


def load_flow(path: Path) -> FlowFile:
    """Read and check a flow file.

    Raises
    ------
    BadInput
        Naming the file, the key, the value and what is allowed.
    """
    table = read(path)
    with checking(path, FlowFile):
        return FlowFile.model_validate(table)


def describe_flow(flow: FlowFile, nodes: int) -> str:
    """A flow on so many nodes in one line: start, law, scheme, time step, final time."""
    start, time = flow.start, flow.time
    scaled = f" (scale = {start.scale:g})" if start.scale != 1.0 else ""
    origin = (
        f"mesh {Path(start.mesh).name}{scaled}"
        if start.mesh
        else f"surface {start.surface}, V = {start.vertices}"
    )
    return (
        f"{origin}, N = {nodes}, {asked(flow.law, flow.scheme)}"
        f"{time.said_of_first_steps(flow.scheme.bdf)}, "
        f"tau = {time.tau:g}, T = {time.final_time:g}"
    )
