"""The system of a step: patches change nothing, nor do threads."""

import numpy as np
import pytest
import scipy.sparse as sp

from esfem.solver import Mesh, forms, mesh
from esfem.solver.assembly import mass_matrix, stiffness_matrix
from esfem.solver.geometry import geometry
from esfem.solver.laws import willmore
from esfem.solver.system import System, assembled


@pytest.fixture
def system(make_rough, monkeypatch):
    """Makes the system of a rough torus of degree k with so many elements times nodes a patch."""

    def make(degree: int, patch: int) -> tuple[System, object]:
        monkeypatch.setattr(mesh, "PATCH", patch)
        rough = make_rough(degree)
        topology = Mesh(degree, rough.mesh.triangles, rough.mesh.cells, rough.mesh.node_count)
        return assembled(topology, rough.x, rough.u, willmore, 0.0, None), rough

    return make


def test_patches_are_all_elements_once(system):
    on, _ = system(2, 30)
    patches = on.mesh.patches
    assert len(patches) > 5
    np.testing.assert_array_equal(np.concatenate([p.cells for p in patches]), on.mesh.cells)


@pytest.mark.parametrize("patch", [30, 10**9])
@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_sums_over_patches_are_those_over_the_surface(system, degree, patch):
    """The same sums in another order: equal to rounding."""
    on, rough = system(degree, patch)
    geo = geometry(rough.mesh, rough.x)
    curvature = forms.curvature(geo, rough.u, willmore, 0.0)
    f, g = forms.loads(geo, curvature)
    pairs = [
        (on.M, mass_matrix(geo)),
        (on.A, stiffness_matrix(geo)),
        (on.f, f),
        (on.g, g),
        (on.F(rough.w), forms.F(geo, curvature, rough.w)),
    ]
    for found, expected in pairs:
        if sp.issparse(found):
            found, expected = found.toarray(), expected.toarray()
        size = abs(expected).max()
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * size)


def test_threads_change_no_bit(system, monkeypatch):
    on, rough = system(2, 30)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    again, _ = system(2, 30)
    for found, expected in [(again.M.data, on.M.data), (again.f, on.f), (again.g, on.g)]:
        np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(again.F(rough.w), on.F(rough.w))
