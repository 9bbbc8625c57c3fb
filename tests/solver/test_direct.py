"""Direct solution with real matrices: both solvers, and what cannot be factored."""

import numpy as np
import pytest
import scipy.sparse as sp

from esfem.solver.direct import factored
from esfem.solver.krylov import NotFinite
from esfem.solver.symmetric_solver import symmetric_solver_name


@pytest.fixture(params=["pardiso", "superlu"])
def solver(request, monkeypatch):
    if request.param == "superlu":
        monkeypatch.setattr("esfem.solver.symmetric_solver.mkl", lambda: None)
    elif symmetric_solver_name() != "pardiso":
        pytest.skip("mkl is not installed")
    return factored


def unsymmetric(N: int = 60) -> sp.csr_array:
    rng = np.random.default_rng(0)
    return sp.csr_array(sp.random_array((N, N), density=0.1, rng=rng) + 4 * sp.eye_array(N))


@pytest.mark.parametrize("shape", [(60,), (60, 3)])
def test_solves_with_every_right_hand_side(solver, shape):
    K, x = unsymmetric(), np.random.default_rng(1).standard_normal(shape)
    # Condition about ten.
    np.testing.assert_allclose(solver(K)(K @ x), x, rtol=0, atol=1e-12)


def test_solves_saddle_points(solver):
    """Zeros on the diagonal, as in the block systems of the schemes."""
    K = sp.block_array([[None, unsymmetric()], [unsymmetric().T, None]], format="csr")
    x = np.arange(120.0)
    np.testing.assert_allclose(solver(K)(K @ x), x, rtol=0, atol=1e-9)


def test_matrix_that_is_not_finite_is_refused(solver):
    K = unsymmetric()
    K.data[3] = np.nan
    with pytest.raises(NotFinite, match="not finite"):
        solver(K)


def test_earlier_factors_survive_later_ones(solver):
    K, x = unsymmetric(), np.arange(60.0)
    first = solver(K)
    solver(2 * K)
    np.testing.assert_allclose(first(K @ x), x, rtol=0, atol=1e-11)
