"""What a judge says of one table."""

from dataclasses import dataclass
from typing import Literal

from esfem.judging.floors import Masked
from esfem.judging.joint import JointFit
from esfem.judging.models import Model

Outcome = Literal["pass", "super", "suspect", "fail", "inconclusive", "not exercised"]
# From best to worst: the worst of several tables decides.
SEVERITY: tuple[Outcome, ...] = (
    *("not exercised", "pass", "super", "inconclusive", "suspect", "fail"),
)
EXIT: dict[Outcome, int] = {
    "not exercised": 3,
    "pass": 0,
    "super": 0,
    "inconclusive": 3,
    "suspect": 1,
    "fail": 1,
}
NAN = float("nan")


@dataclass(frozen=True)
class Judgement:
    """One table, judged.

    ``order`` is the slope of the pure power over the ``window`` of levels, of constant
    ``constant``, out of so many ``levels`` that were not masked; [``lower``, ``upper``] is the 95 %
    interval that decides: it covers every model within reach of the best.  ``model`` is the one of
    least AICc, ``also`` the hypotheses with fixed exponents that the data do not rule out;
    ``scatter`` is the standard deviation of the residuals of log E.  ``cause`` says why there is no
    better outcome, and ``next_run`` what would settle it.
    """

    outcome: Outcome
    claimed: float
    direction: Literal["h", "tau"]
    order: float = NAN
    lower: float = NAN
    upper: float = NAN
    constant: float = NAN
    model: str = ""
    models: tuple[Model, ...] = ()
    also: tuple[str, ...] = ()
    levels: int = 0
    window: tuple[float, ...] = ()
    masked: tuple[Masked, ...] = ()
    cause: str = ""
    next_run: str = ""
    scatter: float = NAN
    joint: JointFit | None = None

    @property
    def exit_status(self) -> int:
        """0 good, 1 the claim failed, 3 inconclusive, or nothing was exercised."""
        return EXIT[self.outcome]


def worst(judgements: list[Judgement]) -> Outcome:
    """The outcome of all together; SUPER meets the bound and is worse than PASS in name only."""
    return max((j.outcome for j in judgements), key=SEVERITY.index)
