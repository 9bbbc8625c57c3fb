"""The balance of the energy, and the drift of the volume, of discrete flows."""

from dataclasses import replace

import numpy as np
import pytest

from esfem.measuring.energies import balance_error, drift, scale_of
from esfem.meshes import surface_mesh
from esfem.reference_solutions import HelfrichSphere
from esfem.results.records import run_errors
from esfem.runs.run_case import Record, run_case
from esfem.solver.laws import energy_of
from esfem.studies.case import Case

THETA = {"degree": 2, "bdf": 3, "project": True, "theta": True}
WAVY = {"name": "perturbed_sphere", "degree": 3, "amplitude": 0.1}


def recorded(law: str, tau: float, final_time: float, solution=WAVY, vertices=60) -> Record:
    case = Case.model_validate(
        {
            "solution": solution,
            "law": {"name": law},
            "scheme": THETA,
            "vertices": vertices,
            "tau": tau,
            "final_time": final_time,
        }
    )
    mesh = surface_mesh(case.initial.mesh_surface, vertices)
    return run_case(case, mesh)[0]


@pytest.fixture(scope="module")
def diffusion():
    return recorded("surface_diffusion", 1e-4, 2e-3)


class TestBalance:
    def test_is_exact_for_dissipation_of_degree_five(self):
        t = np.array([0.0, 0.05, 0.1, 0.3, 0.5, 0.7, 1.0])  # first steps in substeps
        D = 3.0 * (t - 2.0) ** 4 * t
        lost = np.polynomial.Polynomial([0, 1]) * np.polynomial.Polynomial([-2, 1]) ** 4 * 3.0
        E = 7.0 - lost.integ()(t)
        assert balance_error(t, E, D, 7.0) < 1e-14

    def test_falls_with_order_six_in_the_time_step(self):
        def error(levels: int) -> float:
            t = np.linspace(0.0, 1.0, levels)
            return balance_error(t, np.exp(-4.0 * t), 4.0 * np.exp(-4.0 * t), 1.0)

        order = np.log2(error(17) / error(33))
        assert 5.5 < order < 6.8

    def test_of_two_levels_is_that_of_the_trapezoidal_rule(self):
        assert balance_error([0.0, 1.0], [3.0, 1.0], [2.0, 4.0], 2.0) == pytest.approx(0.5)
        assert np.isnan(balance_error([0.0], [3.0], [2.0], 2.0))

    def test_bounds_every_rise_of_the_energy(self):
        rng = np.random.default_rng(1)
        E, D, t = 5.0 + 0.1 * rng.random(20), 1e-3 * rng.random(20), np.linspace(0.0, 1.0, 20)
        rise = max(E[j] - E[i] for i in range(20) for j in range(i, 20))
        assert rise <= 2.0 * balance_error(t, E, D, 1.0)

    @pytest.mark.parametrize("H0", [1.0, -1.0])
    def test_holds_on_the_helfrich_sphere(self, H0):
        """E = 2 pi (2 - H0 R)^2 and D = 4 pi R^2 V^2, V = R'."""
        solution = HelfrichSphere(radius=1.0, spontaneous_curvature=H0)
        t = np.linspace(0.0, 0.05, 41)
        f = [solution.fields(np.array([[solution.radius_at(s), 0.0, 0.0]]), s) for s in t]
        R, V = np.array([2.0 / g.H[0] for g in f]), np.array([g.V[0] for g in f])
        E, D = 2.0 * np.pi * (2.0 - H0 * R) ** 2, 4.0 * np.pi * R**2 * V**2
        energy = energy_of("helfrich", spontaneous_curvature=H0)
        assert balance_error(t, E, D, scale_of(energy, E[0], 8.0 * np.pi)) < 1e-8
        assert balance_error(t, E, -D, scale_of(energy, E[0], 8.0 * np.pi)) > 1e-2


class TestDrift:
    def test_is_the_largest_relative_change(self):
        assert drift([2.0, 2.5, 1.0, 2.0]) == 0.5
        assert drift([3.0, 3.0]) == 0.0


class TestRuns:
    def test_on_a_sphere_at_rest_nothing_is_lost_and_no_volume(self):
        found = run_errors(recorded("surface_diffusion", 0.01, 0.1, {"name": "sphere"}))
        assert found["err_energy_law"] < 1e-12 and found["err_volume_drift"] < 1e-12

    def test_surface_diffusion_loses_area_by_the_gradient_of_H(self, diffusion):
        """d area/dt of 1 + 0.2 P2 at t = 0, from an independent computation; not int V^2 = 77.3."""
        solution = {"name": "surface", "surface": "p2_sphere"}
        record = recorded("surface_diffusion", 1e-4, 3e-4, solution, vertices=480)
        assert record.levels["dissipation"][0] == pytest.approx(8.308, rel=2e-3)

    def test_errors_are_small_beside_what_is_lost(self, diffusion):
        found, area = run_errors(diffusion), diffusion.levels["area"]
        lost = 1.0 - area[-1] / area[0]
        assert found["err_energy_law"] < 0.02 * lost
        assert found["err_volume_drift"] < 1e-3

    def test_do_not_depend_on_the_unit_of_length(self, diffusion):
        l = 2.0**7  # times scale as l^4
        scaled = recorded(
            "surface_diffusion", l**4 * 1e-4, l**4 * 2e-3, {**WAVY, "radius": l}, vertices=60
        )
        one, other = run_errors(diffusion), run_errors(scaled)
        for name in ("err_energy_law", "err_volume_drift"):
            assert other[name] == pytest.approx(one[name], rel=1e-5)

    def test_of_a_surface_that_does_not_move_as_its_velocity_says_are_large(self, diffusion):
        area = diffusion.levels["area"]
        idle = {**diffusion.levels, "area": area, "energy": [area[0]] * len(area)}
        half = {**diffusion.levels, "energy": list(np.array(area) / 2.0 + area[0] / 2.0)}
        good = run_errors(diffusion)["err_energy_law"]
        for levels in (idle, half):
            assert run_errors(replace(diffusion, levels=levels))["err_energy_law"] > 20.0 * good
