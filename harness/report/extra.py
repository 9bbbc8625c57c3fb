"""Extra tables and figures of the report: what one is, and how it is written."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from esfem.common.drawing import save_figure
from esfem.common.files import write_json
from esfem.common.provenance import provenance_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Extra:
    """A section of the report; ``alt`` describes the figure to who cannot see it."""

    title: str
    text: str
    table: list[dict[str, Any]] = field(default_factory=list)
    figure: "Figure | None" = None
    alt: str = ""


def write_extra(
    folder: Path, name: str, extra: Extra, figure_name: str = "", **origin: Any
) -> None:
    """Write NAME.json, and NAME.svg and NAME.pdf if there is a figure.

    Parameters
    ----------
    figure_name : another name of the figure.
    origin : what else the JSON file tells of how it was made.
    """
    drawn = None
    if extra.figure is not None:
        drawn = f"{figure_name or name}.svg"
        save_figure(extra.figure, folder / drawn, extra.title)
    rest = {"title": extra.title, "text": extra.text, "table": extra.table, "alt": extra.alt}
    content = {**rest, "figure": drawn, "by": provenance_line(), **origin}
    write_json(folder / f"{name}.json", content)
