"""Files for ParaView, read back with vtk: times, points, fields, and curved elements in order."""

import numpy as np
import pytest

vtk = pytest.importorskip("vtk")
pytest.importorskip("h5py")
from vtk.util.numpy_support import vtk_to_numpy  # noqa: E402

from harness.flows.fields import shown  # noqa: E402
from harness.flows.vtk_cells import vtk_order  # noqa: E402
from harness.flows.vtkhdf import write_vtkhdf  # noqa: E402
from harness.flows.vtu import write_pvd  # noqa: E402
from solver import State  # noqa: E402
from solver.reference_element import lattice, tabulate  # noqa: E402

DEGREES = (1, 2, 3, 4)
TIMES = (0.0, 0.125, 0.375)
# Off the lattice of every degree, unsymmetric, and the middles of the edges.
INSIDE = np.array([[0.5, 0.0], [0.5, 0.5], [0.0, 0.5], [0.1, 0.2], [0.23, 0.61], [0.7, 0.13]])


@pytest.fixture(params=DEGREES)
def flow(request, raised):
    """A mesh of that degree, and States on it that differ in everything."""
    mesh, x = raised("torus", 30, request.param)
    rng = np.random.default_rng(request.param)
    N = mesh.node_count

    def state(t: float) -> State:
        vectors = [rng.standard_normal((N, 3)) for _ in range(3)]
        scalars = [rng.standard_normal(N) for _ in range(2)]
        return State(t, (1.0 + t) * x + 0.01 * vectors[0], vectors[1], *scalars, vectors[2])

    return mesh, [state(t) for t in TIMES]


def read_hdf(path, i):
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(TIMES)
    reader.SetStep(i)
    reader.Update()
    return reader.GetOutput(), reader.GetTimeValue()


def read_vtu(path, i):
    from xml.etree import ElementTree

    frame = list(ElementTree.parse(path).iter("DataSet"))[i]
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path.parent / frame.get("file")))
    reader.Update()
    return reader.GetOutput(), float(frame.get("timestep"))


FORMATS = {
    "flow.vtkhdf": (write_vtkhdf, read_hdf),
    "flow.pvd": (write_pvd, read_vtu),
}


@pytest.fixture(params=FORMATS)
def read_back(request, flow, tmp_path):
    """Each step: the State that was written, the grid and the time that were read."""
    mesh, states = flow
    write, read = FORMATS[request.param]
    path = tmp_path / request.param
    write(path, mesh, iter(states))
    return mesh, [(state, *read(path, i)) for i, state in enumerate(states)]


def test_times_points_and_fields_read_back_to_the_last_bit(read_back):
    _, steps = read_back
    for state, grid, t in steps:
        assert t == state.t
        assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), state.x)
        for name, field in shown(state).items():
            assert np.array_equal(vtk_to_numpy(grid.GetPointData().GetArray(name)), field)


def test_vtk_evaluates_the_same_curved_elements(read_back):
    """vtk's own map of each Lagrange triangle agrees with ours at points off the lattice."""
    mesh, steps = read_back
    phi, _ = tabulate(mesh.degree, INSIDE)
    for state, grid, _ in steps:
        assert grid.GetNumberOfCells() == len(mesh.cells)
        for e in (0, 7, len(mesh.cells) - 1):
            cell = grid.GetCell(e)
            assert cell.GetCellType() == vtk.VTK_LAGRANGE_TRIANGLE
            found, weights = np.zeros(3), np.zeros(len(mesh.cells[e]))
            for point, expected in zip(INSIDE, phi @ state.x[mesh.cells[e]], strict=True):
                cell.EvaluateLocation(vtk.mutable(0), (*point, 0.0), found, weights)
                # vtk interpolates in double precision: rounding of a sum of 15 terms.
                assert found == pytest.approx(expected, rel=0, abs=1e-12)


@pytest.mark.parametrize("degree", DEGREES)
def test_the_order_is_a_permutation_and_meets_the_middles_of_vtks_edges(degree):
    order = vtk_order(degree)
    assert sorted(order) == list(range(len(order)))
    corners = lattice(degree)[order][:3]
    for i in range(3):
        along = np.arange(1, degree)[:, None] / degree
        edge = corners[i] + along * (corners[(i + 1) % 3] - corners[i])
        at = slice(3 + i * (degree - 1), 3 + (i + 1) * (degree - 1))
        np.testing.assert_allclose(lattice(degree)[order][at], edge, atol=1e-15)


def test_a_file_that_cannot_be_finished_leaves_the_one_before(flow, tmp_path):
    mesh, states = flow
    path = tmp_path / "flow.vtkhdf"
    write_vtkhdf(path, mesh, states)
    before = path.read_bytes()

    def broken():
        yield states[0]
        raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        write_vtkhdf(path, mesh, broken())
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["flow.vtkhdf"]
