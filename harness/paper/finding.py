"""What a check of a sentence finds."""

from dataclasses import dataclass

from harness.verdict import SEVERITY, Outcome


@dataclass(frozen=True)
class Finding:
    """``measured`` and ``expected`` in words and numbers, the verdict, and what must be known to
    read it."""

    measured: str
    expected: str
    verdict: Outcome
    note: str = ""


def held(holds: bool) -> Outcome:
    """The verdict on something that holds, or does not."""
    return "pass" if holds else "fail"


def joined(verdicts: list[Outcome]) -> Outcome:
    """The worst of them: what was not claimed, or not exercised, does not decide."""
    return max(verdicts, key=SEVERITY.index)
