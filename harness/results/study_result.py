"""What came out of a study: all that tables, figures, remarks and reports are made from."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from esfem.judging.eoc import rates
from esfem.judging.outcome import Outcome, worst
from esfem.results.selection import exclusions
from esfem.results.verdicts import Verdict, judge
from esfem.studies.claims import Direction
from esfem.studies.quantities import QUANTITIES
from esfem.studies.study import Study
from esfem.studies.words import Words, words

Series = list[tuple[str, pd.DataFrame]]


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
        """The verdict on the study as a whole: the worst of those on what is claimed.

        "not exercised" if nothing that is claimed was, "no claim" if nothing is.
        """
        return worst([v for v in self.verdicts if v.claim])

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
        """By label of each series its table (`level_table`), columns by variable;
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
        judged = [part for v in self.verdicts for part in v.parts]
        ends = [getattr(part, other)[-1] for part in judged if getattr(part, other)]
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


def series(records: pd.DataFrame, parameter: Direction) -> Series:
    """The runs in series along the parameter, coarse to fine, each with its label.

    For h a series a tau, large steps first; for tau a series a mesh, coarse first.
    """
    if parameter == "h":
        taus = sorted(records["tau"].unique(), reverse=True)
        groups = [(f"tau = {t:g}", records[records["tau"] == t]) for t in taus]
    else:
        meshes = sorted(records["vertices"].unique())
        groups = [(f"V = {v}", records[records["vertices"] == v]) for v in meshes]
    return [(label, runs.sort_values(parameter, ascending=False)) for label, runs in groups]


def level_table(
    runs: pd.DataFrame, variables: Sequence[str], parameter: Direction = "h", error: str = "err"
) -> pd.DataFrame:
    """The readable table of one series: levels down, error and EOC of each variable across.

    All entries are strings; the columns are named by variables, "x" and "EOC x". With ``error``
    "nodal" it shows the errors against the interpolation. A column "status" appears if a run
    stopped early.
    """
    columns: dict[str, list[str]] = {
        "h": {
            "vertices": [str(v) for v in runs["vertices"]],
            "N": [str(n) for n in runs["nodes"]],
            "h": [f"{h:.3f}" for h in runs["h"]],
        },
        "tau": {"steps": [str(n) for n in runs["steps"]], "tau": [f"{t:.3g}" for t in runs["tau"]]},
    }[parameter]
    for name in variables:
        value = QUANTITIES[name].value
        if value is not None and error == "err":
            columns[value] = [f"{v:.6g}" if np.isfinite(v) else "-" for v in runs[value]]
        e = runs[f"{error}_{name}"].to_numpy(float)
        columns[name] = [f"{value:.2e}" if np.isfinite(value) else "-" for value in e]
        eoc = rates(runs[parameter], e)
        columns[f"EOC {name}"] = ["", *(f"{r:.2f}" if np.isfinite(r) else "-" for r in eoc)]
    if (runs["status"] != "ok").any():
        columns["status"] = [
            f"{run.status} at t = {run.stopped_at:g}" if np.isfinite(run.stopped_at) else run.status
            for run in runs.itertuples()
        ]
    return pd.DataFrame(columns)
