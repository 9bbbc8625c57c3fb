"""The surfaces of a flow as images, coloured by H: by pyvista, off-screen."""

from collections.abc import Sequence

import numpy as np
import pyvista as pv
from matplotlib.cm import ScalarMappable

from esfem.flows.paraview import grid
from esfem.solver import Mesh, State

PIXELS = 560  # of the side of an image
DIRECTION = np.array([1.0, -1.6, 0.9])  # from the middle to the eye
LIGHTS = (((1.0, -2.0, 3.0), 0.75), ((-2.0, -1.0, 0.5), 0.25))  # from where, how bright
# Each side of an element is halved twice: a curved edge looks curved.
CURVED = {"algorithm": "dataset_surface", "nonlinear_subdivision": 2}
ABOVE = 2e-3  # the surface lie its edges, of the radius, or it would hide them
LIT = {"ambient": 0.35, "diffuse": 0.75, "specular": 0.0}


def images(mesh: Mesh, states: Sequence[State], colours: ScalarMappable) -> list[np.ndarray]:
    """One image (PIXELS, PIXELS, 3) a State, all in one scale and seen from the same place."""
    pv.vtk_verbosity("off")  # without a display, vtk warns before it renders off-screen
    plotter = pv.Plotter(off_screen=True, window_size=[PIXELS, PIXELS], lighting="none")
    try:
        plotter.set_background("white")
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


def _image(
    plotter: pv.Plotter,
    surface: pv.UnstructuredGrid,
    colours: ScalarMappable,
    middle: np.ndarray,
    radius: float,
) -> np.ndarray:
    """One surface, in the ball of that middle and radius."""
    smooth = surface.extract_surface(**CURVED)
    smooth.point_data.active_normals = smooth["nu"]
    elements = surface.separate_cells().extract_surface(**CURVED)
    edges = elements.extract_feature_edges(feature_edges=False, manifold_edges=False)
    edges.points += ABOVE * radius * edges["nu"]
    look = {"clim": colours.get_clim(), "cmap": colours.cmap, "show_scalar_bar": False}
    shading = {"smooth_shading": True, "split_sharp_edges": False, **LIT}
    actors = [
        plotter.add_mesh(smooth, scalars="H", **look, **shading),
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
