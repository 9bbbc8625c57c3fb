"""What a change against the baseline is: its effect, and the exit status of a check."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import isnan
from typing import Literal

import pandas as pd

from esfem.results.result_files import StoredResult

Effect = Literal["same", "better", "unknown", "worse"]

# From best to worst, with the exit status; "unknown" is what could not be compared.
EXIT: dict[Effect, int] = {"same": 0, "better": 0, "unknown": 3, "worse": 1}

What = Literal[
    # of a variable
    "verdict", "claim", "order", "errors", "one error", "constant",
    # of a study
    "run", "cell", "case", "results", "code",
]  # fmt: skip


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

    ``place`` is the cell or the parameter that the values belong to, "" if they are of no one;
    ``by`` the difference of orders, or the factor between errors, and ``tolerance`` what it was
    held against (a factor for errors), NaN where there is no number; ``since`` the version and
    numerics digest of the baseline.
    """

    what: What
    baseline: str
    current: str
    effect: Effect = "unknown"
    place: str = ""
    by: float = float("nan")
    tolerance: float = float("nan")
    variable: str = ""
    study: str = ""
    since: str = ""

    @property
    def moved(self) -> bool:
        """Whether it is not the same within the tolerance."""
        return self.effect != "same"

    @property
    def said(self) -> str:
        """Both values, and where."""
        values = f"{self.baseline} -> {self.current}"
        return f"{self.place}: {values}" if self.place else values

    @property
    def amount(self) -> str:
        """By how much, against which tolerance, in words."""
        if isnan(self.by):
            return ""
        if self.what == "order":
            return f"{self.by:+.3f} (tolerance {self.tolerance:.3f})"
        return f"times {self.by:.3g} (tolerance {self.tolerance:.3g})"


def exit_status(changes: Iterable[Change], strict: bool = False) -> int:
    """0 nothing worse, 1 something worse (``strict``: anything moved), 3 not comparable."""
    effects = {change.effect for change in changes}
    if strict and effects & {"better", "worse"}:
        return 1
    return EXIT[max(effects, key=list(EXIT).index, default="same")]
