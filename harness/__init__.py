"""Verification of convergence: studies, sweeps, errors by lifts, orders and verdicts.

>>> from esfem import run_study
>>> records = run_study("harness/studies/sphere.toml")  # doctest: +SKIP
>>> records[["h", "tau", "err_x"]]  # doctest: +SKIP

The program has twelve rooms, folders of harness/. Each imports only those above it in this table,
which all stand on `esfem.solver` and `esfem.reference_solutions`:

=========  ====================================  ===============================================
room       one job                               public names
=========  ====================================  ===============================================
common     knows no mathematics: bad input,      `BadInput`, `read`, `reading`, `whole`,
           files, TOML, tables, plots, origin    `table_in`, `save_figure`, `provenance_line`
measuring  how far a State is from an exact,     `lifted_surface`, `errors`, `shape_errors`,
           axisymmetric or finer surface         `against_profile`, `against_finest`
judging    a table of errors to an outcome,      `judge_table`, `Judgement`, `Floor`, `rates`,
           by probability                        `fit_order`
meshes     triangulations: generated, stored,    `surface_mesh`, `mesh_in`, `SurfaceMesh`,
           refined, those of users               `read_triangulation`
schemes    what a scheme is, and those there     `Plugin`, `Problem`, `Level`, `SchemeOptions`,
           are, a file each                      `named_scheme`
studies    what is asked: study files, cases,    `Study`, `load_study`, `Case`, `Claim`,
           claims                                `study_path`
runs       cases computed, one and many:         `run_case`, `Record`, `sweep`, `Cell`, `Keeper`
           stored, shared, resumed
flows      one evolution watched: history,       `load_flow`, `run_flow`, `read_flows`,
           checks, ParaView, pictures            `History`
results    records to verdicts, tables,          `run_study`, `run_studies`, `StudyResult`,
           figures and files                     `Verdict`, `judge`, `load_results`
report     a folder of results as a page, as     `write_report`, `Extra`
           LaTeX, as data
campaigns  what is run to be committed: paper,   `run_paper`, `run_contest`, `run_mutants`,
           contest, seeded bugs, baselines       `run_check`, `run_simulation`
cli        the commands, a file for each or a    `main`, `guard_table`, `guard_study`
           family of them
=========  ====================================  ===============================================
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from esfem.common.bad_input import BadInput
    from esfem.results.run_studies import run_studies, run_study
    from esfem.results.study_result import StudyResult
    from esfem.studies.study import Study, load_study

    __version__: str

__all__ = ["BadInput", "Study", "StudyResult", "load_study", "run_studies", "run_study"]
HOME = {
    "BadInput": "esfem.common.bad_input",
    "Study": "esfem.studies.study",
    "StudyResult": "esfem.results.study_result",
    "load_study": "esfem.studies.study",
    "run_studies": "esfem.results.run_studies",
    "run_study": "esfem.results.run_studies",
}


def __getattr__(name: str) -> Any:
    """Loads a name when it is first used: every pytest session imports the package for its plugin,
    and should not pay for pandas and sympy."""
    if name == "__version__":
        return import_module("importlib.metadata").version("esfem-willmore")
    if name not in HOME:
        raise AttributeError(f"module 'esfem' has no attribute {name!r}")
    return getattr(import_module(HOME[name]), name)
