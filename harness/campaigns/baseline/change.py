"""What a comparison is made of, and what it says."""

from dataclasses import dataclass
from math import isnan
from typing import Literal

import pandas as pd

from esfem.results.result_files import StoredResult

Effect = Literal["same", "better", "unknown", "worse"]
# From best to worst; "unknown" is what could not be compared.
SEVERITY: tuple[Effect, ...] = ("same", "better", "unknown", "worse")
EXIT: dict[Effect, int] = {"same": 0, "better": 0, "unknown": 3, "worse": 1}
NAN = float("nan")

What = Literal[
    *("verdict", "claim", "order", "errors", "one error", "constant"),  # of a variable
    *("run", "cell", "case", "results", "code"),  # of a study
]


@dataclass(frozen=True)
class Stored:
    """Results of one study: ``content`` of verdicts.json and the table of records.csv.

    ``why`` is the reason that the history gives for a baseline, "" without one.
    """

    content: StoredResult
    records: pd.DataFrame
    why: str = ""

    @property
    def study(self) -> str:
        """The name of the study."""
        return self.content.study

    @property
    def since(self) -> str:
        """Which program made it, and why it is a baseline."""
        reason = f": {self.why}" if self.why else ""
        return f"{self.content.version} (numerics {self.content.numerics}){reason}"


@dataclass(frozen=True)
class Change:
    """One comparison of one variable of a study; ``variable`` is "" where it is of the whole study.

    ``by`` is the difference of orders, or the factor between errors, and ``tolerance`` what it was
    held against (a factor for errors); NaN where there is no number.  ``baseline`` and ``current``
    are shown as they are; ``since`` is the version and numerics digest of the baseline.
    """

    what: What
    baseline: str
    current: str
    effect: Effect = "unknown"
    variable: str = ""
    study: str = ""
    since: str = ""
    by: float = NAN
    tolerance: float = NAN

    @property
    def moved(self) -> bool:
        """Whether it is not the same within the tolerance."""
        return self.effect != "same"

    @property
    def amount(self) -> str:
        """By how much, against which tolerance, in words."""
        if isnan(self.by):
            return ""
        if self.what == "order":
            return f"{self.by:+.3f} (tolerance {self.tolerance:.3f})"
        return f"times {self.by:.3g} (tolerance {self.tolerance:.3g})"


def worst(changes: list[Change]) -> Effect:
    """The effect of all together; of none "same"."""
    return max((change.effect for change in changes), key=SEVERITY.index, default="same")


def exit_status(changes: list[Change], strict: bool = False) -> int:
    """0 nothing worse, 1 something worse (``strict``: anything moved), 3 not comparable."""
    if strict and any(change.effect in ("better", "worse") for change in changes):
        return 1
    return EXIT[worst(changes)]
