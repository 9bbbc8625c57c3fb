"""Sham schemes: what one that does nothing, or half of it, or is late, gets in the order studies.

Each takes the place of a scheme through the plug-in interface, and hands out States that look like
its own. The studies then judge it as they judge anybody's.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

from esfem.runs.stepping import levels as stepped
from esfem.schemes import DEFAULT_SCHEME, Plugin, Problem, Run, named_scheme
from esfem.solver import Levels, State
from esfem.studies.quantities import QUANTITIES
from esfem.studies.study import Study


@dataclass(frozen=True)
class Sham:
    """A sham of schemes.

    Attributes
    ----------
    name, what : in a word and in a line.
    of : the States that it makes of a scheme.
    caught : the outcomes with which the study must end if it is judged by it at all.
    tries : whether the study is one that must catch it.
    """

    name: str
    what: str
    of: Callable[[Plugin], Run]
    caught: tuple[str, ...]
    tries: Callable[[Study], bool]


def states_of(scheme: Plugin, problem: Problem, levels: Levels) -> Iterator[State]:
    """The States of a problem by a scheme, whether it has a loop of its own or a step."""
    if scheme.run is not None:
        return scheme.run(problem, levels, ())
    return (state for state, _ in stepped(scheme, problem, levels))


def does_nothing(scheme: Plugin) -> Run:
    """The initial State for ever."""

    def run(problem: Problem, levels: Levels, past: Sequence[State]) -> Iterator[State]:
        for n in range(levels.steps + 1):
            yield replace(problem.initial, t=levels.t(n))

    return run


def at_half_speed(scheme: Plugin) -> Run:
    """At time t the State of t/2, with half of its velocity: x' = v/2 to the last digit."""

    def run(problem: Problem, levels: Levels, past: Sequence[State]) -> Iterator[State]:
        slow = replace(levels, tau=levels.tau / 2.0, t_0=levels.t_0 / 2.0)
        own = states_of(scheme, replace(problem, tau=problem.tau / 2.0), slow)
        for n, state in enumerate(own):
            yield replace(state, t=levels.t(n), V=state.V / 2.0, own_v=state.v / 2.0)

    return run


def late(scheme: Plugin) -> Run:
    """Every State one step old."""

    def run(problem: Problem, levels: Levels, past: Sequence[State]) -> Iterator[State]:
        before = problem.initial
        for state in states_of(scheme, problem, levels):
            yield replace(before, t=state.t)
            before = state

    return run


@contextmanager
def planted(sham: Sham, scheme: str = DEFAULT_SCHEME) -> Iterator[None]:
    """The sham in place of the scheme of that name, until the end of the block."""
    module: Any = import_module(f"esfem.schemes.{scheme.replace('-', '_')}")
    honest: Plugin = module.SCHEME
    made = sham.of(honest)
    try:
        module.SCHEME = replace(honest, run=made, step=None, energy=None)
        named_scheme.cache_clear()
        yield
    finally:
        module.SCHEME = honest
        named_scheme.cache_clear()


def claims_order(study: Study) -> bool:
    """Whether an order is claimed."""
    return study.claimed is not None and study.claimed.order is not None


def moves(study: Study) -> bool:
    """Whether it is an order study in h of what a scheme makes of an exact solution that moves.

    Exact States alone, of which defects are, come from no scheme.
    """
    exact = study.initial.always_exact and not study.initial.stationary
    return claims_order(study) and study.direction == "h" and exact and of_steps(study)


def of_steps(study: Study) -> bool:
    """Whether something that is claimed depends on the steps of the scheme."""
    claimed = study.claimed.variables if study.claimed is not None else ()
    return any(QUANTITIES[name].in_time for name in claimed)


def of_higher_order_in_time(study: Study) -> bool:
    """Whether it is an order study in tau of a method of order two at least."""
    return claims_order(study) and study.direction == "tau" and study.scheme.order >= 2


NOT_GREEN = ("fail", "suspect", "inconclusive", "not exercised")
SHAMS = (
    Sham("do-nothing", "the initial State for ever", does_nothing, NOT_GREEN, claims_order),
    Sham("half-speed", "v halved", at_half_speed, ("fail", "suspect"), moves),
    Sham("late", "every State one step old", late, ("fail", "suspect"), of_higher_order_in_time),
)
