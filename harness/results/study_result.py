"""What came out of a study: all that tables, figures, remarks and reports are made from."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pandas as pd

from esfem.judging.outcome import Outcome, worst
from esfem.results.selection import exclusions
from esfem.results.series import Series, level_table, series
from esfem.results.verdict import Verdict
from esfem.results.verdicts import judge
from esfem.studies.study import Study
from esfem.studies.words import Words, words


@dataclass(frozen=True)
class StudyResult:
    """A study with its folder, records (one row a run), floors (one row a floor and variable) and
    verdicts (one a variable)."""

    study: Study
    folder: Path
    records: pd.DataFrame
    floors: pd.DataFrame
    verdicts: list[Verdict]

    @cached_property
    def outcome(self) -> Outcome:
        """The verdict on the study as a whole."""
        return worst(self.verdicts)

    @cached_property
    def words(self) -> Words:
        """The study in words."""
        return words(self.study)

    @cached_property
    def recovered(self) -> tuple[str, ...]:
        """The variables that were recovered, not solved for."""
        found = self.study.plugin.recovered
        also = ("W",) if "H" in found else ()
        return tuple(name for name in self.study.variables if name in (*found, *also))

    @cached_property
    def headings(self) -> dict[str, str]:
        """What stands above the errors of each variable: it says what was recovered."""
        return {
            name: f"{name} (recovered)" if name in self.recovered else name
            for name in self.study.variables
        }

    @cached_property
    def series(self) -> Series:
        """The runs in series along the judged parameter."""
        return series(self.records, self.study.direction)

    @cached_property
    def tables(self) -> dict[str, tuple[pd.DataFrame, pd.DataFrame | None]]:
        """By label of each series its table (`results.series.level_table`), columns by variable;
        and that of the errors against the interpolation, None where runs do not measure them."""
        variables, parameter = self.study.variables, self.study.direction
        found = {}
        for label, runs in self.series:
            nodal = [name for name in variables if f"nodal_{name}" in runs]
            found[label] = (
                level_table(runs, variables, parameter),
                level_table(runs, nodal, parameter, "nodal") if nodal else None,
            )
        return found

    @cached_property
    def shown(self) -> str:
        """The label of the series on which most variables were judged, or of the finest one if none
        was."""
        other = {"h": "tau", "tau": "vertices"}[self.study.direction]
        ends = [getattr(v, other)[-1] for v in self.verdicts if getattr(v, other)]
        if not ends:
            return self.series[-1][0]
        most = pd.Series(ends).mode().min()
        return next(label for label, runs in self.series if runs[other].iloc[0] == most)

    @cached_property
    def excluded(self) -> list[str]:
        """What was not judged, by name (`esfem.results.selection.exclusions`)."""
        return exclusions(self.study, self.records)


def judged(study: Study, folder: Path, records: pd.DataFrame, floors: pd.DataFrame) -> StudyResult:
    """The result of a study with these records and floors, judged."""
    return StudyResult(study, folder, records, floors, judge(study, records, floors))
