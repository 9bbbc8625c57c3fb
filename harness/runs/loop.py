"""The one loop over States: of studies, flows, the contest of schemes and the paper's figures."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Literal, TypeVar

from esfem.runs.checkpoint import Keeper
from esfem.solver import Diverged, SolverFailure, State
from esfem.solver.reference_element import Array

Status = Literal["ok", "diverged", "failed"]
STOPS: dict[Status, type[Diverged] | type[SolverFailure]] = {
    "diverged": Diverged,
    "failed": SolverFailure,
}
Item = TypeVar("Item")


@dataclass(frozen=True)
class Ending:
    """How an evolution ended; one that stopped early did so at ``t``, for a ``reason``."""

    status: Status = "ok"
    t: float | None = None
    reason: str = ""

    def __str__(self) -> str:
        return self.status if self.t is None else f"{self.status} at t = {self.t:g}"

    @property
    def told(self) -> str:
        """When and why it stopped early, in words; "" if it did not."""
        return "" if self.t is None else str(STOPS[self.status](self.reason, self.t))


def resumed(
    restore: Callable[[Mapping[str, Array]], None], keeper: Keeper | None
) -> tuple[State, ...]:
    """The States of the checkpoint, if there is one; ``restore`` is given what is kept there."""
    kept = None if keeper is None else keeper.resume()
    if kept is None:
        return ()
    restore(kept.arrays)
    return kept.past


def measured(states: Iterable[Item], watch: Callable[[int, Item], None], first: int = 0) -> Ending:
    """Go through the States as far as they go: divergence and solver failure are results.

    Parameters
    ----------
    states : of an evolution, each alone or with what a caller wants beside it.
    watch : is given the number of each level and its State; what it raises counts likewise.
    first : the level of the first one; not 0 if the evolution goes on from a checkpoint.
    """
    try:
        for n, state in enumerate(states, start=first):
            watch(n, state)
    except (Diverged, SolverFailure) as stop:
        status: Status = "diverged" if isinstance(stop, Diverged) else "failed"
        return Ending(status, stop.t, stop.reason)
    return Ending()
