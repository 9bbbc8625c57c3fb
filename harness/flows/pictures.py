"""Pictures of a flow: the surfaces coloured by H, drawn by pyvista, and its energies along t."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import CenteredNorm, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from esfem.common.drawing import PALETTE, save_figure, styled, subplots
from esfem.flows.checks import ENDS, reference_flow
from esfem.flows.flow_file import FlowFile
from esfem.flows.flow_results import Ended, read_frames
from esfem.flows.history import History
from esfem.flows.paraview import grid
from esfem.solver import Mesh, State
from esfem.solver.laws import energy_of
from esfem.solver.reference_element import Array

if TYPE_CHECKING:
    import pyvista as pv

COLOURS = "RdYlBu_r"
QUANTILES = (0.01, 0.99)  # of H over all pictures: the range of the colours
PIXELS = 560  # of the side of an image
DIRECTION = np.array([1.0, -1.6, 0.9])  # from the middle to the eye
LIGHTS = (((1.0, -2.0, 3.0), 0.75), ((-2.0, -1.0, 0.5), 0.25))  # from where, how bright
ABOVE = 2e-3  # the surface lie its edges, of the radius, or it would hide them


def colouring(states: Sequence[State]) -> ScalarMappable:
    """The same colours in all pictures; the middle one is H = 0 if H takes both signs."""
    H = np.concatenate([state.H for state in states])
    low, high = np.quantile(H, QUANTILES)
    if low < 0 < high:
        return ScalarMappable(CenteredNorm(0.0, max(-low, high)), COLOURS)
    wide = (low, high) if high > low else (low - 1.0, high + 1.0)
    return ScalarMappable(Normalize(*wide), COLOURS)


def save_surfaces(folder: Path, flow: FlowFile, mesh: Mesh, ended: Ended) -> None:
    """Write surfaces.png: the States in a row, three a line, in one scale and one colouring.

    Of a flow that stopped, the last State is shown too: where and how is the point.
    """
    last = () if ended.status == "ok" else ended.framed[-1:]
    levels = sorted({*(n for n in flow.pictured if n in ended.framed), *last})
    states = list(read_frames(folder, levels))
    colours = colouring(states)
    drawn = images(mesh, states, colours)
    title = flow.flow.title
    figure = surfaces_figure(drawn, states, colours, title)
    save_figure(figure, folder / "surfaces.png", title, [".png"])


def images(mesh: Mesh, states: Sequence[State], colours: ScalarMappable) -> list[NDArray[np.uint8]]:
    """One image (PIXELS, PIXELS, 3) a State, all in one scale and seen from the same place."""
    import pyvista as pv  # slow to load, and may not be there

    pv.vtk_verbosity("off")  # without a display, vtk warns before it renders off-screen
    plotter = pv.Plotter(off_screen=True, window_size=[PIXELS, PIXELS], lighting="none")
    try:
        plotter.background_color = pv.Color("white")
        plotter.enable_anti_aliasing("ssaa")
        for position, intensity in LIGHTS:
            light = pv.Light(position=position, intensity=intensity, light_type="scene light")
            plotter.add_light(light)
        first = states[0].x
        middle = (first.min(axis=0) + first.max(axis=0)) / 2.0
        radius = max(float(np.linalg.norm(s.x - middle, axis=1).max()) for s in states)
        return [_image(plotter, grid(mesh, s), colours, middle, radius) for s in states]
    finally:
        plotter.close()


def _skin(cells: "pv.UnstructuredGrid") -> "pv.PolyData":
    """Each side of an element halved twice, so that a curved edge looks curved."""
    return cells.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=2)


def _image(
    plotter: "pv.Plotter",
    surface: "pv.UnstructuredGrid",
    colours: ScalarMappable,
    middle: Array,
    radius: float,
) -> NDArray[np.uint8]:
    """One surface, in the ball of that middle and radius."""
    smooth = _skin(surface)
    smooth.point_data.active_normals = smooth["nu"]
    elements = _skin(surface.separate_cells())
    edges = elements.extract_feature_edges(feature_edges=False, manifold_edges=False)
    edges.points += ABOVE * radius * edges["nu"]
    actors = [
        plotter.add_mesh(
            smooth,
            scalars="H",
            clim=colours.get_clim(),
            cmap=colours.cmap,
            show_scalar_bar=False,
            smooth_shading=True,
            split_sharp_edges=False,
            ambient=0.35,
            diffuse=0.75,
            specular=0.0,
        ),
        plotter.add_mesh(edges, color="black", line_width=0.6, opacity=0.5, lighting=False),
    ]
    eye = middle + 10.0 * radius * DIRECTION / np.linalg.norm(DIRECTION)
    plotter.camera_position = [tuple(eye), tuple(middle), (0.0, 0.0, 1.0)]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 1.02 * radius
    plotter.reset_camera_clipping_range()
    image = plotter.screenshot(return_img=True)
    for actor in actors:
        plotter.remove_actor(actor)
    return np.asarray(image)


@styled()
def surfaces_figure(
    images: Sequence[NDArray[np.uint8]],
    states: Sequence[State],
    colours: ScalarMappable,
    title: str,
) -> Figure:
    """Pictures with their times below each other in lines of three, and one bar of colours."""
    columns = min(3, len(images))
    rows = -(-len(images) // columns)
    height, width = images[0].shape[:2]
    size = (2.3 * columns + 0.9, 2.3 * rows * height / width + 0.25 * rows + 0.3)
    figure, axes = subplots(rows, columns, size, squeeze=False)
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, image, state in zip(axes.flat, images, states, strict=False):
        axis.imshow(image, interpolation="antialiased")
        axis.set_title(f"$t = {state.t:g}$", fontsize=9, pad=2)
    bar = figure.colorbar(colours, ax=axes, shrink=0.7, aspect=30, pad=0.01, extend="both")
    bar.set_label("$H$", rotation=0)
    bar.outline.set_linewidth(0.5)
    figure.suptitle(title, fontsize=10, parse_math=False)
    return figure


def save_energy(folder: Path, flow: FlowFile, history: History) -> None:
    """Write energy.svg and energy.pdf: the energy and W, its expected end, and the reference."""
    save_figure(energy_figure(flow, history), folder / "energy.svg", flow.flow.title)


@styled()
def energy_figure(flow: FlowFile, history: History) -> Figure:
    """The energy of the law along t, and its distance from the end on a logarithmic scale; W and
    its distance in a line below where that is another one."""
    own = history.energy
    rows = [("energy", own.symbol, own.tex)] if np.isfinite(history.column("energy")).any() else []
    if own.symbol != "W" or not rows:
        rows.append(("willmore", "W", energy_of("willmore").tex))
    size = (6.6, 2.6 * len(rows))
    figure, axes = subplots(len(rows), 2, size, squeeze=False)
    for pair, (column, symbol, tex) in zip(axes, rows, strict=True):
        _energy_row(pair, flow, history, column, symbol, tex)
    figure.suptitle(flow.flow.title, fontsize=10, parse_math=False)
    return figure


def _energy_row(
    axes: Sequence[Axes], flow: FlowFile, history: History, column: str, symbol: str, tex: str
) -> None:
    """One energy; the end that a flow is expected to reach is one of W."""
    left, right = axes
    t, E = history.column("t"), history.column(column)
    end = flow.checks.ends_at if symbol == "W" else None
    name, level = (f"{symbol}(T)", E[-1]) if end is None else ENDS[end]
    left.plot(t, E, color=PALETTE[0], label="computed")
    if end is not None:
        left.axhline(level, color="0.4", lw=0.8, ls="--", label=f"${name}$")
    if flow.checks.reference is not None:
        reference = reference_flow(flow)
        exact = {"energy": reference.energies, "willmore": reference.willmore}[column]
        left.plot(reference.times, exact, "o", color=PALETTE[1], mfc="none", label="axisymmetric")
    left.set(xlabel="$t$", ylabel=f"${symbol} = {tex}$")
    left.legend()
    right.semilogy(t, np.abs(E - level), color=PALETTE[0])
    right.set(xlabel="$t$", ylabel=f"$|{symbol} - {name}|$")
