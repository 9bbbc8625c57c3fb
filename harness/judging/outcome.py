"""The outcome of a study as a whole, of a flow, of a sentence: from verdicts to an exit status."""

from collections.abc import Iterable
from typing import Literal, Protocol

from esfem.judging.judgement import EXIT as JUDGED_EXIT
from esfem.judging.judgement import SEVERITY as JUDGED

Outcome = Literal["pass", "super", "fail", "suspect", "inconclusive", "not exercised", "no claim"]

# From best to worst for a study as a whole: what was not exercised or claimed does not decide.
SEVERITY: tuple[Outcome, ...] = ("no claim", *JUDGED)

EXIT: dict[Outcome, int] = {o: 0 if o == "no claim" else JUDGED_EXIT[o] for o in SEVERITY}


class Judged(Protocol):
    """What has a verdict: a variable of a study, a check of a flow."""

    @property
    def verdict(self) -> Outcome: ...


def worst(verdicts: Iterable[Judged]) -> Outcome:
    """The verdict on all together; "no claim" if there are none."""
    return max((v.verdict for v in verdicts), key=SEVERITY.index, default="no claim")


def exit_status(outcomes: Iterable[Outcome]) -> int:
    """Of a command with these results: 1 if a claim failed, else 3 if one is inconclusive, or
    nothing of it was exercised, else 0."""
    statuses = {EXIT[outcome] for outcome in outcomes}
    return next((status for status in (1, 3) if status in statuses), 0)
