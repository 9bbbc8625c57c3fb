"""Flows in the middle of a run, from N = 954 nodes to a million: P2, BDF2, projected."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import islice

import numpy as np
from scipy.spatial import ConvexHull

from esfem.meshes import surface_mesh
from esfem.reference_solutions import StationarySphere
from esfem.solver import BDF, Levels, Mesh, Scheme, State, elevate, evolve
from esfem.solver.block_system import BlockSystem
from esfem.solver.flow import REMEMBERED
from esfem.solver.mesh import Integers
from esfem.solver.reference_element import Array
from esfem.solver.scheme import correction, step

LARGEST_STORED = 3840  # vertices
BDF2 = BDF.of_order(2)


@dataclass(frozen=True)
class Flow:
    """What a step needs: the last States, newest first, and what stays the same."""

    mesh: Mesh
    block: BlockSystem
    history: list[State]
    scheme: Scheme
    tau: float
    theta: Array

    @property
    def t(self) -> float:
        """The time of the next State."""
        return self.history[0].t + self.tau

    def steps(self) -> Iterator[State]:
        """The States that follow, with a block system of their own, without end."""
        block, history = BlockSystem(self.mesh.pattern), deque(self.history, maxlen=REMEMBERED)
        while True:
            t = history[0].t + self.tau
            state = step(self.mesh, block, history, t, self.tau, self.scheme, self.theta)
            history.appendleft(state)
            yield state


@cache
def flow(kind: str, vertices: int) -> Flow:
    """The unit sphere at rest with theta, tau = 0.05, or an egg that rounds off, tau = 0.001."""
    at_rest = {"rest": True, "moving": False}[kind]
    mesh, initial = start(vertices, 0.0 if at_rest else 0.1)
    scheme, tau = Scheme(bdf=BDF2, theta=at_rest), 0.05 if at_rest else 0.001
    levels = Levels.equal(tau, REMEMBERED + 1)
    states = list(islice(evolve(mesh, initial, scheme, levels), 1, None))[::-1]
    history = states[:REMEMBERED]
    block = BlockSystem(mesh.pattern)
    return Flow(mesh, block, history, scheme, tau, correction(mesh, initial, scheme))


def start(vertices: int, bump: float) -> tuple[Mesh, State]:
    """The P2 sphere, its nodes moved to (1 + bump z^2) x, with the exact fields of the sphere."""
    sphere = StationarySphere()
    triangles, points = triangulated_sphere(vertices)
    mesh, x = elevate(triangles, points, 2, lambda x: sphere.closest_point(x, 0.0))
    f = sphere.fields(x, 0.0)
    return mesh, State(0.0, x * (1.0 + bump * x[:, 2:] ** 2), f.nu, f.H, f.V, f.z)


def triangulated_sphere(vertices: int) -> tuple[Integers, Array]:
    """A committed mesh, or beyond these the convex hull of a Fibonacci spiral."""
    if vertices <= LARGEST_STORED:
        surface = surface_mesh("sphere", vertices)
        return surface.triangles, surface.vertices
    i = np.arange(vertices) + 0.5
    polar, azimuth = np.arccos(1.0 - 2.0 * i / vertices), np.pi * (1.0 + np.sqrt(5.0)) * i
    rho = np.sin(polar)
    x = np.column_stack([rho * np.cos(azimuth), rho * np.sin(azimuth), np.cos(polar)])
    triangles = ConvexHull(x).simplices.astype(np.int64)
    inward = np.linalg.det(x[triangles]) < 0
    triangles[inward] = triangles[inward][:, [0, 2, 1]]
    return triangles, x
