"""The figures: error against seconds of the processor, and the course of a long flow."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from harness.comparison.contest import ENTRANTS, GROUNDS, March, case_of, march
from harness.plots import MARKERS, PALETTE, STYLE
from harness.provenance import provenance_line

GROUND = "red blood cell"
LADDER = (60, 120, 240, 480)
LONG_V, LONG_TAU, LONG_TIME = 120, 0.005, 2.0
LABELS = {"distance": "distance of the surfaces", "W": "energy $W$, relative"}


def ladders(tau: float, T: float) -> Iterator[tuple[str, list[March]]]:
    """Each entrant with its marches on finer and finer meshes of one surface, to the same time."""
    for entrant in ENTRANTS:
        yield entrant, [march(case_of(entrant, GROUNDS[GROUND], V, tau, T)) for V in LADDER]


def courses() -> Iterator[tuple[str, March]]:
    """Each entrant with its march on one mesh of the same surface over a long time."""
    for entrant in ENTRANTS:
        case = case_of(entrant, GROUNDS[GROUND], LONG_V, LONG_TAU, LONG_TIME)
        yield entrant, march(case, compare=False)


def save_cost_figure(path: Path, found: dict[str, list[March]]) -> None:
    """Write the figure: distance and error of W, a line a scheme, a marker a mesh of `LADDER`."""
    with _two_axes(path, f"error against CPU seconds, {GROUND}") as axes:
        for axis, name in zip(axes, ("distance", "W"), strict=True):
            for i, (entrant, marches) in enumerate(found.items()):
                points = np.array([(m.cpu, getattr(m, name)) for m in marches])
                axis.loglog(*points.T, marker=MARKERS[i], color=PALETTE[i], label=entrant)
            axis.set_xlabel("CPU seconds")
            axis.set_title(LABELS[name], fontsize=9)
            axis.margins(0.08)
        axes[0].set_ylabel("error at the end")


def save_course_figure(path: Path, found: dict[str, March]) -> None:
    """Write the figure: quality of the mesh and energy against time, a line a scheme; a cross is
    where it broke down."""
    with _two_axes(path, f"quality of the mesh and energy against time, {GROUND}") as axes:
        for i, (entrant, m) in enumerate(found.items()):
            for axis, series in zip(
                axes, (m.quality, np.array(m.energy) / (8 * np.pi)), strict=True
            ):
                axis.plot(m.t, series, color=PALETTE[i], label=entrant)
                if m.ended != "ok":
                    axis.plot(m.t[-1], series[-1], "x", color=PALETTE[i])
        axes[0].set_title("least quality of a triangle", fontsize=9)
        axes[1].set_title("energy $W / 8 \\pi$", fontsize=9)
        axes[1].set_yscale("log")
        for axis in axes:
            axis.set_xlabel("$t$")
            axis.margins(x=0.02)


@contextmanager
def _two_axes(path: Path, what: str) -> Iterator[np.ndarray]:
    """Two axes beside each other with one legend below; written to ``path`` at the end."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(7.5, 3.4), layout="constrained")
        yield axes
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        note = f"{what}; {provenance_line()}"
        figure.savefig(path, metadata={"Description": note, "Date": None})
        plt.close(figure)
