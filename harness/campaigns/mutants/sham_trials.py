"""The order studies for each sham scheme: results/mutants/shams.csv and shams.md."""

import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from rich.console import Console
from rich.progress import Progress

from esfem.campaigns.mutants.campaign import computed, floors_of
from esfem.campaigns.mutants.shams import SHAMS, Sham, claims_order, planted
from esfem.common.files import writable_folder, write_text
from esfem.common.provenance import provenance_line
from esfem.judging.outcome import Outcome
from esfem.results.study_result import StudyResult, judged
from esfem.runs.executors import LocalProcesses
from esfem.schemes import DEFAULT_SCHEME
from esfem.studies.catalogue import default_studies, full_studies, load_studies
from esfem.studies.study import Study

HONEST = "the scheme itself"
REPORT = """\
<!-- {origin} -->

# Sham schemes

What schemes that do not solve the flow get in the studies that claim an order of `kll`: {shams}. \
They take its place through the plug-in interface; floors are those of the program as it is. In \
brackets the verdicts on the variables that are claimed. *must* says that the study has to catch \
it: one that does nothing may be green nowhere, half the speed must FAIL wherever an exact \
solution moves and h is judged (an error against the finest mesh cannot see it: that mesh is as \
slow; nor can defects: they are those of exact States), and a State that is a step old wherever \
tau is judged of a method of order two at least.

{table}
"""


@dataclass(frozen=True)
class Line:
    """What a study says of a sham, or of the scheme itself: its outcome, and in ``detail`` the
    verdicts on what is claimed; ``must`` if it has to catch the sham, ``caught`` whether it did."""

    study: str
    direction: str
    sham: str
    outcome: Outcome
    detail: str
    must: bool
    caught: bool


def order_studies() -> list[Study]:
    """The committed default and further studies that claim an order of the default scheme."""
    studies = load_studies([*default_studies(), *full_studies()])
    return [s for s in studies if claims_order(s) and s.scheme.name == DEFAULT_SCHEME]


def tried(study: Study) -> list[Line]:
    """The lines of a study: that of the scheme itself, and one a sham."""
    runs = computed(study)
    floors = floors_of(study, runs)
    found = [_line(HONEST, judged(study, Path(), runs, floors), None)]
    for sham in SHAMS:
        with planted(sham), warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            runs = computed(study)
        found.append(_line(sham.name, judged(study.model_copy(), Path(), runs, floors), sham))
    return found


def run_shams(names: Sequence[str], jobs: int, out: Path, console: Console) -> int:
    """Try the shams in these studies, by default in all order studies; write and print the table.

    0 if every study catches the shams that it must, 1 otherwise.
    """
    studies = load_studies(names) if names else order_studies()
    lines: list[Line] = []
    with Progress(console=console) as progress:
        task = progress.add_task("studies with sham schemes", total=len(studies))
        for _, own in LocalProcesses(jobs).run(tried, studies):
            lines += own
            progress.advance(task)
            for line in own:
                console.print(_told(line), soft_wrap=True)
    table = pd.DataFrame([asdict(line) for line in lines])
    if not names:
        write_text(writable_folder(out) / "shams.csv", table.to_csv(index=False))
        write_text(out / "shams.md", _report(table))
    missed = [line for line in lines if line.must and not line.caught]
    console.print(f"{sum(line.must for line in lines)} must be caught, {len(missed)} are not")
    return 1 if missed else 0


def _line(name: str, result: StudyResult, sham: Sham | None) -> Line:
    study = result.study
    claimed = study.claimed.variables if study.claimed is not None else ()
    judged_of = [v for v in result.verdicts if v.variable in claimed]
    detail = ", ".join(f"{v.variable} {v.verdict}" for v in judged_of)
    outcome = result.outcome
    must = sham is not None and sham.tries(study)
    caught = sham is not None and outcome in sham.caught
    return Line(study.name, study.direction, name, outcome, detail, must, caught)


def _told(line: Line) -> str:
    missed = "NOT CAUGHT  " if line.must and not line.caught else ""
    return f"{missed}{line.study}, {line.sham}: {line.outcome} ({line.detail})"


def _report(table: pd.DataFrame) -> str:
    shown = table.assign(
        outcome=table["outcome"].str.upper() + " (" + table["detail"] + ")",
        must=np.where(table["must"], np.where(table["caught"], "caught", "NOT CAUGHT"), ""),
    )
    columns = ["study", "direction", "sham", "outcome", "must"]
    shams = "; ".join(f"{sham.name}, {sham.what}" for sham in SHAMS)
    table_text = shown[columns].to_markdown(index=False)
    return REPORT.format(origin=provenance_line(), shams=shams, table=table_text)
