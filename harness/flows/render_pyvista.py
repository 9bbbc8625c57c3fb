"""Pictures by pyvista, off-screen."""

from collections.abc import Sequence

import numpy as np
import pyvista as pv

from harness.flows.shading import DIRECTION, View, edge_lines, flattened
from solver import Mesh, State


def images(mesh: Mesh, states: Sequence[State], view: View) -> list[np.ndarray]:
    """One image (pixels, pixels, 3) a State, all seen from the same place."""
    pv.vtk_verbosity("off")  # without a display, vtk warns before it renders off-screen
    plotter = pv.Plotter(off_screen=True, window_size=[view.pixels, view.pixels], lighting="none")
    try:
        plotter.set_background("white")
        plotter.enable_anti_aliasing("ssaa")
        for position, intensity in (((1.0, -2.0, 3.0), 0.75), ((-2.0, -1.0, 0.5), 0.25)):
            light = pv.Light(position=position, intensity=intensity, light_type="scene light")
            plotter.add_light(light)
        return [_image(plotter, mesh, state, view) for state in states]
    finally:
        plotter.close()


def _image(plotter: pv.Plotter, mesh: Mesh, state: State, view: View) -> np.ndarray:
    x, triangles, H, nu = flattened(mesh, state)
    surface = pv.PolyData.from_regular_faces(x, triangles)
    surface["H"] = H
    surface.point_data.active_normals = nu
    lines = pv.PolyData(
        x + 2e-3 * view.box.radius * nu,  # above the surface, or it would hide them
        lines=np.insert(edge_lines(mesh), 0, 2, axis=1).ravel(),
    )
    actors = [
        plotter.add_mesh(
            surface,
            scalars="H",
            clim=(view.low, view.high),
            cmap=view.colours,
            smooth_shading=True,
            split_sharp_edges=False,
            ambient=0.35,
            diffuse=0.75,
            specular=0.0,
            show_scalar_bar=False,
        ),
        plotter.add_mesh(lines, color="black", line_width=0.6, opacity=0.35, lighting=False),
    ]
    radius, middle = view.box.radius, view.box.middle
    eye = middle + 10.0 * radius * DIRECTION / np.linalg.norm(DIRECTION)
    plotter.camera_position = [tuple(eye), tuple(middle), (0.0, 0.0, 1.0)]
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 1.02 * radius
    plotter.reset_camera_clipping_range()
    image = plotter.screenshot(return_img=True)
    for actor in actors:
        plotter.remove_actor(actor)
    return np.asarray(image)
