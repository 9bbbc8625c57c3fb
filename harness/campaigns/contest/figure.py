"""The figures: error against seconds of the processor, and the course of a long flow."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from esfem.campaigns.contest.march import March
from esfem.common.drawing import LINES, PALETTE, legend_below, series_look, styled, subplots

LABELS = {"distance": "distance of the surfaces", "W": "$W = \\frac{1}{2} \\int H_h^2$, relative"}
SIZE = (7.5, 3.4)


@styled()
def cost_figure(found: dict[str, list[March]]) -> Figure:
    """Distance and error of W at the end against seconds of the processor, a line a scheme, a
    marker a mesh; a cross at the top is a run that broke down."""
    figure, axes = subplots(1, 2, SIZE)
    for axis, name in zip(axes, LABELS, strict=True):
        for i, (entrant, marches) in enumerate(found.items()):
            ran = [(m.cpu, m.at("end", name)) for m in marches if m.ended == "ok"]
            axis.loglog(*np.array(ran).reshape(-1, 2).T, label=entrant, **series_look(i))
            for m in (m for m in marches if m.ended != "ok"):
                _cross_at_top(axis, m.cpu, i)
        axis.set_xlabel("CPU seconds")
        axis.set_title(LABELS[name], fontsize=9)
        axis.margins(0.08)
    axes[0].set_ylabel("error at the end")
    legend_below(figure, axes[0], most=4)
    return figure


def _cross_at_top(axis: Axes, cpu: float, i: int) -> None:
    """At these seconds; a first step that failed has none, and its cross stands at the left."""
    x, transform = (cpu, axis.get_xaxis_transform()) if cpu > 0 else (0.03, axis.transAxes)
    color = PALETTE[i % len(PALETTE)]
    axis.plot(x, 0.97, "x", color=color, transform=transform, gid=f"broken-{i}")


@styled()
def course_figure(found: dict[str, March]) -> Figure:
    """Quality of the mesh and energy against time, a line a scheme; a cross is where it broke
    down."""
    figure, axes = subplots(1, 2, SIZE)
    for i, (entrant, m) in enumerate(found.items()):
        color, style = PALETTE[i % len(PALETTE)], LINES[i % len(LINES)]
        t, quality = m.levels["t"], m.levels["quality"]
        energy = np.array(m.levels["own_energy"]) / (8.0 * np.pi)
        for axis, values in zip(axes, (quality, energy), strict=True):
            axis.plot(t, values, style, color=color, label=entrant)
            if m.ended != "ok":
                axis.plot(t[-1], values[-1], "x", color=color, gid=f"broken-{i}")
    axes[0].set_title("least quality of a triangle", fontsize=9)
    axes[1].set_title("the scheme's own energy$\\;/\\;8 \\pi$", fontsize=9)
    for axis in axes:
        axis.set_xlabel("$t$")
        axis.margins(x=0.02)
    legend_below(figure, axes[0], most=4)
    return figure
