"""Kovacs, Li, Lubich: evolution equations for nu and H, linearly implicit BDF."""

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from esfem.schemes import OFFERS, BDFOptions, Plugin, Problem
from esfem.solver import BDF, LAWS, Levels, Scheme, State, evolve
from esfem.solver.laws import AnyLaw

DEFAULT_TOLERANCE = 1e-10


def _projection(value: Any) -> Any:
    if not isinstance(value, bool) and value != "nu":
        raise ValueError(f"project = {value!r}: must be a boolean, true or false, or 'nu'")
    return value


class KLLOptions(BDFOptions):
    """[scheme] of kll."""

    name: str = "kll"
    project: Annotated[bool | Literal["nu"], BeforeValidator(_projection)]  # "nu": not z
    theta: bool
    tolerance: Annotated[float, Field(gt=0, le=1e-2)] = DEFAULT_TOLERANCE
    velocity: Literal["interpolated", "ritz"] = "interpolated"
    reaction: Literal["implicit", "extrapolated", "linearised"] = "implicit"

    @cached_property
    def solved_to(self) -> float:
        """``tolerance``."""
        return self.tolerance

    def iterates(self, exact_start: bool) -> bool:
        """Not if the reaction is extrapolated, which is one direct solve; but the steps by which a
        multistep method starts itself do."""
        return self.reaction != "extrapolated" or (self.bdf > 1 and not exact_start)

    def objection(self, exact_start: bool) -> str | None:
        """A tolerance although nothing iterates."""
        if self.iterates(exact_start) or self.tolerance == DEFAULT_TOLERANCE:
            return None
        return (
            f"tolerance = {self.tolerance!r}: has no effect, as steps with reaction = "
            "'extrapolated' are direct solves; leave it out"
        )


class FlowOptions(KLLOptions):
    """[scheme] of the flows that are watched: they start far from rest and take large steps."""

    reaction: Literal["implicit", "extrapolated", "linearised"] = "linearised"


def scheme_of(options: KLLOptions, law: AnyLaw) -> Scheme:
    """The scheme of the solver that the options ask for: the one way there, of studies and flows.

    Parameters
    ----------
    options : the table [scheme] of a study file or a flow file; its degree is that of the mesh,
        and its start is where the first levels come from, which `esfem.solver.evolve` is told.
    law : Q of the velocity law V = Lap H + Q, forcing included.
    """
    return Scheme(
        bdf=BDF.of_order(options.bdf),
        law=law,
        project=options.project,
        theta=options.theta,
        tolerance=options.tolerance,
        quadrature_degree=options.quadrature,
        velocity=options.velocity,
        reaction=options.reaction,
    )


def run(problem: Problem, levels: Levels, past: Sequence[State] = ()) -> Iterator[State]:
    """The States of a problem by `esfem.solver.evolve`."""
    assert isinstance(problem.options, KLLOptions) and problem.law is not None
    scheme = scheme_of(problem.options, problem.law)
    return evolve(problem.mesh, problem.initial, scheme, levels, problem.exact, past=past)


SCHEME = Plugin(
    title="Kovacs, Li, Lubich: Willmore flow by evolution equations for nu and H",
    laws=tuple(LAWS),
    offers=OFFERS,
    options=KLLOptions,
    substeps=True,
    run=run,
)
