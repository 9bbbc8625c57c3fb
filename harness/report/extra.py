"""Extra tables and figures of the report: what one is, how it is written, and what is read."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator

from esfem.common.drawing import save_figure
from esfem.common.files import write_json
from esfem.common.provenance import provenance_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure


Cell = str | float | int | bool | None


class StoredExtra(BaseModel):
    """One file ``extra/NAME.json``: a section of its own; ``figure`` is an SVG file beside it."""

    model_config = ConfigDict(frozen=True)

    title: str
    text: str = ""
    table: list[dict[str, Cell]] = Field(default_factory=list)
    figure: str | None = None
    alt: str = ""

    @model_validator(mode="after")
    def _described(self) -> "StoredExtra":
        if self.figure is not None and (Path(self.figure).name != self.figure or not self.alt):
            raise ValueError("figure: must be the name of an SVG file beside it, and have an alt")
        return self


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
