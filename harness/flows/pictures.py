"""Pictures of a flow: the surfaces coloured by H, by pyvista or else matplotlib, and W(t)."""

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import CenteredNorm, Normalize
from matplotlib.figure import Figure

from harness.flows.checks import LEVEL, reference_of
from harness.flows.flow_file import ENDS, FlowFile
from harness.flows.history import History
from harness.flows.shading import Images, View, box_of
from harness.palette import PALETTE, STYLE
from harness.provenance import provenance_line
from solver import Mesh, State

SIZE = 560  # pixels of the side of one picture
COLOURS = "RdYlBu_r"
QUANTILES = (0.01, 0.99)  # of H over all pictures: the range of the colours


def colour_norm(states: Sequence[State]) -> Normalize:
    """The same colours in all pictures; white lies at H = 0 if H takes both signs."""
    H = np.concatenate([state.H for state in states])
    low, high = np.quantile(H, QUANTILES)
    if low < 0 < high:
        return CenteredNorm(0.0, max(-low, high))
    return Normalize(low, high) if high > low else Normalize(low - 1.0, high + 1.0)


def renderer() -> Images:
    """The function that makes the pictures: by pyvista, or by matplotlib if that is not there."""
    if find_spec("pyvista"):
        from harness.flows.render_pyvista import images
    else:
        from harness.flows.render_matplotlib import images
    return images


def save_surfaces(folder: Path, mesh: Mesh, states: Sequence[State], title: str) -> None:
    """Write surfaces.png: the States in a row, three a line, in one scale and one colouring."""
    norm = colour_norm(states)
    view = View(box_of(states), norm.vmin, norm.vmax, COLOURS, SIZE)
    images = renderer()(mesh, states, view)
    with plt.rc_context(STYLE):
        figure = surfaces_figure(images, states, view, title)
        figure.savefig(
            folder / "surfaces.png", dpi=200, metadata={"Description": provenance_line()}
        )
        plt.close(figure)


def surfaces_figure(
    images: Sequence[np.ndarray], states: Sequence[State], view: View, title: str
) -> Figure:
    """Pictures with their times below each other in lines of three, and one bar of colours."""
    columns = min(3, len(images))
    rows = -(-len(images) // columns)
    height, width = images[0].shape[:2]
    size = (2.3 * columns + 0.9, 2.3 * rows * height / width + 0.25 * rows + 0.3)
    figure, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False)
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, image, state in zip(axes.flat, images, states, strict=False):
        axis.imshow(image, interpolation="antialiased")
        axis.set_title(f"$t = {state.t:g}$", fontsize=9, pad=2)
    colours = ScalarMappable(Normalize(view.low, view.high), view.colours)
    bar = figure.colorbar(colours, ax=axes, shrink=0.7, aspect=30, pad=0.01, extend="both")
    bar.set_label("$H$", rotation=0)
    bar.outline.set_linewidth(0.5)
    figure.suptitle(title, fontsize=10, parse_math=False)
    return figure


def save_energy(folder: Path, flow: FlowFile, history: History) -> None:
    """Write energy.svg and energy.pdf: W(t), its expected end, and the reference."""
    with plt.rc_context(STYLE):
        figure = energy_figure(flow, history)
        note = f"{flow.flow.title}; {provenance_line()}"
        figure.savefig(folder / "energy.svg", metadata={"Description": note, "Date": None})
        figure.savefig(folder / "energy.pdf", metadata={"Subject": note, "CreationDate": None})
        plt.close(figure)


def energy_figure(flow: FlowFile, history: History) -> Figure:
    """W(t) over the whole time, and its excess over the end on a logarithmic scale."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(6.6, 2.6), layout="constrained")
    t, W = history.column("t"), history.column("energy")
    end = flow.checks.ends_at
    left.plot(t, W, color=PALETTE[0], label="computed")
    if end is not None:
        left.axhline(LEVEL[end], color="0.4", lw=0.8, ls="--", label=f"${_tex(ENDS[end])}$")
    _reference(left, flow)
    left.set(xlabel="$t$", ylabel="$W$")
    left.legend()
    level, name = (LEVEL[end], _tex(ENDS[end])) if end is not None else (W[-1], "W(T)")
    right.semilogy(t, np.abs(W - level), color=PALETTE[0])
    right.set(xlabel="$t$", ylabel=f"$|W - {name}|$")
    figure.suptitle(flow.flow.title, fontsize=10, parse_math=False)
    return figure


def _reference(axis: Axes, flow: FlowFile) -> None:
    """Marks of the axisymmetric solver, at the times of comparison."""
    reference = reference_of(flow)
    if reference is None:
        return
    axis.plot(
        reference.times, reference.energies, "o", color=PALETTE[1], mfc="none", label="axisymmetric"
    )


def _tex(energy: str) -> str:
    return energy.replace("pi", r"\pi")
