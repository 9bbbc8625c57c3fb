"""A study with all that came out of it: what is shown, written and read back."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from harness.study import Study
from harness.verdict import Verdict


@dataclass(frozen=True)
class StudyResult:
    """A study with its records (one row a run), floors (one row a floor and variable) and verdicts
    (one a variable)."""

    study: Study
    folder: Path
    records: pd.DataFrame
    floors: pd.DataFrame
    verdicts: list[Verdict]
