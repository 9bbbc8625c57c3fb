"""What exact nodal values leave in the equations: norms, exact cases, invariances, wrong forms."""

import numpy as np
import pytest
import scipy.sparse as sp

from esfem.measuring.residuals import (
    REACH,
    defects,
    derivative,
    dual_norms,
    residuals,
    start_of_w,
)
from esfem.meshes import surface_mesh
from esfem.reference_solutions import (
    BreathingEllipsoid,
    RoundTorus,
    ShrinkingSphere,
    StationarySphere,
)
from esfem.reference_solutions.laws import velocity
from esfem.runs.problem import law_of
from esfem.runs.run_case import computational_mesh
from esfem.solver import Mesh, Scheme, State
from esfem.solver.assembly import mass_matrix, stiffness_matrix
from esfem.solver.geometry import geometry
from esfem.solver.laws import velocity_law
from esfem.solver.system import assembled
from esfem.studies.case import Law

LAWS = {
    "willmore": Law(name="willmore"),
    "helfrich": Law(name="helfrich", spontaneous_curvature=1.0),
    "surface_diffusion": Law(name="surface_diffusion"),
}
each_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
# No law of another H0 is the scaled law of this one, but for that.
of_dimension = pytest.mark.parametrize("name", ["willmore", "surface_diffusion"])


def start_on(solution, V: int, k: int, law: Law) -> tuple[Mesh, State]:
    """The mesh, and the exact State with the V of the law."""
    mesh, p = computational_mesh(surface_mesh(solution.mesh_surface, V), solution, k)
    f = solution.fields(p, 0.0)
    return mesh, State(0.0, p, f.nu, f.H, velocity(law.name, law.parameters, f), f.z)


def scheme(law: Law, theta: bool = False) -> Scheme:
    return Scheme(law=velocity_law(law.name, **law.parameters), theta=theta)


def started(solution, V: int, k: int, law: Law, theta: bool = False) -> dict[str, float]:
    """The norms of the start, in those of unit R on the torus."""
    mesh, state = start_on(solution, V, k, law)
    return start_of_w(
        mesh, state, scheme(law, theta), solution.R if isinstance(solution, RoundTorus) else 1.0
    )


def left(solution, V: int, k: int, law: Law, t: float, tau: float = 0.05) -> dict[str, float]:
    """The norms of the defects at time t."""
    mesh, p = computational_mesh(surface_mesh(solution.mesh_surface, V), solution, k)
    return defects(mesh, p, solution, law_of(law, solution), tau, 1.0)(t)


def order(make, sizes=(120, 480)) -> dict[str, float]:
    """The order of each number between two meshes of twice the width, by that ratio."""
    coarse, fine = map(make, sizes)
    return {name: np.log2(coarse[name] / fine[name]) for name in coarse}


@pytest.fixture
def matrices() -> tuple[sp.csr_array, sp.csr_array]:
    """M and A of a small sphere."""
    mesh, p = computational_mesh(surface_mesh("sphere", 30), StationarySphere(), 2)
    geo = geometry(mesh, p)
    return mass_matrix(geo), stiffness_matrix(geo)


class TestDualNorm:
    def test_is_the_supremum_over_all_functions(self, matrices):
        """Longhand: max of (r, phi)^2 / |phi|^2 is the eigenvalue of r r^T against M / L^2 + A."""
        M, A = (matrix.toarray() for matrix in matrices)
        r = np.random.default_rng(0).standard_normal((len(M), 3))
        for length in (0.5, 1.0, 3.0):
            K = M / length**2 + A
            factor = np.linalg.inv(np.linalg.cholesky(K))
            expected = [
                np.sqrt(np.linalg.eigvalsh(factor @ np.outer(b, b) @ factor.T)[-1]) for b in r.T
            ]
            # Rounding, with matrices of condition 1e2.
            found = dual_norms(*matrices, r, length)
            np.testing.assert_allclose(found, expected, rtol=1e-12)

    def test_of_a_constant_is_its_L2_norm_times_L(self, matrices):
        """Constants are eigenvectors: (M / L^2 + A)^-1 M 1 = L^2 1."""
        M, A = matrices
        ones = np.ones((M.shape[0], 1))
        area = float((ones.T @ (M @ ones))[0, 0])
        for length in (0.25, 1.0, 2.0):
            np.testing.assert_allclose(
                dual_norms(M, A, M @ ones, length), length * np.sqrt(area), rtol=1e-12
            )

    def test_is_below_the_L2_norm_times_L(self, matrices):
        M, A = matrices
        d = np.random.default_rng(1).standard_normal((M.shape[0], 4))
        l2 = np.sqrt(np.einsum("jc,jc->c", d, M @ d))
        assert (dual_norms(M, A, M @ d, 0.7) < 0.7 * l2).all()


class TestDerivative:
    def test_is_exact_for_polynomials_of_degree_8(self):
        s = 0.1 * np.arange(-REACH, REACH + 1)
        for n in range(9):
            found = derivative(list((1.3 + s) ** n), 0.1)
            # Rounding over the step.
            np.testing.assert_allclose(found, n * 1.3 ** (n - 1), rtol=0, atol=1e-12)

    def test_is_not_exact_for_degree_9(self):
        s = 0.1 * np.arange(-REACH, REACH + 1)
        assert abs(derivative(list(s**9), 0.1)) > 1e-8


class TestStart:
    @each_law
    @pytest.mark.parametrize("k", [2, 3])
    def test_is_of_order_k_in_the_dual_norm_and_of_less_in_L2(self, k, law):
        """Bands of two meshes; no order is claimed in L^2 (k - 1) and in H^1 (k - 2)."""
        found = order(lambda V: started(RoundTorus(), V, k, law), (240, 960))
        for name in ("V", "z"):
            assert k - 0.2 < found[f"start_{name}"] < k + 0.9
            assert k - 1.3 < found[f"start_{name}_l2"] < k - 0.2
            assert k - 2.5 < found[f"start_{name}_h1"] < k - 1.0

    @each_law
    @pytest.mark.parametrize("k", [1, 2, 3, 4])
    def test_with_theta_is_the_interpolation(self, k, law):
        """To rounding of M^-1, times h^-1 in H^1."""
        found = started(RoundTorus(), 60, k, law, theta=True)
        assert all(
            value < (1e-12 if name.endswith("h1") else 1e-13) for name, value in found.items()
        )

    @pytest.mark.parametrize("name", ["willmore", "surface_diffusion"])
    @pytest.mark.parametrize("k", [2, 3])
    def test_of_V_is_zero_on_spheres(self, k, name):
        """nu_h = x_h there, so that |S_h|^2 = 2, Q_h = 0, and H is constant."""
        found = started(StationarySphere(), 60, k, LAWS[name])
        assert found["start_V"] < 1e-12 < 1e-4 < found["start_z"]

    @of_dimension
    def test_scales_like_a_length_to_the_power_minus_one_and_zero(self, name):
        """V like L^-3, z like L^-2, the dual norm L^2 more, L^2 and H^1 L and none more."""
        one, two = (started(RoundTorus(a, 0.6 * a), 60, 2, LAWS[name]) for a in (1.0, 4.0))
        powers = {"": 2, "_l2": 1, "_h1": 0}
        for which, of_norm in powers.items():
            for variable, own in (("V", -3), ("z", -2)):
                key = f"start_{variable}{which}"
                np.testing.assert_allclose(two[key] / one[key], 4.0 ** (own + of_norm), rtol=1e-9)

    def test_does_not_depend_on_the_numbers_of_the_nodes(self):
        mesh, state = start_on(RoundTorus(), 60, 3, LAWS["helfrich"])
        order = np.random.default_rng(0).permutation(mesh.node_count)
        vertices = order < mesh.vertex_count  # vertices stay the first
        order = np.concatenate([order[vertices], order[~vertices]])
        number = np.argsort(order)
        other = Mesh(mesh.degree, number[mesh.triangles], number[mesh.cells], mesh.node_count)
        again = State(0.0, *(getattr(state, n)[order] for n in ("x", "nu", "H", "V", "z")))
        found = start_of_w(other, again, scheme(LAWS["helfrich"]), 1.0)
        expected = start_of_w(mesh, state, scheme(LAWS["helfrich"]), 1.0)
        # Sums in another order; the norms are 1e-2 of what cancels.
        assert found == pytest.approx(expected, rel=1e-9)

    def test_does_not_depend_on_a_rotation(self):
        mesh, state = start_on(RoundTorus(), 60, 3, LAWS["helfrich"])
        R = np.linalg.qr(np.random.default_rng(2).standard_normal((3, 3)))[0]
        R *= np.sign(np.linalg.det(R))
        turned = State(0.0, state.x @ R.T, state.nu @ R.T, state.H, state.V, state.z @ R.T)
        found = start_of_w(mesh, turned, scheme(LAWS["helfrich"]), 1.0)
        expected = start_of_w(mesh, state, scheme(LAWS["helfrich"]), 1.0)
        assert found == pytest.approx(expected, rel=1e-9)

    @pytest.mark.parametrize(
        "wrong",
        [
            lambda H, S2, x, t: 0.5 * H**2 * (H - 1.0) - 0.5 * H * (H - 1.0) ** 2,
            lambda H, S2, x, t: (
                S2 * (H - 1.0) - 0.5 * H * (H - 1.0) ** 2 + 3 * (S2 - H**2 / 2) ** 2
            ),
        ],
        ids=["H^2/2 for |S|^2", "a term that spheres do not have"],
    )
    def test_a_wrong_law_that_is_right_on_spheres_does_not_converge(self, wrong):
        def make(solution, V):
            mesh, state = start_on(solution, V, 3, LAWS["helfrich"])
            return start_of_w(mesh, state, Scheme(law=wrong), 1.0)["start_V"]

        assert make(RoundTorus(), 480) > 0.9 * make(RoundTorus(), 120)
        assert make(StationarySphere(), 120) < 1e-4


class TestDefects:
    BREATHING = BreathingEllipsoid()

    @each_law
    def test_are_of_order_k_with_their_derivatives(self, law):
        for name, found in order(lambda V: left(self.BREATHING, V, 3, law, 0.1)).items():
            assert 2.7 < found < 3.4, name

    def test_of_w_are_the_error_of_the_start(self):
        law, solution = LAWS["willmore"], self.BREATHING
        mesh, p = computational_mesh(surface_mesh("sphere", 60), solution, 3)
        f = solution.fields(p, 0.0)
        state = State(0.0, p, f.nu, f.H, f.V, f.z)
        start = start_of_w(mesh, state, Scheme(law=law_of(law, solution)), 1.0)
        defect = defects(mesh, p, solution, law_of(law, solution), 0.05, 1.0)(0.0)
        for name in ("V", "z"):
            assert defect[f"defect_{name}"] == pytest.approx(start[f"start_{name}"], rel=1e-9)

    @pytest.mark.parametrize("k", [2, 3])
    def test_are_zero_on_a_sphere_at_rest_but_for_z(self, k):
        """u and w are exact there, and only |S_h|^2 nu_h misses A nu_h."""
        found = left(StationarySphere(), 60, k, LAWS["willmore"], 0.0)
        for name, value in found.items():
            rests = name != "defect_z"
            # Rounding, over the step of the differences for the derivatives.
            assert value < 1e-9 if rests else value > 1e-4, name

    def test_on_a_shrinking_sphere_follow_the_radius(self):
        """In norms with L = r that of z has the power 0 of r, and so is the same at all times."""
        solution = ShrinkingSphere()
        mesh, p = computational_mesh(surface_mesh("sphere", 60), solution, 2)
        law = velocity_law("surface_diffusion")
        found = {}
        for t in (0.05, 0.1):
            r = float(np.linalg.norm(solution.trajectories(p)(t)[0]))
            found[t] = defects(mesh, p, solution, law, 0.01, r)(t)["defect_z"]
        assert found[0.1] == pytest.approx(found[0.05], rel=1e-9)

    def test_do_not_depend_on_the_step_of_the_differences(self):
        whole, half = (
            left(self.BREATHING, 120, 4, LAWS["willmore"], 0.1, tau) for tau in (0.05, 0.025)
        )
        assert whole == pytest.approx(half, rel=1e-4)

    @pytest.mark.parametrize(
        ("part", "equation"),
        [("f", "nu"), ("g", "V"), ("g", "z")],
    )
    def test_a_load_that_is_doubled_is_seen_in_its_equation(self, part, equation):
        solution, law = self.BREATHING, law_of(LAWS["willmore"], self.BREATHING)
        columns = {"H": 0, "nu": slice(1, 4), "V": 4, "z": slice(5, 8)}
        sizes = []
        for V in (60, 240):
            mesh, p = computational_mesh(surface_mesh("sphere", V), solution, 2)
            x = solution.trajectories(p)(0.1)
            f = solution.fields(x, 0.1)
            u, w = np.column_stack([f.H, f.nu]), np.column_stack([f.V, f.z])
            on = assembled(mesh, x, u, law, 0.1, None)
            steps = 0.025 * np.arange(-REACH, REACH + 1)
            values = []
            for s in steps:
                y = solution.trajectories(p)(0.1 + s)
                fields = solution.fields(y, 0.1 + s)
                values.append(np.column_stack([fields.H, fields.nu]))
            r = residuals(on, u, derivative(values, 0.025), w)
            shift = np.hstack([on.f, np.zeros_like(on.f)] if part == "f" else [0 * on.g, on.g])
            norms = [dual_norms(on.M, on.A, b, 1.0) for b in (r, r + shift)]
            sizes.append([np.linalg.norm(n[columns[equation]]) for n in norms])
        (right, wrong), (right_fine, wrong_fine) = sizes
        assert right / right_fine > 3.0
        assert 0.9 < wrong / wrong_fine < 1.1
