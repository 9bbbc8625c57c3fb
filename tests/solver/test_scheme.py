"""One step: symmetries of the flow, the correction theta, the projection, and a longhand step."""

from dataclasses import replace
from itertools import product

import longhand
import numpy as np
import pytest
from scipy.stats import ortho_group

from esfem.solver import BDF, Levels, Mesh, Scheme, State, evolve, forms
from esfem.solver.assembly import mass_matrix, stiffness_matrix
from esfem.solver.bdf import combine, predicted
from esfem.solver.block_system import BlockSystem
from esfem.solver.geometry import geometry
from esfem.solver.laws import velocity_law, willmore
from esfem.solver.reaction import REACTIONS
from esfem.solver.scheme import consistent_w, correction, step, unit

TAU = 1e-3
FIELDS = ("x", "nu", "H", "V", "z")

each_scheme = pytest.mark.parametrize(
    ("k", "project", "theta", "reaction"),
    [
        *product((2, 3), (True, False), (True, False), ("linearised",)),
        *product((2,), (True, False), (True,), ("implicit", "extrapolated")),
    ],
)


@pytest.fixture(scope="module")
def start(raised, torus):
    """A mesh and a state near the torus R = 1, r = 0.6, without any symmetry left."""

    def make(k: int, seed: int = 0, t: float = 0.0) -> tuple[Mesh, State]:
        mesh, x = raised("torus", 60, k)
        f = torus.fields(x)
        rng = np.random.default_rng(seed)
        bend = x + 0.05 * np.sin(x @ rng.standard_normal((3, 3)))
        nu = unit(f.nu + 0.05 * np.cos(x @ rng.standard_normal((3, 3))))
        H = f.H + 0.1 * np.sin(x @ rng.standard_normal(3))
        return mesh, State(t, bend, nu, H, f.V, f.z)

    return make


def run(mesh: Mesh, state: State, scheme: Scheme, steps: int, tau: float = TAU) -> State:
    return list(evolve(mesh, state, scheme, Levels.equal(tau, steps)))[-1]


def tight(project: bool, theta: bool, q: int = 2, reaction: str = "linearised") -> Scheme:
    """So tight a tolerance that GMRES, which sees norms of w, does not break a symmetry."""
    return Scheme(
        bdf=BDF.of_order(q), project=project, theta=theta, tolerance=1e-13, reaction=reaction
    )


def assert_same(result: State, expected: State, relative: float = 1e-9) -> None:
    """Rounding times the condition of a step, about 1e5; measured 1e-11."""
    for name in FIELDS:
        a, b = getattr(result, name), getattr(expected, name)
        np.testing.assert_allclose(a, b, rtol=0, atol=relative * np.abs(b).max(), err_msg=name)


class TestSymmetry:
    """BDF2 that starts itself, two steps and four: the flow knows no coordinates and no numbers."""

    @each_scheme
    @pytest.mark.parametrize("steps", [2, 4])
    def test_rotation(self, start, k, project, theta, reaction, steps):
        mesh, s = start(k)
        R = ortho_group.rvs(3, random_state=1)
        R *= np.sign(np.linalg.det(R))

        def turned(s):
            return replace(s, x=s.x @ R.T, nu=s.nu @ R.T, z=s.z @ R.T)

        scheme = tight(project, theta, 2, reaction)
        assert_same(run(mesh, turned(s), scheme, steps), turned(run(mesh, s, scheme, steps)))

    @each_scheme
    @pytest.mark.parametrize("steps", [2, 4])
    def test_translation(self, start, k, project, theta, reaction, steps):
        mesh, s = start(k)

        def moved(s):
            return replace(s, x=s.x + np.array([2.0, -1.0, 0.5]))

        scheme = tight(project, theta, 2, reaction)
        assert_same(run(mesh, moved(s), scheme, steps), moved(run(mesh, s, scheme, steps)))

    @each_scheme
    @pytest.mark.parametrize("steps", [2, 4])
    def test_renumbering(self, start, k, project, theta, reaction, steps):
        mesh, s = start(k)
        rng = np.random.default_rng(2)
        old, elements = rng.permutation(mesh.node_count), rng.permutation(len(mesh.cells))
        new = np.argsort(old)
        cells = new[mesh.cells[elements]]
        other = Mesh(k, cells[:, :3], cells, mesh.node_count)

        def shuffled(s):
            return replace(s, **{name: getattr(s, name)[old] for name in FIELDS})

        scheme = tight(project, theta, 2, reaction)
        assert_same(run(other, shuffled(s), scheme, steps), shuffled(run(mesh, s, scheme, steps)))

    @each_scheme
    @pytest.mark.parametrize("steps", [2, 4])
    def test_scaling(self, start, k, project, theta, reaction, steps):
        """x -> l x and t -> l^4 t take H, V, z to H / l, V / l^3, z / l^2."""
        mesh, s = start(k)
        l = 1.7

        def large(s):
            return State(l**4 * s.t, l * s.x, s.nu, s.H / l, s.V / l**3, s.z / l**2)

        scheme = tight(project, theta, 2, reaction)
        result = run(mesh, large(s), scheme, steps, l**4 * TAU)
        expected = large(run(mesh, s, scheme, steps))
        assert_same(result, expected)
        assert result.t == pytest.approx(expected.t, rel=1e-14, abs=0)

    def test_a_step_moves_every_field(self, start):
        """The tests above would see a step that does nothing."""
        mesh, s = start(2)
        after = run(mesh, s, tight(True, False), 1)
        for name in FIELDS:
            assert np.abs(getattr(after, name) - getattr(s, name)).max() > 1e-3


class TestTheta:
    @pytest.mark.parametrize("k", [1, 2, 3, 4])
    def test_makes_exact_w_the_initial_value(self, start, k):
        """M w0 + A u0 = g + theta."""
        mesh, s = start(k)
        theta = correction(mesh, s, Scheme(theta=True))
        geo = geometry(mesh, s.x)
        _, g = forms.loads(geo, forms.curvature(geo, s.u, willmore, 0.0))
        left = mass_matrix(geo) @ s.w + stiffness_matrix(geo) @ s.u
        np.testing.assert_allclose(g + theta, left, rtol=0, atol=1e-13 * np.abs(left).max())

    def test_knows_the_law_and_the_time(self, start):
        mesh, s = start(2, t=2.0)

        def law(H, S2, x, t):
            return willmore(H, S2, x, t) + t

        ones = mass_matrix(geometry(mesh, s.x)) @ np.ones(mesh.node_count)
        difference = correction(mesh, s, Scheme(theta=True)) - correction(
            mesh, s, Scheme(theta=True, law=law)
        )
        np.testing.assert_allclose(difference[:, 0], 2.0 * ones, rtol=0, atol=1e-13)
        np.testing.assert_array_equal(difference[:, 1:], 0.0)

    def test_is_zero_when_off(self, start):
        mesh, s = start(2)
        np.testing.assert_array_equal(correction(mesh, s, Scheme(theta=False)), 0.0)

    @pytest.mark.parametrize("theta", [True, False])
    def test_small_step_keeps_w_only_with_it(self, start, theta):
        """As tau -> 0 the first w tends to w0 with theta, and to another w without."""
        mesh, s = start(2)
        change = [
            np.abs(run(mesh, s, Scheme(project=False, theta=theta), 1, tau).w - s.w).max()
            for tau in (1e-9, 1e-10)
        ]
        if theta:
            assert 5 < change[0] / change[1] < 15  # O(tau)
        else:
            assert min(change) > 1


class TestConsistentW:
    @pytest.mark.parametrize("k", [1, 2, 3])
    def test_needs_no_correction(self, start, k):
        """With that w, theta is zero."""
        mesh, s = start(k)
        w = consistent_w(mesh, s, Scheme())
        theta = correction(mesh, replace(s, V=w[:, 0], z=w[:, 1:]), Scheme(theta=True))
        scale = np.abs(stiffness_matrix(geometry(mesh, s.x)) @ s.u).max()
        np.testing.assert_allclose(theta, 0.0, rtol=0, atol=1e-12 * scale)


class TestProjection:
    @pytest.mark.parametrize("q", [1, 2])
    def test_normalises_nu(self, start, q):
        mesh, s = start(2)
        after = run(mesh, s, tight(True, False, q), 3)
        np.testing.assert_allclose(np.linalg.norm(after.nu, axis=1), 1.0, rtol=0, atol=1e-14)

    @pytest.mark.parametrize("q", [1, 2])
    def test_makes_z_tangential(self, start, q):
        mesh, s = start(2)
        after = run(mesh, s, tight(True, False, q), 3)
        along = np.einsum("ja,ja->j", after.z, after.nu)
        np.testing.assert_allclose(along, 0.0, rtol=0, atol=1e-14 * np.abs(after.z).max())

    def test_off_leaves_both_free(self, start):
        mesh, s = start(2)
        after = run(mesh, s, tight(False, False), 3)
        assert np.abs(np.linalg.norm(after.nu, axis=1) - 1).max() > 1e-4
        assert np.abs(np.einsum("ja,ja->j", after.z, after.nu)).max() > 1e-4


class TestLonghandStep:
    """Against dense loops over everything, with random theta and histories that are no solution."""

    @pytest.mark.parametrize(
        ("delta", "gamma", "k", "project"),
        [
            ([1.0, -1.0], [1.0], 2, False),
            ([1.5, -2.0, 0.5], [2.0, -1.0], 1, True),
            ([11 / 6, -3.0, 1.5, -1 / 3], [3.0, -3.0, 1.0], 2, True),
        ],
        ids=["BDF1", "BDF2", "BDF3"],
    )
    @pytest.mark.parametrize("reaction", REACTIONS)
    def test_step(self, make_rough, torus, delta, gamma, k, project, reaction):
        rough, q = make_rough(k), len(gamma)
        mesh, rng = rough.mesh, np.random.default_rng(3)
        f = torus.fields(rough.x)
        history = []
        for j in range(q):
            noise, w = rng.standard_normal((2, mesh.node_count, 4))
            u = np.column_stack([f.H, f.nu]) + 0.05 * noise
            x = rough.x + 0.003 * rng.standard_normal(rough.x.shape)
            history.append(State(-j * TAU, x, u[:, 1:], u[:, 0], w[:, 0], w[:, 1:]))
        theta = 0.01 * rng.standard_normal((mesh.node_count, 4))
        block, scheme = BlockSystem(mesh.pattern), tight(project, True, q, reaction)
        result = step(mesh, block, history, TAU, TAU, scheme, theta)
        past = [(s.x, s.u, s.w) for s in history]
        x, u, w = longhand.step(mesh, past, TAU, delta, gamma, theta, project, reaction)
        assert_same(result, State(TAU, x, u[:, 1:], u[:, 0], w[:, 0], w[:, 1:]))

    def test_krylov_starts_from_extrapolated_w(self, start):
        """Where the extrapolated w solves the system already there is nothing to iterate for."""
        mesh, s = start(2)
        theta = np.zeros((mesh.node_count, 4))
        scheme = replace(tight(False, False, 1, "implicit"), tolerance=1e-8)
        tightly, block = replace(scheme, tolerance=1e-12), BlockSystem(mesh.pattern)
        first = step(mesh, block, [s], TAU, TAU, tightly, theta)
        solved, block = replace(s, V=first.V, z=first.z), BlockSystem(mesh.pattern)
        again = step(mesh, block, [solved], TAU, TAU, scheme, theta)
        assert first.work.iterations > 0
        assert again.work.iterations == 0

    def test_extrapolated_is_one_solve(self, start):
        mesh, s = start(2)
        assert run(mesh, s, tight(True, True, 1, "extrapolated"), 1).work.iterations == 0

    @pytest.mark.parametrize("reaction", REACTIONS)
    def test_a_surface_at_rest_in_the_discrete_sense_stays(self, raised, reaction):
        """With theta the sphere's H, V = 0 and z = 0 solve the equations, whatever the reaction."""
        mesh, x = raised("sphere", 60, 2)
        zero = np.zeros(len(x))
        s = State(0.0, x, x, zero + 2.0, zero, 0.0 * x)
        after = run(mesh, s, tight(True, True, 2, reaction), 3, 0.01)
        np.testing.assert_allclose(after.H, 2.0, rtol=0, atol=1e-10)
        np.testing.assert_allclose(after.V, 0.0, rtol=0, atol=1e-10)

    def test_another_reaction_is_refused(self):
        with pytest.raises(ValueError, match=r"reaction = 'lagged': must be one of implicit, "):
            Scheme(reaction="lagged")

    def test_uses_only_the_last_q_states(self, start):
        mesh, s = start(2)
        theta, scheme = np.zeros((mesh.node_count, 4)), Scheme()
        older = replace(s, x=np.nan * s.x)
        first = step(mesh, BlockSystem(mesh.pattern), [s], TAU, TAU, scheme, theta)
        second = step(mesh, BlockSystem(mesh.pattern), [s, older], TAU, TAU, scheme, theta)
        np.testing.assert_array_equal(second.x, first.x)

    @pytest.mark.parametrize("backend", ["pardiso", "superlu"])
    def test_law_is_evaluated_at_the_new_time(self, start, backend):
        mesh, s = start(1)
        times = []

        def law(H, S2, x, t):
            times.append(t)
            return willmore(H, S2, x, t)

        theta = np.zeros((mesh.node_count, 4))
        block = BlockSystem(mesh.pattern, backend)
        step(mesh, block, [s], 0.25, TAU, Scheme(law=law), theta)
        assert set(times) == {0.25}

    def test_leaves_the_history_alone(self, start):
        mesh, s = start(2)
        before = {name: getattr(s, name).copy() for name in FIELDS}
        run(mesh, s, tight(True, True), 2)
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(s, name), before[name])


class TestGuess:
    @pytest.mark.parametrize("degree", [0, 1, 3, 4])
    def test_polynomials_are_continued_exactly(self, degree):
        coefficients = np.random.default_rng(0).standard_normal((degree + 1, 7))
        values = [sum(c * t**i for i, c in enumerate(coefficients)) for t in range(7)]
        guess = predicted(values[5::-1])
        np.testing.assert_allclose(guess, values[6], rtol=1e-12, atol=1e-10)

    def test_noise_is_not_amplified(self):
        """The last value then is a better guess than any polynomial through many."""
        noise = np.random.default_rng(0).standard_normal((6, 1000))
        assert np.linalg.norm(predicted(list(1.0 + 1e-6 * noise)) - 1.0) < 1e-4

    def test_slack_saves_iterations_within_the_error_in_time(self, start):
        mesh, s = start(2)
        scheme, steps, tau = tight(True, False), 8, 1e-4
        exact = run(mesh, s, scheme, 4 * steps, tau / 4)
        lax = replace(scheme, slack=0.01)
        states = [list(evolve(mesh, s, one, Levels.equal(tau, steps))) for one in (scheme, lax)]
        work = [sum(state.work.iterations for state in run) for run in states]
        error, change = (
            np.linalg.norm(states[0][-1].x - other) for other in (exact.x, states[1][-1].x)
        )
        assert work[1] < work[0]
        assert 0 < change < 0.01 * error


class TestState:
    def test_stacks_its_fields(self, start):
        _, s = start(1)
        np.testing.assert_array_equal(s.u, np.hstack([s.H[:, None], s.nu]))
        np.testing.assert_array_equal(s.w, np.hstack([s.V[:, None], s.z]))

    def test_velocity_is_the_nodewise_product(self, start):
        _, s = start(1)
        for j in range(len(s.x)):
            np.testing.assert_array_equal(s.v[j], s.V[j] * s.nu[j])

    def test_work_counts_iterations_and_seconds(self, start):
        mesh, s = start(2)
        work = run(mesh, s, Scheme(), 1).work
        assert work.iterations > 0
        assert set(work.seconds) == {"assembly", "factorisation", "krylov", "rest"}
        assert min(work.seconds.values()) >= 0

    def test_combine_is_the_linear_combination(self):
        a, b = np.arange(3.0), np.ones(3)
        np.testing.assert_array_equal(combine([2.0, -1.0], [a, b]), [-1.0, 1.0, 3.0])

    def test_combine_wants_as_many_vectors_as_coefficients(self):
        with pytest.raises(ValueError, match="zip"):
            combine([2.0, -1.0], [np.ones(3)])


class TestLaws:
    def test_law_of_another_name_changes_the_flow(self, start):
        mesh, s = start(2)
        results = [
            run(mesh, s, Scheme(law=velocity_law(name, **parameters)), 1).x
            for name, parameters in (
                ("willmore", {}),
                ("surface_diffusion", {}),
                ("helfrich", {"spontaneous_curvature": 1.0}),
            )
        ]
        for i, j in ((0, 1), (0, 2), (1, 2)):
            assert np.abs(results[i] - results[j]).max() > 1e-5
