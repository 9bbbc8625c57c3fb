"""Extra tables and figures of the report: what one is, what makes it, and how it is written."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from harness.files import write_json
from harness.plots import STYLE
from harness.provenance import provenance_line


@dataclass(frozen=True)
class Extra:
    """A section of the report; ``alt`` describes the figure to who cannot see it."""

    title: str
    text: str
    table: list[dict[str, Any]] = field(default_factory=list)
    figure: Figure | None = None
    alt: str = ""


@dataclass(frozen=True)
class NoData:
    """Why there is nothing to show: which studies are missing."""

    reason: str


# From the folder of the runs to the section.
Maker = Callable[[Path], Extra | NoData]


def write_extra(folder: Path, name: str, extra: Extra) -> None:
    """Write NAME.json, and NAME.svg and NAME.pdf if there is a figure."""
    drawn = None
    if extra.figure is not None:
        drawn = f"{name}.svg"
        note = f"{extra.title}; {provenance_line()}"
        folder.mkdir(parents=True, exist_ok=True)
        with plt.rc_context(STYLE):
            extra.figure.savefig(folder / drawn, metadata={"Description": note, "Date": None})
            meta = {"Subject": note, "CreationDate": None}
            extra.figure.savefig(folder / f"{name}.pdf", metadata=meta)
            plt.close(extra.figure)
    rest = {"title": extra.title, "text": extra.text, "table": extra.table, "alt": extra.alt}
    write_json(folder / f"{name}.json", {**rest, "figure": drawn, "by": provenance_line()})
