"""Pictures by matplotlib, where pyvista is not installed: flat triangles from back to front."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize

from harness.flows.shading import DIRECTION, View, flattened
from solver import Mesh, State

LIGHT = np.array([1.0, -2.0, 3.0]) / np.linalg.norm([1.0, -2.0, 3.0])


def images(mesh: Mesh, states: Sequence[State], view: View) -> list[np.ndarray]:
    """One image (pixels, pixels, 3) a State, all seen from the same place."""
    return [_image(mesh, state, view) for state in states]


def _image(mesh: Mesh, state: State, view: View) -> np.ndarray:
    x, triangles, H, nu = flattened(mesh, state)
    forward = DIRECTION / np.linalg.norm(DIRECTION)
    right = np.cross([0.0, 0.0, 1.0], forward)
    right /= np.linalg.norm(right)
    screen = np.stack([right, np.cross(forward, right), forward])
    corners = ((x - view.box.middle) @ screen.T)[triangles]
    normals = nu[triangles].mean(axis=1)
    seen = np.flatnonzero(normals @ forward > 0)
    order = seen[np.argsort(corners[seen, :, 2].mean(axis=1))]
    colours = plt.get_cmap(view.colours)(Normalize(view.low, view.high)(H[triangles].mean(axis=1)))
    shade = 0.45 + 0.55 * np.clip(normals @ LIGHT, 0.0, 1.0)
    colours[:, :3] *= shade[:, None]
    return _painted(corners[order, :, :2], colours[order], 1.02 * view.box.radius, view.pixels)


def _painted(corners: np.ndarray, colours: np.ndarray, half: float, pixels: int) -> np.ndarray:
    """Triangles (T, 3, 2) in the square of half side ``half``, in the order given."""
    figure = plt.figure(figsize=(1.0, 1.0), dpi=pixels)
    try:
        axis = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axis.set(xlim=(-half, half), ylim=(-half, half))
        axis.set_axis_off()
        axis.add_collection(
            PolyCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.1)
        )
        figure.canvas.draw()
        return np.asarray(figure.canvas.buffer_rgba())[..., :3].copy()
    finally:
        plt.close(figure)
