"""Velocity laws: Q on spheres and tori, limits of one law in another, and the registry."""

import inspect

import numpy as np
import pytest

from esfem.reference_solutions import CliffordTorus, Torus
from esfem.reference_solutions.axisymmetric import DENSITIES, VELOCITIES
from esfem.schemes import ALL_LAWS
from esfem.solver.geometry import geometry
from esfem.solver.laws import (
    ENERGIES,
    LAWS,
    energy_of,
    forced,
    helfrich,
    surface_diffusion,
    velocity_law,
    willmore,
    with_split,
)

RNG = np.random.default_rng(0)
H, S2, X = RNG.uniform(-3, 3, (4, 5)), RNG.uniform(0, 9, (4, 5)), RNG.standard_normal((4, 5, 3))
ALL = [("willmore", {}), ("helfrich", {"spontaneous_curvature": 0.7}), ("surface_diffusion", {})]


def curvatures(torus: Torus, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal curvatures 1/r and cos(theta)/rho."""
    return 1 / torus.r + 0 * theta, np.cos(theta) / (torus.R + torus.r * np.cos(theta))


def laplace_H(torus: Torus, theta: np.ndarray) -> np.ndarray:
    """(rho H')' / (r^2 rho) by central differences of fourth order."""
    eps = 1e-3

    def d(f):
        def derivative(s):
            return (8 * (f(s + eps) - f(s - eps)) - (f(s + 2 * eps) - f(s - 2 * eps))) / (12 * eps)

        return derivative

    def rho(s):
        return torus.R + torus.r * np.cos(s)

    dH = d(lambda s: sum(curvatures(torus, s)))
    return d(lambda s: rho(s) * dH(s))(theta) / (torus.r**2 * rho(theta))


class TestWillmore:
    @pytest.mark.parametrize("R", [0.3, 1.0, 2.5])
    def test_vanishes_on_spheres(self, R):
        Q = willmore(np.array(2 / R), np.array(2 / R**2), np.zeros(3), 0.0)
        np.testing.assert_allclose(Q, 0.0, rtol=0, atol=1e-14 / R**3)

    def test_vanishes_on_minimal_surfaces(self):
        np.testing.assert_array_equal(willmore(0 * H, S2, X, 0.0), 0.0)

    def test_on_cylinders(self):
        """kappa = (1/R, 0): Q = 1 / (2 R^3), so a cylinder grows."""
        assert willmore(np.array(0.5), np.array(0.25), np.zeros(3), 0.0) == 1 / 16

    @pytest.mark.parametrize("torus", [Torus(1.0, 0.6), Torus(2.0, 0.5), CliffordTorus(1.5).torus])
    def test_with_laplace_H_is_velocity_of_the_torus(self, torus):
        theta = np.linspace(0.1, 6.2, 50)
        kappa_1, kappa_2 = curvatures(torus, theta)
        Q = willmore(kappa_1 + kappa_2, kappa_1**2 + kappa_2**2, np.zeros((50, 3)), 0.0)
        rho = torus.R + torus.r * np.cos(theta)
        y = np.stack([rho, 0 * theta, torus.r * np.sin(theta)], axis=1)
        # Differences twice: eps^4 = 1e-12 times derivatives, rounding 1e-16 / eps^2 = 1e-10.
        expected = torus.fields(y).V
        np.testing.assert_allclose(laplace_H(torus, theta) + Q, expected, rtol=0, atol=2e-8)

    def test_scales_with_the_third_power(self):
        large = willmore(H / 2, S2 / 4, 2 * X, 16.0)
        np.testing.assert_allclose(large, willmore(H, S2, X, 1.0) / 8, rtol=1e-12, atol=1e-12)

    def test_changes_sign_with_the_normal(self):
        expected = -willmore(H, S2, X, 0.0)
        np.testing.assert_allclose(willmore(-H, S2, X, 0.0), expected, rtol=0, atol=1e-13)


class TestHelfrich:
    def test_without_spontaneous_curvature_is_willmore(self):
        result = helfrich(H, S2, X, 0.0, spontaneous_curvature=0.0)
        np.testing.assert_allclose(result, willmore(H, S2, X, 0.0), rtol=0, atol=1e-13)

    @pytest.mark.parametrize("H0", [1.0, -1.0, 0.4])
    @pytest.mark.parametrize("R", [1.0, 3.0])
    def test_on_spheres(self, R, H0):
        """R' = H0 (2 - H0 R) / R^2, for Lap H = 0."""
        Q = helfrich(np.array(2 / R), np.array(2 / R**2), np.zeros(3), 0.0, H0)
        np.testing.assert_allclose(Q, H0 * (2 - H0 * R) / R**2, rtol=1e-13, atol=0)

    def test_is_gradient_flow_on_spheres(self):
        """d/dR of 1/2 int (H - H0)^2 = 2 pi (2 - H0 R)^2 is -Q times the area."""
        R, H0, eps = 1.3, 0.8, 1e-5

        def energy(R):
            return 2 * np.pi * (2 - H0 * R) ** 2

        slope = (energy(R + eps) - energy(R - eps)) / (2 * eps)
        Q = helfrich(np.array(2 / R), np.array(2 / R**2), np.zeros(3), 0.0, H0)
        np.testing.assert_allclose(slope, -Q * 4 * np.pi * R**2, rtol=1e-9, atol=0)  # eps^2

    def test_scales_with_the_third_power(self):
        large = helfrich(H / 2, S2 / 4, 2 * X, 16.0, 0.35)
        expected = helfrich(H, S2, X, 1.0, 0.7) / 8
        np.testing.assert_allclose(large, expected, rtol=1e-12, atol=1e-12)


class TestSurfaceDiffusion:
    def test_is_zero(self):
        Q = surface_diffusion(H, S2, X, 0.0)
        np.testing.assert_array_equal(Q, np.zeros(H.shape))


class TestRegistry:
    def test_walk_covers_the_registry(self):
        assert [name for name, _ in ALL] == list(LAWS)

    @pytest.mark.parametrize(("name", "parameters"), ALL)
    def test_every_law_is_what_its_name_binds(self, name, parameters):
        result = velocity_law(name, **parameters)(H, S2, X, 0.5)
        np.testing.assert_array_equal(result, LAWS[name](H, S2, X, 0.5, **parameters))
        assert result.shape == H.shape

    @pytest.mark.parametrize("name", LAWS)
    def test_every_law_takes_H_S2_x_t_first(self, name):
        for part in (LAWS[name].Q, LAWS[name].q):
            assert list(inspect.signature(part).parameters)[:4] == ["H", "S2", "x", "t"]

    @pytest.mark.parametrize(("name", "parameters"), ALL)
    def test_what_the_split_leaves_is_no_multiple_of_H(self, name, parameters):
        """r = Q - q H is -H0 |S|^2, and zero where there is no H0."""
        law = velocity_law(name, **parameters)
        r = law(H, S2, X, 0.5) - law.q(H, S2, X, 0.5) * H
        expected = -parameters.get("spontaneous_curvature", 0.0) * S2
        np.testing.assert_allclose(r, expected, rtol=0, atol=1e-12 * np.abs(H**3).max())

    def test_a_forcing_belongs_to_r(self):
        law = forced(willmore, lambda x, t: t * x[..., 0])
        np.testing.assert_array_equal(law.q(H, S2, X, 0.5), willmore.q(H, S2, X, 0.5))
        np.testing.assert_array_equal(law(H, S2, X, 0.5), willmore(H, S2, X, 0.5) + 0.5 * X[..., 0])

    def test_a_plain_function_has_no_linear_part(self):
        law = with_split(lambda H, S2, x, t: H**2)
        np.testing.assert_array_equal(law(H, S2, X, 0.5), H**2)
        np.testing.assert_array_equal(law.q(H, S2, X, 0.5), 0.0)

    @pytest.mark.parametrize(("name", "parameters"), ALL)
    def test_no_law_changes_its_arguments(self, name, parameters):
        arguments = H.copy(), S2.copy(), X.copy()
        velocity_law(name, **parameters)(*arguments, 0.5)
        for before, after in zip((H, S2, X), arguments, strict=True):
            np.testing.assert_array_equal(after, before)

    def test_unknown_name_is_refused(self):
        message = "law name = 'ricci': must be one of willmore, helfrich, surface_diffusion"
        with pytest.raises(ValueError, match=message):
            velocity_law("ricci")


class TestEnergies:
    def test_every_law_has_one_here_and_in_the_axisymmetric_solver(self):
        assert set(ENERGIES) == set(ALL_LAWS) == set(DENSITIES) == set(VELOCITIES)

    @pytest.mark.parametrize(
        ("law", "parameters", "E"),
        [
            ("willmore", {}, lambda R: 8 * np.pi),
            ("helfrich", {"spontaneous_curvature": 0.7}, lambda R: 2 * np.pi * (2 - 0.7 * R) ** 2),
            ("helfrich", {"spontaneous_curvature": -1.0}, lambda R: 2 * np.pi * (2 + R) ** 2),
            ("surface_diffusion", {}, lambda R: 4 * np.pi * R**2),
            ("mean_curvature", {}, lambda R: 4 * np.pi * R**2),
        ],
    )
    @pytest.mark.parametrize("R", [0.5, 1.3])
    def test_on_spheres(self, raised, law, parameters, E, R):
        mesh, x = raised("sphere", 240, 3)
        found = energy_of(law, **parameters).value(geometry(mesh, R * x), np.full(len(x), 2 / R))
        assert found == pytest.approx(E(R), rel=1e-5, abs=0)  # the area of P_3 elements, h^4

    @pytest.mark.parametrize(
        ("law", "parameters", "said"),
        [
            ("willmore", {}, "Willmore energy W = 1/2 int H^2"),
            (
                "helfrich",
                {"spontaneous_curvature": -1.0},
                "Helfrich energy E = 1/2 int (H - H0)^2 with H0 = -1",
            ),
            ("surface_diffusion", {}, "area A = int 1"),
        ],
    )
    def test_it_says_which_energy_it_is(self, law, parameters, said):
        assert str(energy_of(law, **parameters)) == said

    def test_unknown_name_is_refused(self):
        with pytest.raises(ValueError, match="law name = 'ricci': must be one of willmore, helf"):
            energy_of("ricci")
