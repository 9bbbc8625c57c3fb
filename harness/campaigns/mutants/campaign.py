"""The studies of `coarse.toml` for the program as it is and for each mutant, in memory.

A mutant is caught if a verdict that is good for the program is not good for the mutant, or if what
the program exercises the mutant does not.
"""

import tomllib
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd

from esfem.campaigns.mutants.mutant import Mutant, applied
from esfem.meshes import surface_mesh
from esfem.results.records import floors_table, record_row
from esfem.results.verdicts import Verdict, judge
from esfem.runs.run_case import run_case
from esfem.studies.case import Case
from esfem.studies.study import STUDIES, Study, load_study
from esfem.studies.variations import floor_cases

MET = ("pass", "super")
GOOD = (*MET, "not exercised")
FAILED = ("fail", "suspect")
CRASH = "crash"

Key = tuple[str, str]  # study and variable


@dataclass(frozen=True)
class Coarse:
    """A default study with another sweep; what is None stays as it is there.

    Where the study has times of comparison, the final time is the only one.
    """

    name: str
    vertices: list[int] | None = None
    tau: list[float] | None = None
    final_time: float | None = None

    def study(self) -> Study:
        """The study, checked like any other."""
        study = load_study(STUDIES / f"{self.name}.toml")
        sweep = study.sweep.model_dump()
        for key in ("vertices", "tau"):
            sweep[key] = getattr(self, key) or list(sweep[key])
        if self.final_time is not None:
            sweep["final_time"] = self.final_time
            sweep["compare_at"] = [self.final_time] if sweep["compare_at"] else []
        return Study.model_validate({**study.model_dump(), "sweep": sweep})


_TOLD = tomllib.loads(Path(__file__).with_name("coarse.toml").read_text(encoding="utf-8"))
SET = tuple(Coarse(**told) for told in _TOLD["study"])
FIRST: dict[str, str] = _TOLD["first"]  # the study that a group of mutants is tried by first


def coarse_studies(names: Sequence[str] = ()) -> tuple[Study, ...]:
    """The studies of the set, or those of these names, in the order in which they are tried."""
    return tuple(coarse.study() for coarse in SET if not names or coarse.name in names)


@dataclass(frozen=True)
class Tried:
    """A study of the set.

    ``floors`` were measured for the program as it is and serve all mutants: a floor is a property
    of machine and method, and a mutant is not to hide behind one of its own.
    """

    study: Study
    floors: pd.DataFrame


@dataclass(frozen=True)
class Seen:
    """What a study says of a variable: the outcome, the order expected (NaN if a bound is claimed)
    and observed, why, and the error that decides of the finest completed run, NaN without one."""

    outcome: str
    expected: float
    observed: float
    reason: str
    error: float


@dataclass(frozen=True)
class Catch:
    """A verdict that was good and is no more; ``outcome`` is "crash" if there is none at all."""

    study: str
    variable: str
    outcome: str
    observed: float
    reason: str


@dataclass(frozen=True)
class Trial:
    """A mutant, tried.

    ``change`` is the largest relative change of an error of the finest runs, NaN if none was
    compared; ``where`` its study and variable.
    """

    mutant: Mutant
    catches: tuple[Catch, ...]
    change: float
    where: str
    seconds: float

    @property
    def result(self) -> str:
        """ "FAIL", "not green", "equivalent" or "survived"."""
        if any(catch.outcome in FAILED for catch in self.catches):
            return "FAIL"
        if self.catches:
            return "not green"
        return "equivalent" if self.mutant.equivalent else "survived"

    @property
    def best(self) -> Catch | None:
        """The catch that is shown: a failure rather than another."""
        return min(self.catches, key=lambda c: c.outcome not in FAILED, default=None)


def prepared(study: Study) -> tuple[Tried, dict[Key, Seen]]:
    """The study with its floors, and its verdicts, for the program as it is."""
    runs = computed(study)
    varied = {name: row(study, case) for name, case in floor_cases(study).items()}
    tried = Tried(study, floors_table(study, runs, varied))
    return tried, verdicts(tried, runs)


def computed(study: Study) -> pd.DataFrame:
    """All runs of a study, computed here and now and stored nowhere.

    Of a copy: what the study has derived was derived without the edit that is tried.
    """
    copy = study.model_copy()
    return pd.DataFrame([row(copy, case) for case in copy.cases()])


def row(study: Study, case: Case) -> dict[str, Any]:
    """The line of a run."""
    surface = surface_mesh(study.initial.mesh_surface, case.vertices)
    record, _ = run_case(case, surface)
    return record_row(study.name, case.label, record, study.claimed_length)


def verdicts(tried: Tried, runs: pd.DataFrame) -> dict[Key, Seen]:
    """The verdicts of a study on what is claimed."""
    study = tried.study.model_copy()
    finished = runs[runs["status"] == "ok"].sort_values(["h", "tau"])
    stopped = "; ".join(f"{n} runs {s}" for s, n in runs["status"].value_counts().items())
    note = "" if len(finished) == len(runs) else f" ({stopped})"

    def one(verdict: Verdict) -> Seen:
        column = verdict.deciding.column(verdict.variable)
        error = float(finished[column].iloc[0]) if len(finished) else float("nan")
        return Seen(
            verdict.verdict, verdict.expected, verdict.observed, verdict.reason + note, error
        )

    claimed = study.claimed.variables if study.claimed else ()
    found = judge(study, runs, tried.floors)
    return {(study.name, v.variable): one(v) for v in found if v.variable in claimed}


def attempt(
    mutant: Mutant, tried: Sequence[Tried], expected: Mapping[Key, Seen], every: bool = False
) -> Trial:
    """Run the studies with a mutant until one fails; with ``every``, all of them."""
    started = perf_counter()
    catches: list[Catch] = []
    change, where = float("nan"), ""
    for one in sorted(tried, key=lambda one: one.study.name != FIRST.get(mutant.group)):
        found, crash = _seen_of(mutant, one)
        for key in (key for key in expected if key[0] == one.study.name):
            catch = caught(key, expected[key], found.get(key), crash)
            if catch is not None:
                catches.append(catch)
            ratio = _change(expected[key], found.get(key))
            if not (isnan(ratio) or ratio <= change):
                change, where = ratio, ": ".join(key)
        if not every and any(c.outcome in FAILED for c in catches):
            break
    return Trial(mutant, tuple(catches), change, where, perf_counter() - started)


def _seen_of(mutant: Mutant, tried: Tried) -> tuple[dict[Key, Seen], str]:
    """The verdicts with the mutant; none, and why, if the program breaks down."""
    with applied(mutant), warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            return verdicts(tried, computed(tried.study)), ""
        except Exception as error:  # whatever a seeded bug may cause is seen by the user
            return {}, f"{type(error).__name__}: {error}"


def caught(key: Key, before: Seen, after: Seen | None, crash: str = "") -> Catch | None:
    """The catch, if a verdict that was good is no more, or what was exercised is no more; there is
    no verdict ``after`` a crash."""
    if before.outcome not in GOOD:
        return None
    if after is None:
        return Catch(*key, CRASH, float("nan"), crash)
    if after.outcome in (before.outcome, *MET):
        return None
    return Catch(*key, after.outcome, after.observed, after.reason)


def _change(before: Seen, after: Seen | None) -> float:
    """|e' / e - 1|; NaN where the error is rounding alone, or bounded without an order."""
    if after is None or not before.error > 1e-9 or not np.isfinite(before.expected):
        return float("nan")
    return abs(after.error / before.error - 1.0)
