"""Writes a report: index.html, tex/ and data/."""

import shutil
from collections.abc import Callable
from pathlib import Path

from esfem.common.files import writable_folder, write_text
from esfem.report.data import data_files
from esfem.report.drawings import draw, extra_figure, flow_pictures
from esfem.report.html import html
from esfem.report.results_folder import ResultsFolder, read_folder
from esfem.report.sections import flow_section, study_section
from esfem.report.tex import tex_files


def write_report(folder: Path, out: Path, say: Callable[[str], None] = lambda line: None) -> Path:
    """Write the report of a folder of results, and return the path of its HTML file.

    Parameters
    ----------
    folder : holds results of studies, and may hold flows/, sentences.json and extra/.
    out : where ``index.html``, ``tex/`` and ``data/`` are written.
    say : is told what is being done.

    Raises
    ------
    BadInput
        If there is nothing to show, something is damaged, or ``out`` cannot be written.
    """
    results = read_folder(folder)
    tex, data = writable_folder(out, "tex", "data") / "tex", out / "data"
    title = f"Convergence report: {folder.resolve().name}"
    drawings = draw(results, tex, say)
    for name, text in data_files(results).items():
        write_text(data / name, text)
    studies = [study_section(result, drawings) for result in results.studies]
    flows = [flow_section(result, drawings) for result in results.flows]
    for name, text in tex_files(results, studies, flows, title).items():
        write_text(tex / name, text)
    _copy_pictures(results, tex)
    write_text(out / "index.html", html(results, studies, flows, title))
    return out / "index.html"


def _copy_pictures(results: ResultsFolder, tex: Path) -> None:
    """Pictures of flows, and figures of extra sections that are there as PDF, go to the LaTeX."""
    found = [flow_pictures(flow) for flow in results.flows]
    extras = enumerate(results.extras.values())
    found += [extra_figure(i, extra, results.folder) for i, extra in extras]
    for pictures in found:
        for name, path in pictures.items():
            shutil.copyfile(path, tex / name)
