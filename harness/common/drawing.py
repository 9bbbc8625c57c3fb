"""Colours, markers and style that all figures share; how a figure is begun, and how it is written.

Okabe and Ito's colours, which colour-blind readers can tell apart. Nothing is told by colour alone:
series differ in their markers too, and verdicts in their symbols. Figures belong to no backend and
no window, so that none has to be chosen, and nothing is left to be closed.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from esfem.common.provenance import provenance_line

if TYPE_CHECKING:  # matplotlib is slow to load, and colours are wanted without it
    import numpy as np
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")
MARKERS = ("o", "s", "^", "D", "v", "P", "*", "h")
LINES = ("-", "--", "-.", ":")  # for lines that lie on each other
STYLE = {
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.2,
    "lines.markersize": 4,
    "legend.frameon": False,
    "svg.hashsalt": "esfem-willmore",  # the same data give the same file
    "svg.fonttype": "none",
}


@dataclass(frozen=True)
class Look:
    """How a verdict looks: a colour of the palette, and a symbol that tells it without colour."""

    colour: str
    symbol: str


LOOKS: dict[str, Look] = {
    "pass": Look(PALETTE[2], "✓"),
    "super": Look(PALETTE[0], "▲"),
    "inconclusive": Look(PALETTE[4], "?"),
    "suspect": Look(PALETTE[3], "!"),
    "fail": Look(PALETTE[1], "✗"),
    "not exercised": Look(PALETTE[7], "⊘"),
    "no claim": Look(PALETTE[7], "○"),
}


@contextmanager
def styled(more: Mapping[str, Any] | None = None) -> Iterator[None]:
    """The style of all figures with ``more`` of matplotlib's parameters: a context of what is drawn
    and written, and a decorator of a function that draws."""
    import matplotlib

    parameters: Any = {**STYLE, **(more or {})}  # by any names, which matplotlib checks
    with matplotlib.rc_context(parameters):
        yield


def subplots(
    rows: int = 1, columns: int = 1, size: tuple[float, float] | None = None, **how: Any
) -> tuple["Figure", Any]:
    """A figure of so many inches and its axes; ``how`` is as for matplotlib's function."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, **how)


def save_figure(figure: "Figure", path: Path, what: str, endings: Sequence[str] = ()) -> None:
    """Write the figure as SVG and PDF, or with these ``endings``, in place of that of the ``path``.

    The file says what it shows, and which program made it; not when, so that the same figure is
    the same file.
    """
    note = f"{what}; {provenance_line()}"
    metadata: dict[str, dict[str, str | None]] = {
        ".svg": {"Description": note, "Date": None},
        ".pdf": {"Subject": note, "CreationDate": None},
        ".png": {"Description": note},
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    with styled():
        for ending in endings or (".svg", ".pdf"):
            dpi = 200 if ending == ".png" else "figure"
            figure.savefig(path.with_suffix(ending), metadata=metadata[ending], dpi=dpi)


def series_look(i: int) -> dict[str, str]:
    """Colour and marker of the i-th line."""
    return {"color": PALETTE[i % len(PALETTE)], "marker": MARKERS[i % len(MARKERS)]}


def legend_below(figure: "Figure", axis: "Axes", most: int = 6) -> None:
    """One legend for all axes: that of one of them, at most so many entries in a line."""
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), most))


def level_ticks(axis: "Axes", levels: Sequence[float]) -> None:
    """Ticks at the levels of a sweep, with two digits, on an axis of logarithms."""
    from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

    axis.set_xticks(levels)
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.2g}"))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.xaxis.set_minor_locator(NullLocator())


def stopped_crosses(
    axis: "Axes", lines: Sequence["pd.Series"], row: float, name: str = "", size: float = 4.0
) -> None:
    """Crosses in a band above the data, a row a line: stopped runs have no error, but a place.

    Parameters
    ----------
    lines : where the stopped runs of each line are, on the x-axis; nothing is drawn without any.
    row : the height of a row, as a part of the axis.
    name : what the crosses of line i are called in an SVG file, with "{i}" for i.
    """
    if not any(len(stopped) for stopped in lines):
        return
    scale = axis.yaxis.get_transform()
    low, high = scale.transform(axis.get_ylim())
    high = low + (high - low) / (1.0 - row * (len(lines) + 0.5))
    axis.set_ylim(*scale.inverted().transform([low, high]))
    for i, stopped in enumerate(lines):
        height = [1.0 - row * (i + 0.75)] * len(stopped)
        place, colour = axis.get_xaxis_transform(), series_look(i)["color"]
        look: dict[str, Any] = {"color": colour, "markersize": size, "gid": name.format(i=i)}
        axis.plot(stopped, height, "x", transform=place, **look)
    axis.plot([], [], "x", color="black", label="stopped early")


def labelled_map(
    axis: "Axes",
    values: "np.ndarray",
    texts: "np.ndarray",
    colours: str,
    norm: "Normalize",
    on_dark: "np.ndarray",
) -> "ScalarMappable":
    """A map of ``values`` (rows, columns), white where there is none, with a text on each cell,
    which is white ``on_dark``."""
    import numpy as np
    from matplotlib import colormaps

    cmap = colormaps[colours].with_extremes(bad="white")
    image = axis.imshow(values, cmap=cmap, norm=norm, aspect="auto")
    for (i, j), text in np.ndenumerate(texts):
        colour = "white" if on_dark[i, j] else "black"
        axis.text(j, i, text, ha="center", va="center", color=colour, fontsize=6.5)
    return image
