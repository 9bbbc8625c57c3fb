"""What a judge says of one table."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from esfem.judging.floors import Masked
from esfem.judging.plane import JointFit

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
class Alternative:
    """What the errors may be, with its probability, and the median of the order if they are."""

    name: str
    probability: float
    order: float


@dataclass(frozen=True)
class Judgement:
    """One table, judged.

    ``order`` is the median of the order as the parameter goes to 0, [``lower``, ``upper``] hold it
    with 95 %, and ``probability`` is that of an order of at least ``claimed`` minus the tolerance:
    all of one posterior, which averages over the ``alternatives``, the likeliest first; ``model``
    is its name.  E = ``constant`` s^order fits the levels in ``window``, those that no floor, hole
    or outlier takes away, out of so many ``levels`` that were not masked; ``scatter`` is the
    standard deviation of log E.

    ``claimed`` is the order that was judged: that of the path where h and tau are refined together.
    ``code`` is one word for the ``cause``, which says why there is no better outcome; ``notes`` say
    what was assumed, and ``next_run`` what would settle it.
    """

    outcome: Outcome
    claimed: float
    direction: Literal["h", "tau"]
    order: float = NAN
    lower: float = NAN
    upper: float = NAN
    probability: float = NAN
    constant: float = NAN
    model: str = ""
    alternatives: tuple[Alternative, ...] = ()
    levels: int = 0
    window: tuple[float, ...] = ()
    masked: tuple[Masked, ...] = ()
    code: str = ""
    cause: str = ""
    notes: tuple[str, ...] = ()
    next_run: str = ""
    scatter: float = NAN
    joint: JointFit | None = None
    tolerance: float = 0.2

    @property
    def exit_status(self) -> int:
        """0 good, 1 the claim failed, 3 inconclusive, or nothing was exercised."""
        return EXIT[self.outcome]

    @property
    def certainty(self) -> str:
        """The probability in words: "order at least 1.8 with probability 0.997"."""
        if not self.probability >= 0:
            return ""
        bound = f"{self.claimed - self.tolerance:g}"
        if self.probability >= 0.5:
            return f"order at least {bound} with probability {_probability(self.probability)}"
        return f"order below {bound} with probability {_probability(1.0 - self.probability)}"


def _probability(p: float) -> str:
    """Three digits, and never certain."""
    return f"{p:.3f}" if p < 0.9995 else "above 0.999"


def worst(judgements: Sequence[Judgement]) -> Outcome:
    """The outcome of all together; SUPER meets the bound and is worse than PASS in name only."""
    return max((j.outcome for j in judgements), key=SEVERITY.index)
