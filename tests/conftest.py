"""Meshes, random fields, the command line, and where cells are computed: what modules share."""

import sys
from collections.abc import Callable, Iterator
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from shortcuts import PROCESSES, SAVE, computed_by, run_here, save_blank, saved_by

from esfem.cli import main
from esfem.meshes import surface_mesh
from esfem.reference_solutions import CliffordTorus, StationarySphere, Torus
from esfem.solver import Mesh, elevate

# A torus without V = 0 and without the symmetries of the Clifford torus.
TORUS = Torus(R=1.0, r=0.6)
PROJECTIONS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "sphere": lambda x: StationarySphere().closest_point(x, 0.0),
    "clifford_torus": lambda x: CliffordTorus().closest_point(x, 0.0),
    "torus": TORUS.closest_point,
}


@cache
def vertices_of(surface: str, vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """Triangles and vertices; the torus is the Clifford torus with a thinner tube."""
    if surface != "torus":
        mesh = surface_mesh(surface, vertices)
        return mesh.triangles, mesh.vertices
    mesh = surface_mesh("clifford_torus", vertices)
    x, y, z = mesh.vertices.T
    rho, phi = np.hypot(x, y), np.arctan2(y, x)
    theta = np.arctan2(z, rho - 1.0)
    rho = TORUS.R + TORUS.r * np.cos(theta)
    embedded = [rho * np.cos(phi), rho * np.sin(phi), TORUS.r * np.sin(theta)]
    return mesh.triangles, np.stack(embedded, axis=1)


@cache
def raised_mesh(surface: str, vertices: int, degree: int) -> tuple[Mesh, np.ndarray]:
    triangles, x = vertices_of(surface, vertices)
    mesh, nodes = elevate(triangles, x, degree, PROJECTIONS[surface])
    nodes.setflags(write=False)
    return mesh, nodes


@pytest.fixture(scope="session")
def raised() -> Callable[[str, int, int], tuple[Mesh, np.ndarray]]:
    """The P_k mesh and its nodes on "sphere", "clifford_torus" or "torus" (R = 1, r = 0.6)."""
    return raised_mesh


@pytest.fixture(scope="session")
def torus() -> Torus:
    return TORUS


@pytest.fixture(scope="session")
def make_rough(raised) -> Callable[[int], SimpleNamespace]:
    """A small torus of degree k with nodes moved at random, and random nodal fields."""

    def make(degree: int) -> SimpleNamespace:
        mesh, nodes = raised("torus", 30, degree)
        rng = np.random.default_rng(degree)
        N = mesh.node_count
        return SimpleNamespace(
            mesh=mesh,
            x=nodes + 0.02 * rng.standard_normal(nodes.shape),
            u=rng.standard_normal((N, 4)),
            w=rng.standard_normal((N, 4)),
        )

    return make


@pytest.fixture(scope="session", autouse=True)
def shortcuts() -> Iterator[None]:
    """Cells are computed in this process, but where a test asks for ``processes``, and figures are
    blank, but where it asks for ``figures``."""
    with computed_by(run_here), saved_by(save_blank):
        yield


@pytest.fixture
def processes() -> Iterator[None]:
    with computed_by(PROCESSES):
        yield


@pytest.fixture
def figures() -> Iterator[None]:
    with saved_by(SAVE):
        yield


@pytest.fixture
def esfem(monkeypatch, capsys) -> Callable[..., tuple[int, str, str]]:
    """Run the command line in this process: status, standard output, standard error."""

    def run(*words: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["esfem", *map(str, words)])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return stop.value.code or 0, out, err

    return run


@pytest.fixture
def command(esfem) -> Callable[..., tuple[int, str]]:
    """The command line: its status, and all that it says."""

    def run(*words: object) -> tuple[int, str]:
        status, out, err = esfem(*words)
        return status, out + err

    return run
