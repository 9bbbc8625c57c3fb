"""All exact solutions through time: closest points, fields, motion and law against differences."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from esfem.reference_solutions import (
    SOLUTIONS,
    BreathingEllipsoid,
    CliffordTorus,
    ExactSolution,
    HelfrichSphere,
    LogisticSphere,
    PerturbedCliffordTorus,
    PerturbedSphere,
    ShrinkingSphere,
    Spheroid,
    StationarySphere,
    laws,
)
from esfem.reference_solutions.clifford_modes import linearised_operator
from esfem.reference_solutions.exact import finite, outer

EPS = 3e-4  # differences of fourth order: truncation 1e-14 f^(5), rounding 1e-12 f
EPS_TIME = 2e-5  # in time the perturbed spheres have f^(5) up to 360^5 * 0.1: truncation 3e-9
DIFFERENCES = {"rtol": 1e-8, "atol": 1e-8}
SECOND_DIFFERENCES = {"rtol": 1e-7, "atol": 1e-7}  # of fields that are themselves derivatives
ROUNDING = {"rtol": 1e-13, "atol": 1e-13}
# Fields are up to fourth derivatives of the surface: condition numbers up to 1e3.
FOURTH_DERIVATIVES = {"rtol": 1e-11, "atol": 1e-11}
PARAMETERS = {
    "willmore": {},
    "helfrich": {"spontaneous_curvature": 0.7},
    "surface_diffusion": {},
    "mean_curvature": {},
}

SURFACES: dict[str, tuple[ExactSolution, tuple[float, ...]]] = {
    "sphere": (StationarySphere(1.7), (0.0, 2.0)),
    "clifford": (CliffordTorus(2.2), (0.0, 2.0)),
    "helfrich": (HelfrichSphere(), (0.0, 0.4, 4.0)),
    "helfrich shrinking to R*": (HelfrichSphere(3.0, 1.0), (0.5,)),
    "helfrich shrinking to a point": (HelfrichSphere(1.0, -1.0), (0.05, 0.1)),
    "helfrich at rest": (HelfrichSphere(1.3, 0.0), (0.5,)),
    "logistic": (LogisticSphere(), (0.0, 0.5, 3.0)),
    "shrinking": (ShrinkingSphere(1.3), (0.0, 0.2)),
    "logistic shrinking": (LogisticSphere(1.5, 0.7, 2.0), (0.6,)),
    "ellipsoid": (BreathingEllipsoid(), (0.0, 0.1, 0.25, 0.75)),
    "ellipsoid, large": (BreathingEllipsoid(-0.5, 2.0), (0.3, 1.4)),
    "ellipsoid, enlarged": (BreathingEllipsoid(0.25, 1.7, 1.3), (0.0, 0.4)),
    "perturbed sphere l=2": (PerturbedSphere(1.0, 0.2, 2), (0.0, 0.02)),
    "perturbed sphere l=3": (PerturbedSphere(1.3, -0.1, 3), (0.0, 0.01)),
    "perturbed sphere l=4": (PerturbedSphere(1.0, 0.1, 4), (0.0, 0.003)),
    "perturbed torus m=0": (PerturbedCliffordTorus(1.0, 0.03, 0), (0.0, 0.01)),
    "perturbed torus m=0, fast": (PerturbedCliffordTorus(1.0, -0.02, 0, 1), (0.0, 0.01)),
    "perturbed torus m=2": (PerturbedCliffordTorus(1.3, 0.04, 2), (0.0, 0.1)),
    "perturbed torus m=2, fast": (PerturbedCliffordTorus(1.0, 0.03, 2, 1), (0.02,)),
}


@dataclass(frozen=True)
class Moment:
    """A solution at a time."""

    solution: ExactSolution
    t: float

    def closest_point(self, x):
        return self.solution.closest_point(x, self.t)

    def closest_point_derivative(self, x):
        return self.solution.closest_point_derivative(x, self.t)

    def fields(self, y):
        return self.solution.fields(y, self.t)

    @property
    def y(self) -> np.ndarray:
        return self.closest_point(self.solution.trajectories(labels(self.solution))(self.t))

    @property
    def S2(self) -> np.ndarray:
        return (self.fields(self.y).S ** 2).sum((-1, -2))

    def gradient(self, f, y):
        """[..., a, ...]: a-th tangential derivative, that on Gamma of f composed with the lift."""
        g = lambda x: f(self.closest_point(x))  # noqa: E731
        return np.stack([difference(lambda e, a=a: g(y + e * a)) for a in np.eye(3)], axis=1)

    def divergence(self, f, y):
        return np.einsum("paa->p", self.gradient(f, y))

    def after(self, f):
        """d/dt of f(point, t) along normal motion, at y."""
        f0, y = self.fields(self.y), self.y

        def moved(e):
            x = self.solution.closest_point(y + e * f0.v, self.t + e)
            return f(x, self.t + e)

        return difference(moved, EPS_TIME)


def difference(f, eps: float = EPS) -> np.ndarray:
    """f'(0) by central differences of fourth order."""
    return (8 * (f(eps) - f(-eps)) - (f(2 * eps) - f(-2 * eps))) / (12 * eps)


@cache
def labels(solution: ExactSolution) -> np.ndarray:
    """Points of Gamma(0), (P, 3): generic ones, and on a sphere the poles and points near them."""
    rng = np.random.default_rng(0)
    if solution.mesh_surface == "clifford_torus":
        a, b = rng.uniform(0, 2 * np.pi, (2, 20))
        rho = 1 + np.cos(a) / np.sqrt(2)
        x = np.stack([rho * np.cos(b), rho * np.sin(b), np.sin(a) / np.sqrt(2)], axis=-1)
    else:
        x = rng.standard_normal((12, 3))
        axes = np.concatenate([np.eye(3), -np.eye(3)])
        near = [axes + e * np.roll(axes, 1, axis=1) for e in (0.0, 1e-170, 1e-8, 1e-3)]
        x = np.concatenate([x, *near])
        x /= np.linalg.norm(x, axis=-1, keepdims=True)
    return solution.closest_point(solution.scale * x, 0.0)


def near(moment: Moment, fraction: float) -> tuple[np.ndarray, np.ndarray]:
    """Points off the surface and their distances, up to a fraction of the radius of curvature."""
    y = moment.y
    f = moment.fields(y)
    least_radius = 1 / np.linalg.norm(f.S, 2, axis=(-2, -1)).max()
    d = least_radius * fraction * np.resize([1.0, -1.0, 0.3, -0.6], len(y))
    return y + d[:, None] * f.nu, d


MOMENTS = [
    pytest.param(Moment(solution, t), id=f"{name}, t={t}")
    for name, (solution, times) in SURFACES.items()
    for t in times
]
MOVING = [p for p in MOMENTS if p.values[0].t > 2 * EPS_TIME]
EXACT = [p for p in MOMENTS if p.values[0].solution.always_exact]
LINEARISED = [p for p in MOMENTS if not p.values[0].solution.always_exact]
each_moment = pytest.mark.parametrize("moment", MOMENTS)
each_later = pytest.mark.parametrize("moment", MOVING)


def test_all_solutions_are_walked():
    assert {type(solution) for solution, _ in SURFACES.values()} == set(SOLUTIONS.values())


@each_moment
class TestClosestPoint:
    def test_leaves_points_of_the_surface(self, moment):
        np.testing.assert_allclose(moment.closest_point(moment.y), moment.y, **ROUNDING)

    def test_undoes_a_move_along_the_normal(self, moment):
        """Up to half the least radius of curvature away."""
        x, _ = near(moment, 0.5)
        np.testing.assert_allclose(moment.closest_point(x), moment.y, **ROUNDING)

    def test_derivative_is_that_of_differences(self, moment):
        x, _ = near(moment, 0.3)
        D = moment.closest_point_derivative(x)
        for a in np.eye(3):
            expected = difference(lambda e, a=a: moment.closest_point(x + e * a))
            np.testing.assert_allclose(D @ a, expected, **DIFFERENCES)

    def test_derivative_is_that_of_the_shape_operator(self, moment):
        """D (I + d S) = I - nu nu^T, at half the least radius of curvature too."""
        x, d = near(moment, 0.5)
        f = moment.fields(moment.y)
        product = moment.closest_point_derivative(x) @ (np.eye(3) + d[:, None, None] * f.S)
        np.testing.assert_allclose(product, np.eye(3) - outer(f.nu, f.nu), rtol=0, atol=1e-12)


@each_moment
class TestFields:
    def test_nu_is_outward_of_length_one(self, moment):
        y = moment.y
        nu = moment.fields(y).nu
        np.testing.assert_allclose(np.linalg.norm(nu, axis=-1), 1.0, **ROUNDING)
        inside = 0 * y
        if moment.solution.mesh_surface == "clifford_torus":
            inside[:, :2] = y[:, :2] / np.hypot(y[:, :1], y[:, 1:2]) * moment.solution.scale
        assert (((y - inside) * nu).sum(-1) > 0).all()

    def test_nu_is_normal_to_the_surface(self, moment):
        """D closest_point is tangential."""
        D = moment.closest_point_derivative(near(moment, 0.3)[0])
        nu = moment.fields(moment.y).nu
        np.testing.assert_allclose(np.einsum("pab,pb->pa", D, nu), 0.0, rtol=0, atol=1e-12)

    def test_S_is_the_gradient_of_nu(self, moment):
        expected = moment.gradient(lambda y: moment.fields(y).nu, moment.y)
        np.testing.assert_allclose(moment.fields(moment.y).S, expected, **DIFFERENCES)

    def test_S_is_symmetric(self, moment):
        S = moment.fields(moment.y).S
        np.testing.assert_allclose(S, np.swapaxes(S, -1, -2), **ROUNDING)

    def test_H_is_the_trace_of_S(self, moment):
        f = moment.fields(moment.y)
        np.testing.assert_allclose(f.H, np.einsum("paa->p", f.S), **ROUNDING)

    def test_z_is_the_gradient_of_H(self, moment):
        expected = moment.gradient(lambda y: moment.fields(y).H, moment.y)
        np.testing.assert_allclose(moment.fields(moment.y).z, expected, **DIFFERENCES)

    def test_grad_z_is_the_gradient_of_z(self, moment):
        expected = moment.gradient(lambda y: moment.fields(y).z, moment.y)
        np.testing.assert_allclose(moment.fields(moment.y).grad_z, expected, **SECOND_DIFFERENCES)

    def test_laplace_H_is_the_trace_of_grad_z(self, moment):
        f = moment.fields(moment.y)
        np.testing.assert_allclose(f.laplace_H, np.einsum("paa->p", f.grad_z), **FOURTH_DERIVATIVES)

    def test_grad_V_is_the_gradient_of_V(self, moment):
        expected = moment.gradient(lambda y: moment.fields(y).V, moment.y)
        np.testing.assert_allclose(moment.fields(moment.y).grad_V, expected, **DIFFERENCES)

    def test_shapes_follow_the_points(self, moment):
        y = moment.y[:12].reshape(2, 6, 3)
        whole = moment.fields(moment.y)
        for leading, points in (((), y[0, 0]), ((6,), y[0]), ((2, 6), y)):
            f = moment.fields(points)
            for name in ("H", "V", "laplace_H", "nu", "z", "grad_V", "S", "grad_z"):
                rank = getattr(whole, name).ndim - 1
                assert getattr(f, name).shape == leading + (3,) * rank, name
            assert moment.closest_point(points).shape == (*leading, 3)
            assert moment.closest_point_derivative(points).shape == (*leading, 3, 3)


class TestMotion:
    @each_moment
    def test_trajectories_stay_on_the_surface(self, moment):
        x = moment.solution.trajectories(labels(moment.solution))(moment.t)
        np.testing.assert_allclose(moment.closest_point(x), x, **ROUNDING)

    @each_moment
    def test_trajectories_start_at_their_labels(self, moment):
        p = labels(moment.solution)
        np.testing.assert_allclose(moment.solution.trajectories(p)(0.0), p, **ROUNDING)

    @each_later
    def test_trajectories_move_with_V_nu(self, moment):
        solution, t = moment.solution, moment.t
        X = solution.trajectories(labels(solution))
        velocity, f = difference(lambda e: X(t + e), EPS_TIME), moment.fields(X(t))
        if not solution.always_exact:
            # Radial: normal to first order only, for which see TestPerturbedSphere.
            velocity = np.einsum("pa,pa,pb->pb", velocity, f.nu, f.nu)
        np.testing.assert_allclose(velocity, f.v, **DIFFERENCES)

    @each_later
    def test_nu_changes_by_minus_grad_V(self, moment):
        change = moment.after(lambda y, t: moment.solution.fields(y, t).nu)
        np.testing.assert_allclose(change, -moment.fields(moment.y).grad_V, **SECOND_DIFFERENCES)

    @each_later
    def test_H_changes_by_minus_laplace_V_minus_S2_V(self, moment):
        change = moment.after(lambda y, t: moment.solution.fields(y, t).H)
        laplace_V = moment.divergence(lambda y: moment.fields(y).grad_V, moment.y)
        expected = -laplace_V - moment.S2 * moment.fields(moment.y).V
        np.testing.assert_allclose(change, expected, **SECOND_DIFFERENCES)

    @pytest.mark.parametrize("name", SURFACES)
    def test_stationary_means_at_rest(self, name):
        solution, times = SURFACES[name]
        p = labels(solution)
        if solution.stationary:
            for t in times:
                np.testing.assert_array_equal(solution.trajectories(p)(t), p)
                np.testing.assert_allclose(solution.fields(p, t).V, 0.0, **ROUNDING)
        elif name != "helfrich at rest":
            assert np.abs(solution.fields(p, 0.0).V).max() > 1e-3


class TestLaw:
    @pytest.mark.parametrize("law", laws.ALL)
    @pytest.mark.parametrize("moment", EXACT)
    def test_V_is_that_of_the_law_plus_f(self, moment, law):
        solution = moment.solution
        if law not in solution.laws:
            with pytest.raises(
                ValueError, match=f"law = '{law}': (solution|must be one of willmore)"
            ):
                solution.forcing(law, PARAMETERS[law])
            return
        parameters = solution.law_parameters or PARAMETERS[law]
        f = solution.forcing(law, parameters)
        f = 0.0 if f is None else f(moment.y, moment.t)
        fields = moment.fields(moment.y)
        V = laws.velocity(law, parameters, fields) + f
        np.testing.assert_allclose(V, fields.V, **FOURTH_DERIVATIVES)

    @pytest.mark.parametrize("law", laws.PARAMETERS)
    @pytest.mark.parametrize("solution", [LogisticSphere(), BreathingEllipsoid()])
    def test_forcing_goes_on_smoothly_off_the_surface(self, solution, law):
        """Third differences through the surface vanish like d^3: halve d, and it is an eighth."""
        moment = Moment(solution, 0.3)
        y, f = moment.y, solution.forcing(law, PARAMETERS[law])
        nu = moment.fields(y).nu

        def third(d):
            at = [f(y + j * d * nu, 0.3) for j in (-2, -1, 1, 2)]
            return np.abs(at[3] - 2 * at[2] + 2 * at[1] - at[0]).max()

        if isinstance(solution, LogisticSphere):
            assert third(0.01) == 0.0
        else:
            # Next order: d^2 times derivatives of 1/g^8.
            assert third(0.01) / third(0.005) == pytest.approx(8.0, rel=0.05)

    @pytest.mark.parametrize("solution", [LogisticSphere(), BreathingEllipsoid()])
    def test_forcing_follows_the_shape_of_the_points(self, solution):
        f = solution.forcing("willmore", {})
        x = labels(solution)[:12].reshape(3, 4, 3)
        assert f(x, 0.1).shape == (3, 4)
        np.testing.assert_array_equal(f(x, 0.1)[1, 2], f(x[1, 2], 0.1))

    @pytest.mark.parametrize("solution", [LogisticSphere(), BreathingEllipsoid()])
    def test_forced_solutions_refuse_unknown_laws(self, solution):
        with pytest.raises(ValueError, match="law = 'ricci'"):
            solution.forcing("ricci", {})
        with pytest.raises(ValueError, match="law 'helfrich' takes spontaneous_curvature"):
            solution.forcing("helfrich", {})

    def test_helfrich_sphere_demands_its_curvature(self):
        solution = HelfrichSphere(1.0, -1.0)
        assert solution.law_parameters == {"spontaneous_curvature": -1.0}
        assert solution.forcing("helfrich", solution.law_parameters) is None
        with pytest.raises(ValueError, match=r"spontaneous_curvature = 1\.0: must be -1\.0"):
            solution.forcing("helfrich", {"spontaneous_curvature": 1.0})


class TestEnergy:
    @each_moment
    def test_is_half_the_integral_of_H_squared(self, moment):
        """Gauss and trapezoid on a mesh surface, lifted by D closest_point: exact to rounding."""
        solution, t = moment.solution, moment.t
        n = 128
        b = 2 * np.pi * np.arange(n) / n
        if solution.mesh_surface == "sphere":
            # Enlarged: outside of convex surfaces the lift is smooth.
            a, weight = np.polynomial.legendre.leggauss(n)
            s, enlarge = np.sqrt(1 - a**2), 1.5
            profile, slope = (s, a), (-a / s, np.ones(n))
        else:
            a, weight, enlarge, r = b, np.full(n, 2 * np.pi / n), 1.0, 1 / np.sqrt(2)
            profile, slope = (1 + r * np.cos(a), r * np.sin(a)), (-r * np.sin(a), r * np.cos(a))
        x = revolved(*profile, b)
        derivatives = revolved(*slope, b), revolved(profile[0], 0 * a, b + np.pi / 2)
        x, d_a, d_b = (enlarge * solution.scale * v for v in (x, *derivatives))
        D = solution.closest_point_derivative(x, t) @ np.stack([d_a, d_b], axis=-1)
        area = np.linalg.norm(np.cross(D[..., 0], D[..., 1]), axis=-1)
        H = solution.fields(solution.closest_point(x, t), t).H
        W = 0.5 * np.sum(weight[:, None] * (2 * np.pi / n) * area * H**2)
        assert solution.willmore(t) == pytest.approx(W, rel=1e-11, abs=0)


def revolved(rho, height, b) -> np.ndarray:
    """(rho_i cos b_j, rho_i sin b_j, height_i), (n, n, 3)."""
    rho, height, b = rho[:, None], height[:, None], b[None, :]
    return np.stack([rho * np.cos(b), rho * np.sin(b), height + 0 * b], axis=-1)


class TestHelfrichSphere:
    @pytest.mark.parametrize(
        ("R0", "H0", "t", "R"),
        [
            (1.0, 1.0, 1.0, 1.46528861820),
            (1.0, 1.0, 4.0, 1.81653745976),
            (3.0, 1.0, 1.0, 2.89107493519),
            (1.0, -1.0, 0.1, 0.53993754361),
        ],
    )
    def test_radius_is_that_of_the_reference(self, R0, H0, t, R):
        # REFERENCE.md has eleven digits behind the point.
        assert HelfrichSphere(R0, H0).radius_at(t) == pytest.approx(R, rel=0, abs=6e-12)

    def test_extinction_is_that_of_the_reference(self):
        time = HelfrichSphere(1.0, -1.0).latest_time
        assert time == pytest.approx(0.12186043243, rel=0, abs=6e-12)

    @pytest.mark.parametrize("H0", [1.0, -0.8, 2.0 - 1e-6, 2.5, 1e-3, -1e-3, 1e-8])
    def test_radius_solves_the_equation(self, H0):
        solution = HelfrichSphere(1.0, H0)
        t = min(1.0, 0.9 * solution.latest_time)
        path = solve_ivp(
            lambda t, R: H0 * (2 - H0 * R) / R**2, (0, t), [1.0], "DOP853", rtol=3e-14, atol=1e-15
        )
        assert solution.radius_at(t) == pytest.approx(path.y[0, -1], rel=1e-12, abs=0)

    @pytest.mark.parametrize("R0", [1.0, 3.0])
    def test_tends_to_its_radius_exponentially(self, R0):
        """u = R - 2 decays like exp(-H0^2 t / R*^2); both differences keep 1e-10 of their value."""
        solution = HelfrichSphere(R0, 1.0)
        ratio = (solution.radius_at(44.0) - 2) / (solution.radius_at(40.0) - 2)
        # The rate varies with u ~ 1e-4.
        assert ratio == pytest.approx(np.exp(-1.0), rel=1e-3)
        assert solution.radius_at(1e9) == pytest.approx(2.0, rel=1e-15)

    def test_no_curvature_and_own_curvature_mean_rest(self):
        assert HelfrichSphere(1.3, 0.0).radius_at(7.0) == 1.3
        assert HelfrichSphere(2.0, 1.0).radius_at(7.0) == 2.0
        assert HelfrichSphere(2.0, 1.0).velocity_at(7.0) == 0.0

    def test_vanishes_at_extinction(self):
        """R^3 = 6 |H0| (T - t) in the end."""
        solution = HelfrichSphere(1.0, -1.0)
        T = solution.latest_time
        # Next order in R ~ 1e-2.
        assert solution.radius_at(T * (1 - 1e-6)) ** 3 / (6e-6 * T) == pytest.approx(1, abs=1e-2)

    @pytest.mark.parametrize("t", [-0.1, 0.1219, np.nan])
    def test_time_outside_is_refused(self, t):
        with pytest.raises(ValueError, match=r"t = .*: must be in \[0, 0\.12186"):
            HelfrichSphere(1.0, -1.0).radius_at(t)

    def test_others_exist_for_ever(self):
        for solution, _ in SURFACES.values():
            shrinks = isinstance(solution, ShrinkingSphere)
            if not shrinks and getattr(solution, "spontaneous_curvature", 0.0) >= 0:
                assert solution.latest_time == np.inf


class TestLogisticSphere:
    def test_radius_is_that_of_the_reference(self):
        for t in (0.0, 0.3, 2.0):
            e = np.exp(-0.5 * t)
            expected = 2 / (2 * e + 1 - e)
            assert LogisticSphere().radius_at(t) == pytest.approx(expected, rel=1e-15)

    def test_velocity_is_logistic(self):
        solution = LogisticSphere(0.8, 2.5, 1.5)
        r = solution.radius_at(0.7)
        assert solution.velocity_at(0.7) == pytest.approx(1.5 * r * (1 - r / 2.5), rel=1e-14)


class TestBreathingEllipsoid:
    @pytest.mark.parametrize(("a", "W"), [(2.0, 30.90321329), (1.5, 27.15748311), (1.0, 8 * np.pi)])
    def test_energy_is_that_of_the_reference(self, a, W):
        # REFERENCE.md has eight digits behind the point.
        assert Spheroid(a).willmore() == pytest.approx(W, rel=0, abs=6e-9)

    @pytest.mark.parametrize("amplitude", [0.25, -0.5])
    def test_trajectories_solve_their_equation(self, amplitude):
        solution = BreathingEllipsoid(amplitude)
        p = labels(solution)

        def v(t, X):
            return solution.fields(X.reshape(-1, 3), t).v.ravel()

        path = solve_ivp(
            v, (0, 0.8), p.ravel(), "DOP853", rtol=1e-12, atol=1e-13, t_eval=[0.3, 0.8]
        )
        X = solution.trajectories(p)
        for t, x in zip(path.t, path.y.T, strict=True):
            np.testing.assert_allclose(X(t), x.reshape(-1, 3), rtol=0, atol=1e-10)

    def test_trajectories_are_periodic(self):
        solution = BreathingEllipsoid(0.25, 0.7)
        p = labels(solution)
        np.testing.assert_allclose(solution.trajectories(p)(2.1), p, rtol=0, atol=1e-14)

    @pytest.mark.parametrize("amplitude", [0.99, -0.99])
    def test_trajectories_stay_on_extreme_ellipsoids(self, amplitude):
        solution = BreathingEllipsoid(amplitude)
        D = solution.spheroid(0.25).D
        x = solution.trajectories(labels(solution))(0.25)
        np.testing.assert_allclose((x**2 * D).sum(-1), 1.0, rtol=0, atol=1e-12)

    def test_is_where_it_should_be(self):
        solution = BreathingEllipsoid(0.25, 2.0)
        x = np.array([2.0, 0.0, 0.0])
        np.testing.assert_allclose(solution.closest_point(x, 0.5), [1.25, 0, 0], **ROUNDING)
        np.testing.assert_allclose(solution.closest_point(x, 1.5), [0.75, 0, 0], **ROUNDING)

    @pytest.mark.parametrize("a", [0.2, 0.5, 1.0, 1.5, 5.0])
    def test_closest_point_in_the_tube_of_half_the_least_radius(self, a):
        surface = Spheroid(a)
        x = np.random.default_rng(3).standard_normal((4000, 3)) * [a, 1, 1]
        x = x / np.sqrt((x**2 * surface.D).sum(-1, keepdims=True))
        nu = surface.fields(x).nu
        for d in 0.5 / max(a, a**-2, 1.0) * np.array([-1.0, -0.9, 0.9, 1.0]):
            np.testing.assert_allclose(
                surface.closest_point(x + d * nu), x, rtol=0, atol=1e-14 * max(a, 1 / a)
            )

    def test_closest_point_far_inside_is_refused(self):
        with np.errstate(all="ignore"), pytest.raises(ValueError, match="too far"):
            Spheroid(0.5).closest_point(np.zeros((1, 3)))


class TestPerturbedSphere:
    def test_energy_is_that_of_the_reference(self):
        # REFERENCE.md: r0 = 1 + 0.2 P2(cos theta), eight digits behind the point.
        W = PerturbedSphere(1.0, 0.2, 2).willmore(0.0)
        assert W == pytest.approx(26.25458556, rel=0, abs=6e-9)

    @pytest.mark.parametrize(("degree", "rate"), [(2, 24), (3, 120), (4, 360)])
    def test_decay_rate_is_that_of_the_reference(self, degree, rate):
        assert PerturbedSphere(1.0, 0.01, degree).decay_rate == rate
        assert PerturbedSphere(2.0, 0.01, degree).decay_rate == rate / 16

    @pytest.mark.parametrize("law", ["willmore", "surface_diffusion"])
    @pytest.mark.parametrize("degree", [2, 3, 4])
    def test_solves_its_laws_to_first_order(self, degree, law):
        """The residual of the law is eps^2 times a constant: halve eps, and it is a quarter."""
        residuals = []
        for amplitude in (2e-4, 1e-4):
            solution = PerturbedSphere(1.3, amplitude, degree)
            assert solution.forcing(law, {}) is None
            y = labels(solution)
            f = solution.fields(y, 0.0)
            residuals.append(np.abs(f.V - laws.velocity(law, {}, f)).max())
        assert residuals[0] < 0.1 * np.abs(f.V).max()
        # The next order is eps times about 1e2 relative.
        assert residuals[0] / residuals[1] == pytest.approx(4.0, rel=0.02)

    @pytest.mark.parametrize("degree", [2, 3, 4])
    def test_trajectories_are_normal_to_first_order(self, degree):
        errors = []
        for amplitude in (2e-3, 1e-3):
            solution = PerturbedSphere(1.0, amplitude, degree)
            X = solution.trajectories(labels(solution))
            velocity = difference(lambda e, X=X: X(0.01 + e))
            errors.append(np.abs(velocity - solution.fields(X(0.01), 0.01).v).max())
        assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)

    @pytest.mark.parametrize("degree", [2, 3, 4])
    def test_mode_amplitude_is_measured(self, degree):
        solution = PerturbedSphere(1.4, 0.05, degree)
        p = labels(solution)
        X = solution.trajectories(p)
        weights = np.random.default_rng(0).uniform(1, 2, len(p))
        for t in (0.0, 0.01):
            for w in (1.0, weights):
                measured = solution.mode_amplitude(X(t), w)
                assert measured == pytest.approx(solution.amplitude_at(t), rel=1e-12)
                assert solution.mode_amplitude(1.1 * X(t), w) == pytest.approx(
                    1.1 * solution.amplitude_at(t), rel=1e-11
                )


class TestPerturbedCliffordTorus:
    @pytest.mark.parametrize(
        ("m", "branch", "rate", "digits"),
        [(0, 0, 17.2643, 4), (0, 1, 33.3319, 4), (2, 0, 2.38372, 5), (2, 1, 17.8876, 4)],
    )
    def test_decay_rate_is_that_of_the_reference(self, m, branch, rate, digits):
        torus = PerturbedCliffordTorus(1.0, 0.01, m, branch)
        assert torus.decay_rate == pytest.approx(rate, rel=0, abs=0.6 * 10**-digits)
        scaled = PerturbedCliffordTorus(2.0, 0.01, m, branch)
        assert scaled.decay_rate == pytest.approx(rate / 16, rel=1e-5)

    @pytest.mark.parametrize(("m", "neutral"), [(0, 2), (1, 2), (2, 0), (3, 0)])
    def test_neutral_modes_are_those_of_conformal_maps(self, m, neutral):
        """REFERENCE.md: eight of them, those of m = 1 twice (cos and sin) and with m = -1."""
        rates = -np.linalg.eigvals(linearised_operator(m)).real
        # The matrix has entries up to 64^4 / r^4: zeros come out as 1e-9, double ones as 1e-5.
        assert (np.abs(rates) < 1e-3).sum() == (3 if m == 1 else neutral)
        assert rates.min() > -1e-3

    @pytest.mark.parametrize("branch", [0, 1])
    @pytest.mark.parametrize("m", [0, 2])
    def test_modes_do_not_depend_on_the_points(self, m, branch):
        fine = np.sort(-np.linalg.eigvals(linearised_operator(m, 80)).real)
        fine = fine[fine > 1e-3]
        rate = PerturbedCliffordTorus(1.0, 0.01, m, branch).decay_rate
        assert fine[branch] == pytest.approx(rate, rel=1e-7)

    @pytest.mark.parametrize("branch", [0, 1])
    @pytest.mark.parametrize("m", [0, 2])
    def test_solves_the_willmore_flow_to_first_order(self, m, branch):
        """The residual of the law is eps^2 times a constant: halve eps, and it is a quarter.

        This ties the mode to the surface: the one is computed by variation, the other by jets.
        """
        residuals = []
        for amplitude in (4e-4, 2e-4):
            solution = PerturbedCliffordTorus(1.3, amplitude, m, branch)
            f = solution.fields(labels(solution), 0.0)
            residuals.append(np.abs(f.V - laws.velocity("willmore", {}, f)).max())
        assert residuals[0] < 0.1 * np.abs(f.V).max()
        # The next order is eps times about 1e2 relative.
        assert residuals[0] / residuals[1] == pytest.approx(4.0, rel=0.02)

    @pytest.mark.parametrize("branch", [0, 1])
    @pytest.mark.parametrize("m", [0, 2])
    def test_mode_amplitude_is_measured(self, m, branch):
        solution = PerturbedCliffordTorus(1.4, 0.05, m, branch)
        X = solution.trajectories(labels(solution))
        for t in (0.0, 0.01):
            expected = solution.amplitude_at(t)
            assert solution.mode_amplitude(X(t)) == pytest.approx(expected, rel=1e-12)

    @pytest.mark.parametrize("m", [0, 2])
    def test_mode_amplitude_does_not_see_conformal_moves(self, m):
        """Moves along conformal vector fields count to second order only."""
        at_rest = PerturbedCliffordTorus(1.4, 0.0, m)
        x = labels(CliffordTorus(1.4))
        e = np.eye(3)
        fields = [0 * x + e[a] for a in range(3)] + [np.cross(e[a], x) for a in range(2)] + [x]
        fields += [2 * x[:, a : a + 1] * x - (x**2).sum(-1)[:, None] * e[a] for a in range(3)]
        for field in fields:
            # 1e-5^2 times curvatures and up to |x|^4.
            assert at_rest.mode_amplitude(x + 1e-5 * field) == pytest.approx(0.0, abs=1e-8)

    @pytest.mark.parametrize("m", [0, 2])
    def test_mode_has_unit_size(self, m):
        theta = np.linspace(0, 2 * np.pi, 2001)
        for branch in (0, 1):
            psi = PerturbedCliffordTorus(1.0, 0.01, m, branch).mode(theta, 0 * theta)
            assert np.abs(psi).max() == pytest.approx(1.0, rel=1e-4)

    def test_unperturbed_is_the_clifford_torus(self):
        flat, exact = PerturbedCliffordTorus(1.3, 0.0), CliffordTorus(1.3)
        y = labels(exact)
        f, g = flat.fields(y, 0.0), exact.fields(y, 0.0)
        for name in ("nu", "H", "z", "S", "grad_z", "laplace_H", "V"):
            np.testing.assert_allclose(getattr(f, name), getattr(g, name), rtol=0, atol=1e-12)


class TestBadInput:
    @pytest.mark.parametrize("wrong", [0.0, -1.0, np.inf, np.nan])
    @pytest.mark.parametrize(
        ("make", "name"),
        [
            (lambda a: HelfrichSphere(a), "radius"),
            (lambda a: LogisticSphere(a), "r0"),
            (lambda a: LogisticSphere(1.0, a), "r1"),
            (lambda a: LogisticSphere(1.0, 2.0, a), "rate"),
            (lambda a: BreathingEllipsoid(0.2, a), "period"),
            (lambda a: BreathingEllipsoid(scale=a), "scale"),
            (lambda a: Spheroid(a), "a"),
            (lambda a: PerturbedSphere(a), "radius"),
            (lambda a: PerturbedCliffordTorus(a), "scale"),
        ],
    )
    def test_not_positive_is_refused(self, make, name, wrong):
        with pytest.raises(ValueError, match=f"^{name} = {wrong!r}: must be a positive finite"):
            make(wrong)

    @pytest.mark.parametrize("wrong", [np.inf, -np.inf, np.nan])
    def test_not_finite_is_refused(self, wrong):
        for make in (lambda H0: HelfrichSphere(1.0, H0), lambda H0: finite(H0=H0)):
            with pytest.raises(ValueError, match=f" = {wrong!r}|^H0 = {wrong!r}"):
                make(wrong)

    @pytest.mark.parametrize("wrong", [0.0, 1.0, -1.0, 2.0, np.nan])
    def test_amplitude_of_an_ellipsoid_that_collapses_is_refused(self, wrong):
        with pytest.raises(ValueError, match=f"amplitude = {wrong!r}: must have 0 <"):
            BreathingEllipsoid(wrong)

    @pytest.mark.parametrize("wrong", [0.31, -0.5, np.nan])
    def test_large_perturbation_is_refused(self, wrong):
        with pytest.raises(ValueError, match=f"amplitude = {wrong!r}: must have"):
            PerturbedSphere(1.0, wrong)

    @pytest.mark.parametrize("wrong", [0, 1, 5, 2.5])
    def test_degree_without_decay_is_refused(self, wrong):
        with pytest.raises(ValueError, match=f"degree = {wrong!r}: must be 2, 3 or 4"):
            PerturbedSphere(1.0, 0.1, wrong)

    @pytest.mark.parametrize(
        ("wrong", "message"),
        [
            ({"amplitude": 0.11}, "amplitude = 0.11: must have"),
            ({"amplitude": np.nan}, "amplitude = nan: must have"),
            ({"m": 1}, "m = 1: must be 0 or 2"),
            ({"branch": 2}, "branch = 2: must be 0 or 1"),
        ],
    )
    def test_wrong_mode_of_the_torus_is_refused(self, wrong, message):
        with pytest.raises(ValueError, match=message):
            PerturbedCliffordTorus(**wrong)
