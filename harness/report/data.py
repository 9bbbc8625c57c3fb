"""The numbers behind the figures as files for pgfplots: a header of names, a row a level."""

import pandas as pd

from esfem.common.provenance import provenance_line
from esfem.common.tex_text import one_line
from esfem.flows.flow_file import describe_flow
from esfem.flows.flow_results import FlowResult
from esfem.report.drawings import anchor_of
from esfem.report.results_folder import ResultsFolder
from esfem.results.study_result import StudyResult
from esfem.studies.quantities import NODAL

LEADING = ("h", "tau", "vertices", "nodes", "steps")
TRAILING = ("energy_T", "willmore_T", "seconds")


def data_files(results: ResultsFolder) -> dict[str, str]:
    """The texts of all files by name: one a series of a study, one a flow."""
    files: dict[str, str] = {}
    for result in results.studies:
        files |= _of_study(result)
    return files | {f"{anchor_of(flow)}.dat": _of_flow(flow) for flow in results.flows}


def _of_study(result: StudyResult) -> dict[str, str]:
    study, parameter = result.study, result.study.direction
    errors = [f"err_{name}" for name in study.variables]
    nodal = [f"nodal_{name}" for name in study.variables if f"nodal_{name}" in result.records]
    files = {}
    for label, runs in result.series:
        file = f"{anchor_of(result)}_{label.replace(' = ', '-')}.dat"
        head = [
            f"{study.title}, {label}",
            result.words.case,
            f"err_*: {result.words.errors}",
            *([f"nodal_*: {NODAL}"] if nodal else []),
            f"energy_T: {study.law.energy}; willmore_T: W = 1/2 int H^2",
            "a run that stopped early has no error: nan; use unbounded coords=discard",
            rf"\addplot table[x={parameter}, y={errors[0]}] {{{file}}}; in a loglogaxis",
        ]
        files[file] = _text(runs[[*LEADING, *errors, *nodal, *TRAILING]], head)
    return files


def _of_flow(result: FlowResult) -> str:
    columns = (
        *("t", "energy", "willmore", "area", "volume", "least_normal", "greatest_normal"),
        *("least_area_element", "speed"),
    )
    table = pd.DataFrame({name: result.history.column(name) for name in columns})
    example = rf"\addplot table[x=t, y=energy] {{{anchor_of(result)}.dat}}; in an axis"
    energies = f"energy: {result.history.energy}; willmore: W = 1/2 int H^2"
    told = describe_flow(result.flow, result.nodes)
    return _text(table, [result.flow.flow.title, told, energies, example])


def _text(table: pd.DataFrame, head: list[str]) -> str:
    """The table with blanks between columns, below comments that pgfplots skips."""
    comments = "".join(f"# {one_line(line)}\n" for line in [*head, provenance_line()])
    numbers = table.to_csv(sep=" ", index=False, na_rep="nan", lineterminator="\n")
    return comments + numbers
