"""What is measured of a State at each time level, by name."""

from collections.abc import Callable, Sequence

import numpy as np

from esfem.meshes.quality import radius_ratios
from esfem.reference_solutions import InitialSurface
from esfem.solver import Mesh, State
from esfem.solver.functionals import area, normal_lengths, volume, willmore_energy
from esfem.solver.geometry import Geometry, geometry
from esfem.solver.laws import Energy
from esfem.solver.reference_element import Array

# From the surface, its State, and the energy of the law. Quality is the least ratio of inscribed to
# circumscribed circle, twice, of a triangle of vertices; the area element the least over the mean
# one, 1 on a mesh of equal flat triangles; the distance that of nodes from the origin.
NUMBERS: dict[str, Callable[[Geometry, State, Energy], float]] = {
    "t": lambda geo, state, energy: state.t,
    "energy": lambda geo, state, energy: energy.value(geo, state.H),
    "willmore": lambda geo, state, energy: willmore_energy(geo, state.H),
    "area": lambda geo, state, energy: area(geo),
    "volume": lambda geo, state, energy: volume(geo),
    "least_normal": lambda geo, state, energy: normal_lengths(state.nu)[0],
    "greatest_normal": lambda geo, state, energy: normal_lengths(state.nu)[1],
    "least_H": lambda geo, state, energy: float(state.H.min()),
    "greatest_H": lambda geo, state, energy: float(state.H.max()),
    "speed": lambda geo, state, energy: float(np.abs(state.V).max()),
    "least_area_element": lambda geo, state, energy: least_area_element(geo),
    "quality": lambda geo, state, energy: quality(geo.mesh, state.x),
    "least_distance": lambda geo, state, energy: float(np.linalg.norm(state.x, axis=1).min()),
    "greatest_distance": lambda geo, state, energy: float(np.linalg.norm(state.x, axis=1).max()),
    "iterations": lambda geo, state, energy: float(state.work.iterations),
}


def level_numbers(
    names: Sequence[str],
    mesh: Mesh,
    state: State,
    energy: Energy,
    solution: InitialSurface | None = None,
) -> dict[str, float]:
    """These `NUMBERS` of a State, and the amplitude if the solution is a decaying mode.

    Parameters
    ----------
    names : which; what is not named costs nothing.
    mesh, state : the computed surface.
    energy : that of the law.
    """
    geo = geometry(mesh, state.x)
    found = {name: NUMBERS[name](geo, state, energy) for name in names}
    if solution is not None and "decay" in solution.measures:
        found["amplitude"] = solution.mode_amplitude(state.x, nodal_weights(geo))
    return found


def least_area_element(geo: Geometry) -> float:
    """The least area element over the mean one."""
    element = geo.dA / geo.element.weights
    return float(element.min() / element.mean())


def quality(mesh: Mesh, x: Array) -> float:
    """The least quality of a flat triangle of vertices."""
    return float(radius_ratios(x[: mesh.vertex_count], mesh.triangles).min())


def nodal_weights(geo: Geometry) -> Array:
    """int phi_i^2, (N,): positive weights that do not favour densely meshed parts."""
    mesh = geo.mesh
    return np.bincount(mesh.cells.ravel(), (geo.dA @ geo.element.phi**2).ravel(), mesh.node_count)


def append(series: dict[str, list[float]], numbers: dict[str, float]) -> None:
    """A number more in each series."""
    for name, value in numbers.items():
        series.setdefault(name, []).append(value)
