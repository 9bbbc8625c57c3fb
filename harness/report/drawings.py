"""All figures of a report, each drawn once: as SVG for the page and as PDF for LaTeX."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from esfem.common.drawing import save_figure
from esfem.flows.flow_results import FlowResult
from esfem.report.extra import StoredExtra
from esfem.report.figures import flow_figures, study_figures
from esfem.report.results_folder import ResultsFolder
from esfem.report.svg import drawn
from esfem.results.study_result import StudyResult


@dataclass(frozen=True)
class Drawing:
    """A figure as the text of an SVG file, and what it shows in words."""

    svg: str
    shows: str


Drawings = dict[str, dict[str, Drawing]]  # by anchor of the section and name


def anchor_of(result: StudyResult | FlowResult) -> str:
    """The anchor of its section, which also names its files."""
    if isinstance(result, FlowResult):
        return f"flow-{result.flow.name}"
    return f"study-{result.study.name}"


def flow_pictures(result: FlowResult) -> dict[str, Path]:
    """The pictures in the folder of a flow, by numbered names: their own may be anything."""
    found = enumerate(sorted(result.folder.glob("*.png")))
    return {f"{anchor_of(result)}-picture-{i}.png": path for i, path in found}


def extra_figure(i: int, extra: StoredExtra, folder: Path) -> dict[str, Path]:
    """The figure of the i-th extra section, if it is there as PDF too, by a numbered name."""
    if extra.figure is None:
        return {}
    pdf = (folder / "extra" / extra.figure).with_suffix(".pdf")
    return {f"extra-{i}-figure.pdf": pdf} if pdf.exists() else {}


def draw(results: ResultsFolder, folder: Path, say: Callable[[str], None]) -> Drawings:
    """Draw all figures, and write each as ``ANCHOR-NAME.pdf`` into the folder."""
    found: Drawings = {}
    shown: list[StudyResult | FlowResult] = [*results.studies, *results.flows]
    for result in shown:
        anchor = anchor_of(result)
        say(f"drawing {anchor}")
        found[anchor] = _draw(result, anchor, folder)
    return found


def _draw(result: StudyResult | FlowResult, anchor: str, folder: Path) -> dict[str, Drawing]:
    figures = flow_figures(result) if isinstance(result, FlowResult) else study_figures(result)
    drawings = {}
    for name, (figure, shows) in figures.items():
        save_figure(figure, folder / f"{anchor}-{name}.pdf", shows, [".pdf"])
        drawings[name] = Drawing(drawn(figure), shows)
    return drawings
