"""The laws of the witness: values that geometry gives, and what is refused."""

import numpy as np
import pytest

from esfem.reference_solutions import CliffordTorus, StationarySphere, Torus, laws

HELFRICH = {"spontaneous_curvature": 0.7}
ROUNDING = {"rtol": 1e-13, "atol": 1e-13}


class TestQ:
    def test_is_the_gradient_of_the_energy_on_spheres(self):
        """There Lap H = 0, and d/dt 1/2 int (H - H0)^2 = -int V^2 = -4 pi R^2 Q^2 = Q dE/dR."""
        H0, R, eps = 0.7, 1.3, 1e-5
        energy = lambda R: 2 * np.pi * R**2 * (2 / R - H0) ** 2  # noqa: E731
        slope = (energy(R + eps) - energy(R - eps)) / (2 * eps)
        Q = laws.Q("helfrich", {"spontaneous_curvature": H0}, 2 / R, 2 / R**2)
        # Central differences: truncation and rounding about 1e-10.
        assert Q == pytest.approx(-slope / (4 * np.pi * R**2), rel=1e-8)

    @pytest.mark.parametrize("R", [0.4, 1.0, 3.0])
    def test_willmore_leaves_spheres_alone(self, R):
        assert laws.Q("willmore", {}, 2 / R, 2 / R**2) == pytest.approx(0.0, abs=1e-14 / R**3)

    def test_willmore_on_a_cylinder(self):
        """H = 1/R, |S|^2 = 1/R^2: Q = 1/(2 R^3), cylinders grow."""
        assert laws.Q("willmore", {}, 0.5, 0.25) == pytest.approx(1 / 16, rel=1e-15)

    def test_helfrich_without_spontaneous_curvature_is_willmore(self):
        H, S2 = np.random.default_rng(0).standard_normal((2, 50))
        none = laws.Q("helfrich", {"spontaneous_curvature": 0.0}, H, S2)
        np.testing.assert_allclose(none, laws.Q("willmore", {}, H, S2), **ROUNDING)

    def test_helfrich_leaves_the_sphere_of_its_curvature_alone(self):
        R = 2 / 0.7
        assert laws.Q("helfrich", HELFRICH, 2 / R, 2 / R**2) == pytest.approx(0.0, abs=1e-15)

    def test_surface_diffusion_has_none(self):
        np.testing.assert_array_equal(laws.Q("surface_diffusion", {}, np.ones(3), np.ones(3)), 0.0)


class TestVelocity:
    def test_is_that_of_round_tori(self):
        """REFERENCE.md: V = R (R^2 - 2 r^2) / (2 r^3 rho^3) under Willmore flow."""
        torus, angle = Torus(1.0, 0.6), np.linspace(0, 6, 30)
        rho = 1 + 0.6 * np.cos(angle)
        y = np.stack([rho, 0 * rho, 0.6 * np.sin(angle)], axis=-1)
        expected = (1 - 0.72) / (2 * 0.6**3 * rho**3)
        np.testing.assert_allclose(laws.velocity("willmore", {}, torus.fields(y)), expected, 1e-12)


class TestBadInput:
    def test_unknown_law_is_refused(self):
        with pytest.raises(ValueError, match=r"law = 'ricci': must be one of willmore, helfrich"):
            laws.check("ricci", {})

    @pytest.mark.parametrize(
        ("law", "parameters"),
        [("helfrich", {}), ("willmore", HELFRICH), ("helfrich", {**HELFRICH, "more": 1.0})],
    )
    def test_wrong_parameters_are_refused(self, law, parameters):
        with pytest.raises(ValueError, match=f"law '{law}' takes"):
            laws.Q(law, parameters, 1.0, 1.0)

    def test_law_that_the_solution_does_not_solve_is_refused(self):
        with pytest.raises(ValueError, match=r"law = 'helfrich': solution 'sphere' solves will"):
            StationarySphere().forcing("helfrich", HELFRICH)
        with pytest.raises(ValueError, match=r"law = 'surface_diffusion': solution 'clifford_t"):
            CliffordTorus().forcing("surface_diffusion", {})

    def test_other_parameters_than_the_solution_needs_are_refused(self):
        with pytest.raises(ValueError, match=r"spontaneous_curvature = 0\.7: must be 1\.0 for sol"):
            laws.check_unforced(
                "s", ("helfrich",), {"spontaneous_curvature": 1.0}, "helfrich", HELFRICH
            )
