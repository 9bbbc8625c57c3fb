"""The figures: error against seconds of the processor, and the course of a long flow."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from harness.comparison.march import March
from harness.plots import MARKERS, PALETTE, STYLE
from harness.provenance import provenance_line

STYLES = ("-", "--", "-.", ":")  # lines that lie on each other are seen
LABELS = {"distance": "distance of the surfaces", "W": "$W = \\frac{1}{2} \\int H_h^2$, relative"}


def save_cost_figure(path: Path, ground: str, found: dict[str, list[March]]) -> None:
    """Write the figure: distance and error of W at the end against seconds of the processor, a line
    a scheme, a marker a mesh; a cross at the top is a run that broke down."""
    with _two_axes(path, f"error against CPU seconds, {ground}") as axes:
        for axis, name in zip(axes, LABELS, strict=True):
            for i, (entrant, marches) in enumerate(found.items()):
                color = PALETTE[i % len(PALETTE)]
                ran = [(m.cpu, m.at("end", name)) for m in marches if m.ended == "ok"]
                axis.loglog(
                    *np.array(ran).reshape(-1, 2).T,
                    marker=MARKERS[i % len(MARKERS)],
                    color=color,
                    label=entrant,
                )
                for m in (m for m in marches if m.ended != "ok"):
                    _cross_at_top(axis, m.cpu, color, f"broken-{i}")
            axis.set_xlabel("CPU seconds")
            axis.set_title(LABELS[name], fontsize=9)
            axis.margins(0.08)
        axes[0].set_ylabel("error at the end")


def _cross_at_top(axis: Axes, cpu: float, color: str, gid: str) -> None:
    """At these seconds; a first step that failed has none, and its cross stands at the left."""
    x, transform = (cpu, axis.get_xaxis_transform()) if cpu > 0 else (0.03, axis.transAxes)
    axis.plot(x, 0.97, "x", color=color, transform=transform, gid=gid)


def save_course_figure(path: Path, ground: str, found: dict[str, March]) -> None:
    """Write the figure: quality of the mesh and energy against time, a line a scheme; a cross is
    where it broke down."""
    with _two_axes(path, f"quality of the mesh and energy against time, {ground}") as axes:
        for i, (entrant, m) in enumerate(found.items()):
            color, style = PALETTE[i % len(PALETTE)], STYLES[i % len(STYLES)]
            energy = np.array(m.levels["own_energy"]) / (8.0 * np.pi)
            for axis, values in zip(axes, (m.levels["quality"], energy), strict=True):
                axis.plot(m.levels["t"], values, style, color=color, label=entrant)
                if m.ended != "ok":
                    axis.plot(m.levels["t"][-1], values[-1], "x", color=color, gid=f"broken-{i}")
        axes[0].set_title("least quality of a triangle", fontsize=9)
        axes[1].set_title("the scheme's own energy$\\;/\\;8 \\pi$", fontsize=9)
        for axis in axes:
            axis.set_xlabel("$t$")
            axis.margins(x=0.02)


@contextmanager
def _two_axes(path: Path, what: str) -> Iterator[np.ndarray]:
    """Two axes beside each other with one legend below; written to ``path``, an SVG file, at the
    end, and as PDF beside it, which LaTeX takes."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(7.5, 3.4), layout="constrained")
        yield axes
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        note = f"{what}; {provenance_line()}"
        figure.savefig(path, metadata={"Description": note, "Date": None})
        figure.savefig(path.with_suffix(".pdf"), metadata={"Subject": note, "CreationDate": None})
        plt.close(figure)
