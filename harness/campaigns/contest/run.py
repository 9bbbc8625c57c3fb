"""The schemes of the paper's section 2.3 beside each other: their studies, and all else."""

from collections.abc import Collection, Sequence
from pathlib import Path

from rich.console import Console

from esfem.campaigns.contest import PARTS, STUDIES
from esfem.campaigns.contest.contest import Contest, principal
from esfem.campaigns.contest.extras import compare_schemes
from esfem.campaigns.publish import copy_studies
from esfem.common.bad_input import BadInput
from esfem.common.files import writable_folder
from esfem.report.write import write_report
from esfem.results.run_studies import run_studies
from esfem.results.study_result import StudyResult
from esfem.results.tables import print_results
from esfem.studies.catalogue import scheme_studies


def run_contest(
    parts: Collection[str],
    out: Path,
    runs: Path,
    jobs: int,
    console: Console,
    schemes: Sequence[str] = (),
) -> list[StudyResult]:
    """Run these `PARTS`, and make the report of all that is in ``out``; the results of studies.

    Parameters
    ----------
    out, runs : the folders of the light part of the results, and of all results of studies.
    jobs : number of processes.
    console : is told.
    schemes : names of those that take part too, beside `PRINCIPAL` and the variants of kll.

    Raises
    ------
    BadInput
        If there is no such part or scheme, or a folder cannot be written.
    """
    for part in parts:
        if part not in PARTS:
            raise BadInput(f"--only {part}: must be one of {', '.join(PARTS)}")
    if out.resolve() == runs.resolve():
        raise BadInput(f"--out {out}: must be another folder than --runs")
    entrants = principal(schemes)
    writable_folder(out)
    results = []
    if STUDIES in parts:
        results = run_studies(scheme_studies(), runs, console, jobs=jobs)
        print_results(results, console)
        copy_studies(runs, out, [result.study.name for result in results])
    folder = writable_folder(out, "extra") / "extra"
    compare_schemes(Contest(folder, console, jobs, entrants), parts)
    console.print(f"report: {write_report(out, out / 'report', console.print)}", soft_wrap=True)
    return results
