"""The exact surfaces: every closed form against differences, quadrature or its definition."""

import importlib
import inspect
import pkgutil
from types import SimpleNamespace

import numpy as np
import pytest
from profiles import laplace_V

from esfem import reference_solutions
from esfem.reference_solutions import (
    SOLUTIONS,
    STARTS,
    CliffordTorus,
    ExactSolution,
    InitialSurface,
    RoundTorus,
    StationarySphere,
    Torus,
)
from esfem.reference_solutions.exact import closest_point_jacobian, outer, positive

EPS = 3e-4  # differences of fourth order: truncation 1e-14 f^(5), rounding 1e-12
DIFFERENCES = {"rtol": 0, "atol": 1e-8}
ROUNDING = {"rtol": 0, "atol": 1e-13}


def static(torus: Torus) -> SimpleNamespace:
    """A Torus, which knows no time, seen as a surface at a time."""
    return SimpleNamespace(
        R=torus.R,
        r=torus.r,
        closest_point=lambda x, t: torus.closest_point(x),
        closest_point_derivative=lambda x, t: torus.closest_point_derivative(x),
        fields=lambda y, t: torus.fields(y),
        willmore=lambda t: torus.willmore(),
    )


SURFACES = {
    "unit sphere": StationarySphere(),
    "sphere 1.7": StationarySphere(1.7),
    "clifford": CliffordTorus(),
    "clifford 2.2": CliffordTorus(2.2),
    "torus": static(Torus(1.0, 0.6)),
    "thin torus": static(Torus(1.5, 0.4)),
}
TORI = {name: surface for name, surface in SURFACES.items() if "torus" in name or "cliff" in name}


def radii(surface) -> tuple[float, float]:
    return (
        (surface.torus.R, surface.torus.r) if hasattr(surface, "torus") else (surface.R, surface.r)
    )


def embedding(surface, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Points with angles a in (0, pi) or around the tube, b about the axis."""
    if isinstance(surface, StationarySphere):
        rho, height = surface.radius * np.sin(a), surface.radius * np.cos(a)
    else:
        R, r = radii(surface)
        rho, height = R + r * np.cos(a), r * np.sin(a)
    return np.stack([rho * np.cos(b), rho * np.sin(b), height], axis=-1)


@pytest.fixture(params=SURFACES)
def surface(request):
    return SURFACES[request.param]


@pytest.fixture(params=TORI)
def torus(request):
    return TORI[request.param]


def points_on(surface) -> np.ndarray:
    """Generic points, (4, 5, 3): shapes with two leading axes."""
    rng = np.random.default_rng(0)
    return embedding(surface, rng.uniform(0.2, 2.9, (4, 5)), rng.uniform(0, 6, (4, 5)))


def points_near(surface) -> np.ndarray:
    """Inside and outside, up to a sixth of the radius of curvature away."""
    rng = np.random.default_rng(1)
    y = points_on(surface)
    d = rng.uniform(-0.06, 0.06, y.shape[:-1])
    return y + d[..., None] * surface.fields(y, 0.0).nu


def directional(f, x: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Central difference of fourth order of f at x along a direction."""
    return (
        8 * (f(x + EPS * direction) - f(x - EPS * direction))
        - (f(x + 2 * EPS * direction) - f(x - 2 * EPS * direction))
    ) / (12 * EPS)


def difference_gradient(f, x: np.ndarray) -> np.ndarray:
    """[..., a, ...] = d_a f: the new axis comes behind the axes of the points."""
    return np.stack([directional(f, x, e) for e in np.eye(3)], axis=x.ndim - 1)


def tangential_gradient(surface, f, y: np.ndarray) -> np.ndarray:
    """grad_Gamma of a field on Gamma: the gradient on Gamma of f composed with closest_point."""
    return difference_gradient(lambda x: f(surface.closest_point(x, 0.0)), y)


def tangential_divergence(surface, f, y: np.ndarray) -> np.ndarray:
    return np.einsum("...aa->...", tangential_gradient(surface, f, y))


class TestClosestPoint:
    def test_leaves_points_of_the_surface(self, surface):
        y = points_on(surface)
        np.testing.assert_allclose(surface.closest_point(y, 0.0), y, **ROUNDING)

    def test_is_idempotent(self, surface):
        y = surface.closest_point(points_near(surface), 0.0)
        np.testing.assert_allclose(surface.closest_point(y, 0.0), y, **ROUNDING)

    def test_undoes_a_move_along_the_normal(self, surface):
        y = points_on(surface)
        near = points_near(surface)
        np.testing.assert_allclose(surface.closest_point(near, 0.0), y, **ROUNDING)

    def test_is_nearer_than_other_points(self, surface):
        x = points_near(surface)
        y = surface.closest_point(x, 0.0)
        others = points_on(surface).reshape(-1, 1, 1, 3)
        distances = np.linalg.norm(x - others, axis=-1)
        assert (np.linalg.norm(x - y, axis=-1) <= distances + 1e-13).all()

    def test_derivative_is_that_of_differences(self, surface):
        x = points_near(surface)
        expected = difference_gradient(lambda p: surface.closest_point(p, 0.0), x)
        np.testing.assert_allclose(
            surface.closest_point_derivative(x, 0.0), expected, **DIFFERENCES
        )

    def test_derivative_is_symmetric(self, surface):
        D = surface.closest_point_derivative(points_near(surface), 0.0)
        np.testing.assert_allclose(D, np.swapaxes(D, -1, -2), **ROUNDING)

    def test_derivative_on_the_surface_is_the_tangential_projection(self, surface):
        y = points_on(surface)
        nu = surface.fields(y, 0.0).nu
        D = surface.closest_point_derivative(y, 0.0)
        np.testing.assert_allclose(D, np.eye(3) - outer(nu, nu), **ROUNDING)


class TestFields:
    def test_nu_is_the_gradient_of_the_distance(self, surface):
        """Outward: the distance to the closest point grows along nu."""
        y = points_on(surface)
        nu = surface.fields(y, 0.0).nu
        for distance in (0.05, -0.05):
            x = y + distance * nu
            step = (x - surface.closest_point(x, 0.0)) / distance
            np.testing.assert_allclose(step, nu, rtol=0, atol=1e-11)

    def test_nu_points_outward(self, surface):
        y = points_on(surface)
        inside = 0.0 * y
        if not isinstance(surface, StationarySphere):
            inside = radii(surface)[0] * y / np.hypot(y[..., 0], y[..., 1])[..., None] * [1, 1, 0]
        assert (np.einsum("...a,...a", surface.fields(y, 0.0).nu, y - inside) > 0).all()

    def test_nu_has_length_one(self, surface):
        nu = surface.fields(points_on(surface), 0.0).nu
        np.testing.assert_allclose(np.linalg.norm(nu, axis=-1), 1.0, **ROUNDING)

    def test_S_is_the_gradient_of_nu(self, surface):
        y = points_on(surface)
        expected = tangential_gradient(surface, lambda p: surface.fields(p, 0.0).nu, y)
        np.testing.assert_allclose(surface.fields(y, 0.0).S, expected, **DIFFERENCES)

    def test_H_is_the_trace_of_S(self, surface):
        f = surface.fields(points_on(surface), 0.0)
        np.testing.assert_allclose(f.H, np.einsum("...aa->...", f.S), **ROUNDING)

    def test_z_is_the_gradient_of_H(self, surface):
        y = points_on(surface)
        expected = tangential_gradient(surface, lambda p: surface.fields(p, 0.0).H, y)
        np.testing.assert_allclose(surface.fields(y, 0.0).z, expected, **DIFFERENCES)

    def test_grad_z_is_the_gradient_of_z(self, surface):
        """[..., a, b] = d_a z_b, which is not symmetric: z is tangential, its gradient is not."""
        y = points_on(surface)
        expected = tangential_gradient(surface, lambda p: surface.fields(p, 0.0).z, y)
        np.testing.assert_allclose(surface.fields(y, 0.0).grad_z, expected, **DIFFERENCES)

    def test_grad_V_is_the_gradient_of_V(self, surface):
        y = points_on(surface)
        expected = tangential_gradient(surface, lambda p: surface.fields(p, 0.0).V, y)
        np.testing.assert_allclose(surface.fields(y, 0.0).grad_V, expected, **DIFFERENCES)

    def test_grad_v_is_the_gradient_of_v(self, surface):
        y = points_on(surface)
        expected = tangential_gradient(surface, lambda p: surface.fields(p, 0.0).v, y)
        np.testing.assert_allclose(surface.fields(y, 0.0).grad_v, expected, **DIFFERENCES)

    def test_v_is_V_nu(self, surface):
        f = surface.fields(points_on(surface), 0.0)
        np.testing.assert_allclose(np.einsum("...a,...a", f.v, f.nu), f.V, **ROUNDING)
        np.testing.assert_allclose(np.cross(f.v, f.nu), 0.0, **ROUNDING)

    def test_V_is_the_willmore_velocity(self, surface):
        """V = Lap H - H^3/2 + |S|^2 H, with Lap H the divergence of z by differences."""
        y = points_on(surface)
        f = surface.fields(y, 0.0)
        laplace_H = tangential_divergence(surface, lambda p: surface.fields(p, 0.0).z, y)
        S2 = np.einsum("...ab,...ab", f.S, f.S)
        np.testing.assert_allclose(f.V, laplace_H - f.H**3 / 2 + S2 * f.H, **DIFFERENCES)

    def test_z_is_laplace_nu_plus_S2_nu(self, surface):
        """The identity behind the paper's z: grad H = Lap nu + |S|^2 nu."""
        y = points_on(surface)
        f = surface.fields(y, 0.0)
        S2 = np.einsum("...ab,...ab", f.S, f.S)
        laplace_nu = np.stack(
            [
                tangential_divergence(surface, lambda p, b=b: surface.fields(p, 0.0).S[..., b], y)
                for b in range(3)
            ],
            axis=-1,
        )
        np.testing.assert_allclose(f.z, laplace_nu + S2[..., None] * f.nu, **DIFFERENCES)

    def test_shapes_follow_the_points(self, surface):
        y = points_on(surface)
        for leading, p in (((), y[0, 0]), ((5,), y[0]), ((4, 5), y)):
            f = surface.fields(p, 0.0)
            assert f.H.shape == f.V.shape == leading
            assert f.nu.shape == f.z.shape == f.grad_V.shape == f.v.shape == (*leading, 3)
            assert f.S.shape == f.grad_z.shape == f.grad_v.shape == (*leading, 3, 3)

    def test_laplace_V_is_the_divergence_of_grad_V(self, torus):
        R, r = radii(torus)
        torus = static(Torus(R, r))
        y = points_on(torus)
        expected = tangential_divergence(torus, lambda p: torus.fields(p, 0.0).grad_V, y)
        np.testing.assert_allclose(laplace_V(Torus(R, r), y), expected, **DIFFERENCES)

    def test_torus_velocity_is_that_of_the_reference(self):
        """REFERENCE.md: V = R (R^2 - 2 r^2) / (2 r^3 rho^3)."""
        surface, (R, r) = SURFACES["torus"], (1.0, 0.6)
        y = points_on(surface)
        rho = np.hypot(y[..., 0], y[..., 1])
        expected = R * (R**2 - 2 * r**2) / (2 * r**3 * rho**3)
        np.testing.assert_allclose(surface.fields(y, 0.0).V, expected, rtol=1e-13, atol=0)
        assert np.abs(expected).min() > 0.1


class TestEnergy:
    def test_is_half_the_integral_of_H_squared(self, surface):
        """The trapezoidal rule about the axis is exact, Gauss and trapezoid along the profile."""
        if isinstance(surface, StationarySphere):
            node, weight = np.polynomial.legendre.leggauss(20)
            a, area = np.arccos(node), surface.radius**2 * weight * 2 * np.pi
        else:
            R, r = radii(surface)
            a = np.arange(200) * 2 * np.pi / 200
            area = r * (R + r * np.cos(a)) * (2 * np.pi / 200) * 2 * np.pi
        H = surface.fields(embedding(surface, a, 0 * a), 0.0).H
        assert surface.willmore(0.0) == pytest.approx(0.5 * np.sum(area * H**2), rel=1e-13, abs=0)

    def test_clifford_torus_is_the_least_torus(self):
        energies = [Torus(1.0, r).willmore() for r in np.linspace(0.3, 0.95, 40)]
        least = CliffordTorus().willmore(0.0)
        assert min(energies) > least == pytest.approx(4 * np.pi**2, rel=1e-15)

    @pytest.mark.parametrize("scale", [0.5, 1.0, 3.0])
    def test_clifford_energy_is_that_of_its_torus(self, scale):
        clifford = CliffordTorus(scale)
        assert clifford.willmore(0.0) == pytest.approx(clifford.torus.willmore(), rel=1e-14, abs=0)

    def test_sphere_energy_does_not_see_the_radius(self):
        small, large = StationarySphere(0.2), StationarySphere(5.0)
        assert small.willmore(0.0) == large.willmore(1.0) == 8 * np.pi


class TestStationary:
    @pytest.mark.parametrize("scale", [0.5, 1.0, 3.0])
    def test_clifford_torus_has_no_velocity(self, scale):
        surface = CliffordTorus(scale)
        f = surface.fields(points_on(surface), 0.0)
        # R^2 - 2 r^2 is a rounding.
        np.testing.assert_allclose(f.V, 0.0, rtol=0, atol=1e-13 / scale**3)


class TestRoundTorus:
    """A surface to start from: the torus itself is tested above."""

    @pytest.mark.parametrize(("R", "r"), [(1.0, 0.6), (2.0, 0.5)])
    def test_mesh_points_are_taken_onto_it(self, R, r):
        solution = RoundTorus(R, r)
        y = solution.closest_point(solution.scale * points_on(CliffordTorus()), 0.0)
        tube = np.hypot(np.hypot(y[..., 0], y[..., 1]) - R, y[..., 2])
        np.testing.assert_allclose(tube, r, **ROUNDING)

    def test_its_length_is_that_of_the_sphere_of_equal_area(self):
        """Pappus: the area of a torus is (2 pi R) (2 pi r)."""
        solution = RoundTorus(3.0, 0.75)
        assert 4.0 * np.pi * solution.length**2 == pytest.approx(6.0 * np.pi * 1.5 * np.pi)

    def test_nothing_is_forced_and_no_later_time_is_known(self):
        solution = RoundTorus()
        assert solution.forcing("helfrich", {"spontaneous_curvature": 1.0}) is None
        assert not solution.always_exact and solution.reference == "start"
        with pytest.raises(ValueError, match="law = 'heat': must be one of"):
            solution.forcing("heat", {})

    def test_a_torus_that_meets_itself_is_refused(self):
        with pytest.raises(ValueError, match=r"r = 1\.5: must be less than R = 1\.0"):
            RoundTorus(1.0, 1.5)


class TestRegistry:
    def test_holds_every_implementation(self):
        """Each class of the package that names a family of meshes has joined."""
        classes = {
            member
            for info in pkgutil.iter_modules(reference_solutions.__path__)
            for _, member in inspect.getmembers(
                importlib.import_module(f"esfem.reference_solutions.{info.name}"), inspect.isclass
            )
            if hasattr(member, "mesh_surface") and hasattr(member, "name")
        }
        assert set(STARTS.values()) == classes
        assert len(classes) >= 2

    def test_keys_are_names(self):
        assert {name: solution.name for name, solution in SOLUTIONS.items()} == {
            name: name for name in SOLUTIONS
        }

    @pytest.mark.parametrize("name", SOLUTIONS)
    def test_offers_what_the_protocol_asks(self, name):
        solution = SOLUTIONS[name]()
        for member in InitialSurface.__annotations__:
            assert hasattr(solution, member), member
        for member in {**vars(InitialSurface), **vars(ExactSolution)}:
            assert member.startswith("_") or hasattr(solution, member), member
        assert solution.name == name

    @pytest.mark.parametrize("name", [n for n, s in SOLUTIONS.items() if s.stationary])
    def test_stationary_means_at_rest(self, name):
        solution = SOLUTIONS[name]()
        y = points_on(solution)
        for t in (0.0, 0.4, 3.0):
            np.testing.assert_array_equal(solution.trajectories(y)(t), y)
            np.testing.assert_array_equal(
                solution.closest_point(y, t), solution.closest_point(y, 0)
            )
            np.testing.assert_allclose(solution.fields(y, t).V, 0.0, rtol=0, atol=1e-13)

    @pytest.mark.parametrize(
        ("solution", "scale"),
        [(StationarySphere(), 1.0), (StationarySphere(1.7), 1.7), (CliffordTorus(2.2), 2.2)],
    )
    def test_scale_enlarges_the_unit_mesh_onto_the_surface(self, solution, scale):
        assert solution.scale == scale
        y = scale * points_on(SOLUTIONS[solution.name]())
        np.testing.assert_allclose(solution.closest_point(y, 0.0), y, **ROUNDING)


class TestBadInput:
    @pytest.mark.parametrize("wrong", [0.0, -1.0, np.inf, np.nan])
    @pytest.mark.parametrize(
        ("make", "name"),
        [
            (lambda a: StationarySphere(a), "radius"),
            (lambda a: CliffordTorus(a), "scale"),
            (lambda a: Torus(a, 0.6), "R"),
            (lambda a: Torus(1.0, a), "r"),
            (lambda a: positive(height=a), "height"),
        ],
    )
    def test_radius_that_is_not_positive_is_refused(self, make, name, wrong):
        with pytest.raises(
            ValueError, match=f"^{name} = {wrong!r}: must be a positive finite number"
        ):
            make(wrong)

    @pytest.mark.parametrize("r", [1.0, 1.5])
    def test_torus_that_meets_itself_is_refused(self, r):
        with pytest.raises(ValueError, match=rf"r = {r}: must be less than R = 1\.0"):
            Torus(1.0, r)


class TestAlgebra:
    def test_outer_is_the_outer_product(self):
        a, b = np.random.default_rng(0).standard_normal((2, 4, 3))
        for i in range(4):
            np.testing.assert_array_equal(outer(a, b)[i], np.outer(a[i], b[i]))

    def test_closest_point_jacobian_of_a_cylinder(self):
        """Radius 2 about e3, distance 1 outside: the circle shrinks by 2/3, the axis does not."""
        principal = [(np.array(0.5), np.array([0.0, 1.0, 0.0])), (np.array(0.0), np.eye(3)[2])]
        D = closest_point_jacobian(np.array(1.0), principal)
        np.testing.assert_allclose(D, np.diag([0.0, 2 / 3, 1.0]), **ROUNDING)
