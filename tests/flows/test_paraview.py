"""Files for ParaView, read back with pyvista: times, points, fields, and curved elements."""

from xml.etree import ElementTree

import numpy as np
import pytest

pv = pytest.importorskip("pyvista")
from studies import write_flow  # noqa: E402
from vtkmodules.vtkCommonCore import mutable  # noqa: E402

from esfem.flows.flow_file import load_flow  # noqa: E402
from esfem.flows.flow_results import remove_frames, stored_levels, write_frame  # noqa: E402
from esfem.flows.paraview import FIELDS, grid, vtk_order, write_series, write_vtu  # noqa: E402
from esfem.solver import State  # noqa: E402
from esfem.solver.reference_element import lattice, tabulate  # noqa: E402

DEGREES = (1, 2, 3, 4)
LEVELS = (0, 1, 3)
# Off the lattice of every degree, unsymmetric, and the middles of the edges.
INSIDE = np.array([[0.5, 0.0], [0.5, 0.5], [0.0, 0.5], [0.1, 0.2], [0.23, 0.61], [0.7, 0.13]])


@pytest.fixture(params=DEGREES)
def degree(request):
    return request.param


@pytest.fixture
def series(degree, raised, tmp_path):
    """A flow with three frames that differ in everything: its file, mesh and States by level."""
    flow = load_flow(write_flow(tmp_path))
    mesh, x = raised("torus", 30, degree)
    rng = np.random.default_rng(degree)
    N = mesh.node_count

    def state(t: float) -> State:
        vectors = [rng.standard_normal((N, 3)) for _ in range(3)]
        scalars = [rng.standard_normal(N) for _ in range(2)]
        return State(t, (1.0 + t) * x + 0.01 * vectors[0], vectors[1], *scalars, vectors[2])

    states = {n: state(flow.levels.t(n)) for n in LEVELS}
    for n, of_level in states.items():
        write_frame(tmp_path, n, of_level)
    return flow, mesh, states


def entries(folder):
    """Time and file of each entry of the .pvd file."""
    (path,) = folder.glob("*.pvd")
    found = ElementTree.parse(path).iter("DataSet")
    return [(float(entry.get("timestep")), folder / entry.get("file")) for entry in found]


def test_times_points_and_fields_read_back_to_the_last_bit(series, tmp_path):
    flow, mesh, states = series
    write_series(tmp_path, flow, mesh, LEVELS)
    assert len(entries(tmp_path)) == len(states)
    for (t, path), state in zip(entries(tmp_path), states.values(), strict=True):
        found = pv.read(path)
        assert t == state.t
        assert np.array_equal(found.points, state.x)
        assert set(found.point_data) == set(FIELDS)
        for name in FIELDS:
            assert np.array_equal(found.point_data[name], getattr(state, name))


def test_vtk_evaluates_the_same_curved_elements(series, tmp_path):
    """Its own map of each Lagrange triangle agrees with ours at points off the lattice."""
    _, mesh, states = series
    x = states[1].x
    write_vtu(tmp_path / "frame.vtu", mesh, states[1])
    found = pv.read(tmp_path / "frame.vtu")
    phi, _ = tabulate(mesh.degree, INSIDE)
    assert set(found.celltypes) == {pv.CellType.LAGRANGE_TRIANGLE}
    assert found.n_cells == len(mesh.cells)
    for e in (0, 7, len(mesh.cells) - 1):
        place, weights = np.zeros(3), np.zeros(len(mesh.cells[e]))
        for point, expected in zip(INSIDE, phi @ x[mesh.cells[e]], strict=True):
            found.GetCell(e).EvaluateLocation(mutable(0), (*point, 0.0), place, weights)
            # vtk interpolates in double precision: rounding of a sum of 15 terms.
            assert place == pytest.approx(expected, rel=0, abs=1e-12)


def test_a_polynomial_of_the_degree_of_the_elements_is_interpolated_exactly(degree, raised):
    """On flat elements; where pyvista looks, not in the nodes."""
    mesh, x = raised("torus", 30, 1)
    fine, _ = raised("torus", 30, degree)
    nodes = np.empty((fine.node_count, 3))
    phi, _ = tabulate(1, lattice(degree))
    nodes[fine.cells] = phi @ x[mesh.cells]

    def polynomial(y):
        return (0.3 + y @ np.array([1.0, -2.0, 0.5])) ** degree

    H, zero = polynomial(nodes), np.zeros(fine.node_count)
    surface = grid(fine, State(0.0, nodes, nodes, H, zero, nodes))
    cut = surface.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=3)
    assert cut.n_points > fine.node_count
    # vtk cuts in single precision; in a wrong order the nodes are off by the size of an element.
    bound = 1e-6 * np.abs(H).max()
    np.testing.assert_allclose(cut["H"], polynomial(cut.points), rtol=0, atol=bound)


def test_the_order_is_a_permutation_and_meets_the_middles_of_vtks_edges(degree):
    order = vtk_order(degree)
    assert sorted(order) == list(range(len(order)))
    corners = lattice(degree)[order][:3]
    for i in range(3):
        along = np.arange(1, degree)[:, None] / degree
        edge = corners[i] + along * (corners[(i + 1) % 3] - corners[i])
        at = slice(3 + i * (degree - 1), 3 + (i + 1) * (degree - 1))
        np.testing.assert_allclose(lattice(degree)[order][at], edge, atol=1e-15)


@pytest.mark.parametrize("degree", [1])
class TestSeries:
    def test_goes_on_without_writing_again_what_is_there(self, series, tmp_path):
        flow, mesh, _ = series
        write_series(tmp_path, flow, mesh, LEVELS[:2])
        before = {path: path.stat().st_mtime_ns for _, path in entries(tmp_path)}
        write_series(tmp_path, flow, mesh, LEVELS)
        times = [path.stat().st_mtime_ns for _, path in entries(tmp_path)]
        assert times[:2] == list(before.values()) and len(times) == 3

    def test_a_frame_that_cannot_be_written_leaves_what_there_was(
        self, series, tmp_path, monkeypatch
    ):
        flow, mesh, _ = series
        write_series(tmp_path, flow, mesh, LEVELS[:2])
        whole = entries(tmp_path)

        def full(*_):
            raise OSError("disk full")

        monkeypatch.setattr("esfem.common.files.os.replace", full)
        with pytest.raises(OSError, match="disk full"):
            write_series(tmp_path, flow, mesh, LEVELS)
        assert entries(tmp_path) == whole
        assert sorted((tmp_path / "vtu").iterdir()) == [path for _, path in whole]

    def test_goes_with_the_frames(self, series, tmp_path):
        flow, mesh, _ = series
        write_series(tmp_path, flow, mesh, LEVELS)
        remove_frames(tmp_path)
        assert stored_levels(tmp_path) == []
        assert not [*tmp_path.glob("*.pvd"), *tmp_path.glob("vtu/*")]
