"""The block solve: equal to a direct solve of the whole system, by either backend, repeatedly."""

import gc
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from esfem.solver.assembly import mass_matrix, stiffness_matrix
from esfem.solver.block_system import BlockSystem
from esfem.solver.geometry import geometry
from esfem.solver.krylov import KrylovFailure, NotFinite
from esfem.solver.reuse import Reuse
from esfem.solver.symmetric_solver import (
    BACKENDS,
    FactorisationError,
    symmetric_solver,
    symmetric_solver_name,
)

each_backend = pytest.mark.parametrize("backend", BACKENDS)


@pytest.fixture(params=[(1, 3.0), (2, 40.0), (2, 1e4), (3, 40.0)], ids=str)
def system(make_rough, request):
    """M, A on a rough torus, c, random a, b (N, 4), and a random F by weighted mass matrices."""
    degree, c = request.param
    return make_system(make_rough(degree), c)


def make_system(rough, c: float):
    rough.geo = geometry(rough.mesh, rough.x)
    rough.c, rough.M, rough.A = c, mass_matrix(rough.geo), stiffness_matrix(rough.geo)
    rng = np.random.default_rng(7)
    N = rough.mesh.node_count
    # Dual vectors: weigh by the mass matrix, as the loads of a step are.
    rough.a, rough.b = (rough.M @ rng.standard_normal((N, 4)) for _ in range(2))
    rough.a *= c
    scalar = mass_matrix(rough.geo, rng.uniform(-3, 0, rough.geo.dA.shape))
    entries = rng.uniform(-3, 3, (6, *rough.geo.dA.shape))
    blocks = [mass_matrix(rough.geo, weight) for weight in entries]
    tensor = [[blocks[[0, 1, 3, 1, 2, 4, 3, 4, 5][3 * i + j]] for j in range(3)] for i in range(3)]
    rough.F = sp.block_diag([scalar, sp.block_array(tensor)], format="csr")
    return rough


def stacked(columns: np.ndarray) -> np.ndarray:
    return columns.T.ravel()


def columns(vector: np.ndarray) -> np.ndarray:
    return vector.reshape(4, -1).T


def direct(s, F) -> tuple[np.ndarray, np.ndarray]:
    """u, w from the whole 8N x 8N matrix by SciPy."""
    M, A = (sp.block_diag([matrix] * 4) for matrix in (s.M, s.A))
    whole = sp.block_array([[s.c * M, -(A + F)], [A, M]], format="csc")
    solution = spsolve(whole, np.concatenate([stacked(s.a), stacked(s.b)]))
    u, w = np.split(solution, 2)
    return columns(u), columns(w)


def assert_close(result, expected, relative):
    np.testing.assert_allclose(result, expected, rtol=0, atol=relative * np.abs(expected).max())


class TestSolve:
    @each_backend
    def test_equals_direct_solve_of_whole_system(self, system, backend):
        block = BlockSystem(system.mesh.pattern, backend)
        block.factor(system.c, system.M, system.A)
        u, w = block.solve(system.a, system.b)
        expected_u, expected_w = direct(system, sp.csr_array(system.F.shape))
        # Two direct solvers, condition up to 1e5.
        assert_close(u, expected_u, 1e-10)
        assert_close(w, expected_w, 1e-10)

    @each_backend
    def test_satisfies_both_equations(self, system, backend):
        block = BlockSystem(system.mesh.pattern, backend)
        block.factor(system.c, system.M, system.A)
        u, w = block.solve(system.a, system.b)
        assert_close(system.c * (system.M @ u) - system.A @ w, system.a, 1e-11)
        assert_close(system.A @ u + system.M @ w, system.b, 1e-9)  # u is large against b

    def test_takes_any_number_of_columns(self, system):
        block = BlockSystem(system.mesh.pattern)
        block.factor(system.c, system.M, system.A)
        u, w = block.solve(system.a, system.b)
        for m in range(4):
            one_u, one_w = block.solve(system.a[:, m : m + 1], system.b[:, m : m + 1])
            assert_close(one_u[:, 0], u[:, m], 1e-12)
            assert_close(one_w[:, 0], w[:, m], 1e-12)

    def test_backends_agree(self, system):
        solutions = []
        for backend in BACKENDS:
            block = BlockSystem(system.mesh.pattern, backend)
            block.factor(system.c, system.M, system.A)
            solutions.append(np.hstack(block.solve(system.a, system.b)))
        assert_close(solutions[0], solutions[1], 1e-11)

    def test_leaves_its_arguments_alone(self, system):
        block = BlockSystem(system.mesh.pattern)
        before = [array.copy() for array in (system.M.data, system.A.data, system.a, system.b)]
        block.factor(system.c, system.M, system.A)
        block.solve(system.a, system.b)
        after = (system.M.data, system.A.data, system.a, system.b)
        for old, new in zip(before, after, strict=True):
            np.testing.assert_array_equal(new, old)


class TestSolveCoupled:
    @staticmethod
    def solve(s, backend=None, start=None, tolerance=1e-12):
        block = BlockSystem(s.mesh.pattern, backend)
        block.factor(s.c, s.M, s.A)
        w_start = np.zeros_like(s.w) if start is None else start
        return block.solve_coupled(
            s.a, s.b, lambda w: columns(s.F @ stacked(w)), w_start, tolerance
        )

    @each_backend
    def test_equals_direct_solve_of_whole_system(self, system, backend):
        solution = self.solve(system, backend)
        u, w = direct(system, system.F)
        # The stopping bound of GMRES has room for the rounding of the solve.
        assert_close(solution.u, u, 1e-9)
        assert_close(solution.w, w, 1e-9)

    def test_does_not_depend_on_the_start(self, system):
        first, second = self.solve(system), self.solve(system, start=100 * system.w)
        assert_close(second.u, first.u, 1e-9)
        assert_close(second.w, first.w, 1e-9)

    def test_exact_start_needs_no_iteration(self, system):
        w = direct(system, system.F)[1]
        assert self.solve(system, start=w, tolerance=1e-8).iterations == 0

    def test_looser_tolerance_needs_fewer_iterations(self, system):
        tight, loose = (self.solve(system, tolerance=tol) for tol in (1e-12, 1e-3))
        assert 0 < loose.iterations < tight.iterations

    def test_tolerance_below_rounding_ends_at_rounding(self, system):
        solution = self.solve(system, tolerance=0.0)
        assert_close(solution.w, direct(system, system.F)[1], 1e-9)

    def test_coupling_matters(self, system):
        """The tests above would see it if F were left out."""
        without = direct(system, sp.csr_array(system.F.shape))[1]
        with_F = direct(system, system.F)[1]
        assert np.abs(without - with_F).max() > 1e-3 * np.abs(with_F).max()

    @pytest.mark.parametrize("field", ["a", "b"])
    @pytest.mark.parametrize("value", [np.nan, np.inf])
    def test_non_finite_data_fail_by_name(self, system, field, value):
        getattr(system, field)[3, 2] = value
        with np.errstate(invalid="ignore"), pytest.raises(NotFinite, match="not finite"):
            self.solve(system)

    def test_non_finite_start_fails_by_name(self, system):
        with np.errstate(invalid="ignore"), pytest.raises(NotFinite, match="not finite"):
            self.solve(system, start=np.nan * system.w)

    def test_too_many_iterations_fail_by_name(self, system):
        system.F = system.F * 1e6
        with pytest.raises(KrylovFailure, match=r"residual above .* after 60 iterations"):
            self.solve(system)


class TestSolvePair:
    """Two weighted mass matrices couple (H, V), in both equations, to what is known of them."""

    @staticmethod
    def coupling(s):
        rng = np.random.default_rng(8)
        weights = rng.uniform(-3, 3, (2, *s.geo.dA.shape))
        return [mass_matrix(s.geo, weight) for weight in weights]

    def solve(self, s, backend=None, start=None, tolerance=1e-12):
        F1, L = self.coupling(s)
        block = BlockSystem(s.mesh.pattern, backend)
        block.factor(s.c, s.M, s.A)
        start = s.known if start is None else start

        def C(pair):
            return np.column_stack([F1 @ pair[:, 1], L @ pair[:, 0]])

        return block.solve_pair(s.a, s.b, C, s.known, start, tolerance)

    @pytest.fixture
    def system(self, system):
        system.known = np.random.default_rng(9).standard_normal((system.mesh.node_count, 2))
        return system

    def direct(self, s):
        """u, w from the whole matrix: all four pairs without coupling, then (H, V) with it."""
        u, w = direct(s, sp.csr_array(s.F.shape))
        F1, L = self.coupling(s)
        H, V = s.known.T
        whole = sp.block_array([[s.c * s.M, -(s.A + F1)], [s.A - L, s.M]], format="csc")
        right = np.concatenate([s.a[:, 0] - F1 @ V, s.b[:, 0] - L @ H])
        u[:, 0], w[:, 0] = np.split(spsolve(whole, right), 2)
        return u, w

    @each_backend
    def test_equals_direct_solve_of_whole_system(self, system, backend):
        solution = self.solve(system, backend)
        u, w = self.direct(system)
        assert_close(solution.u, u, 1e-9)
        assert_close(solution.w, w, 1e-9)
        assert solution.iterations > 0

    def test_does_not_depend_on_the_start(self, system):
        first, second = self.solve(system), self.solve(system, start=100.0 * system.known)
        assert_close(second.u, first.u, 1e-9)
        assert_close(second.w, first.w, 1e-9)

    def test_exact_start_needs_no_iteration(self, system):
        u, w = self.direct(system)
        start = np.column_stack([u[:, 0], w[:, 0]])
        assert self.solve(system, start=start, tolerance=1e-8).iterations == 0

    def test_what_agrees_with_what_is_known_needs_no_iteration(self, system):
        """Then the coupling, of the difference, is nothing."""
        u, w = direct(system, sp.csr_array(system.F.shape))
        system.known = np.column_stack([u[:, 0], w[:, 0]])
        assert self.solve(system, tolerance=1e-8).iterations == 0

    @pytest.mark.parametrize("field", ["a", "b"])
    def test_non_finite_data_fail_by_name(self, system, field):
        getattr(system, field)[3, 0] = np.nan
        with np.errstate(invalid="ignore"), pytest.raises(NotFinite, match="not finite"):
            self.solve(system)


class TestReuse:
    @each_backend
    def test_refactoring_forgets_the_old_values(self, make_rough, backend):
        old, new = make_system(make_rough(2), 5.0), make_system(make_rough(2), 70.0)
        new.M, new.A = (f(geometry(new.mesh, 1.3 * new.x)) for f in (mass_matrix, stiffness_matrix))
        block = BlockSystem(old.mesh.pattern, backend)
        block.factor(old.c, old.M, old.A)
        block.solve(old.a, old.b)
        block.factor(new.c, new.M, new.A)
        fresh = BlockSystem(new.mesh.pattern, backend)
        fresh.factor(new.c, new.M, new.A)
        np.testing.assert_allclose(
            np.hstack(block.solve(new.a, new.b)),
            np.hstack(fresh.solve(new.a, new.b)),
            rtol=0,
            atol=1e-12,  # the order of pivots may remember the first values
        )

    @each_backend
    def test_systems_alive_together_do_not_interfere(self, make_rough, backend):
        systems = [make_system(make_rough(k), c) for k, c in ((1, 2.0), (2, 9.0), (3, 50.0))]
        blocks = [BlockSystem(s.mesh.pattern, backend) for s in systems]
        for block, s in zip(blocks, systems, strict=True):
            block.factor(s.c, s.M, s.A)
        alone = []
        for s in systems:
            block = BlockSystem(s.mesh.pattern, backend)
            block.factor(s.c, s.M, s.A)
            alone.append(np.hstack(block.solve(s.a, s.b)))
            del block
        for i in (2, 0, 1, 0):
            result = np.hstack(blocks[i].solve(systems[i].a, systems[i].b))
            assert_close(result, alone[i], 1e-13)

    @each_backend
    def test_same_bits_twice(self, system, backend):
        results = []
        for _ in range(2):
            block = BlockSystem(system.mesh.pattern, backend)
            block.factor(system.c, system.M, system.A)
            results.append(np.hstack(block.solve(system.a, system.b)))
        np.testing.assert_array_equal(results[0], results[1])

    @each_backend
    def test_memory_is_given_back(self, make_rough, backend):
        """Forty systems of 8 MB or so: kept, they would take 300 MB."""
        s = make_system(make_rough(3), 10.0)

        def use(times: int) -> None:
            for _ in range(times):
                block = BlockSystem(s.mesh.pattern, backend)
                block.factor(s.c, s.M, s.A)
                block.solve(s.a, s.b)
            gc.collect()

        statm = Path("/proc/self/statm")
        if not statm.exists():
            pytest.skip("memory is read from /proc")

        def resident() -> int:
            return int(statm.read_text().split()[1]) * 4096

        use(10)
        before = resident()
        use(40)
        assert resident() - before < 10e6


class TestOlderFactors:
    """After a solve with its own factors, `renew` keeps them while they still do."""

    @staticmethod
    def solve(s, block, start=0.0):
        F = lambda w: columns(s.F @ stacked(w))  # noqa: E731
        w, u = start * s.w, start * s.u
        return block.solve_coupled(s.a, s.b, F, w, 1e-12, u)

    @staticmethod
    def moved(s, size: float):
        """The system on a surface moved by so much."""
        bent = s.x + size * np.sin(3.0 * s.x[:, [1, 2, 0]])
        return tuple(f(geometry(s.mesh, bent)) for f in (mass_matrix, stiffness_matrix))

    @each_backend
    @pytest.mark.parametrize("size", [0.0, 1e-4, 1e-2, 1.0])
    def test_the_solution_is_that_of_the_new_matrices(self, system, backend, size):
        block = BlockSystem(system.mesh.pattern, backend)
        block.renew(system.c, system.M, system.A)
        self.solve(system, block)
        system.M, system.A = self.moved(system, size)
        block.renew(system.c, system.M, system.A)
        solution = self.solve(system, block)
        u, w = direct(system, system.F)
        assert_close(solution.u, u, 1e-9)
        assert_close(solution.w, w, 1e-9)

    def test_are_kept_where_nothing_moves_and_given_up_where_all_does(self, system, monkeypatch):
        block, factored = BlockSystem(system.mesh.pattern), []
        factor = BlockSystem.factor
        monkeypatch.setattr(
            BlockSystem, "factor", lambda *args: (factored.append(1), factor(*args))
        )
        counts = []
        for size in (0.0, 0.0, 0.0, 1.0, 1.0):
            system.M, system.A = self.moved(system, size)
            block.renew(system.c, system.M, system.A)
            self.solve(system, block)
            counts.append(len(factored))
        assert counts[:3] == [1, 1, 1]
        assert counts[4] > 1

    def test_are_not_kept_for_a_solve_that_cannot_do_with_them(self, system):
        """The direct solve of an extrapolated step: on a surface moved a little it is exact."""
        block = BlockSystem(system.mesh.pattern)
        block.renew(system.c, system.M, system.A)
        self.solve(system, block)
        system.M, system.A = self.moved(system, 1e-2)
        block.renew(system.c, system.M, system.A, older=False)
        expected_u, expected_w = direct(system, sp.csr_array(system.F.shape))
        for found, expected in zip(
            block.solve(system.a, system.b), (expected_u, expected_w), strict=True
        ):
            assert_close(found, expected, 1e-9)

    def test_another_c_is_factored(self, system):
        block = BlockSystem(system.mesh.pattern)
        block.renew(system.c, system.M, system.A)
        self.solve(system, block)
        system.c *= 2.0
        block.renew(system.c, system.M, system.A)
        u, _ = block.solve(system.a, system.b)
        expected_u, _ = direct(system, sp.csr_array(system.F.shape))
        assert_close(u, expected_u, 1e-10)

    def test_those_that_fail_at_once_are_left_alone_for_a_while(self):
        reuse = Reuse()
        reuse.factored(4)
        assert reuse.promising
        reuse.reused(4 + Reuse.MORE)
        assert not reuse.promising
        tried = []
        for _ in range(Reuse.PAUSE + 1):
            reuse.factored(4)
            tried.append(reuse.promising)
        assert tried == [False] * Reuse.PAUSE + [True]


class TestBadInput:
    def test_unknown_backend_is_refused(self, system):
        with pytest.raises(
            ValueError, match="backend = 'umfpack': must be one of pardiso, superlu"
        ):
            BlockSystem(system.mesh.pattern, "umfpack")

    def test_default_backend_is_one_of_them(self):
        assert symmetric_solver_name() in BACKENDS

    def test_missing_mkl_is_named(self, system, monkeypatch):
        monkeypatch.setattr("esfem.solver.symmetric_solver.mkl", lambda: None)
        with pytest.raises(
            FactorisationError, match="mkl is not installed; allowed here: 'superlu'"
        ):
            symmetric_solver(system.mesh.pattern, "pardiso")

    def test_missing_mkl_falls_back_to_superlu(self, system, monkeypatch):
        monkeypatch.setattr("esfem.solver.symmetric_solver.mkl", lambda: None)
        assert type(symmetric_solver(system.mesh.pattern)) is BACKENDS["superlu"]

    def test_singular_matrix_fails_by_name(self, system):
        solver = symmetric_solver(system.mesh.pattern, "superlu")
        with pytest.raises(FactorisationError, match="SuperLU"):
            solver.factor(np.zeros(len(system.mesh.pattern.indices), dtype=complex))
