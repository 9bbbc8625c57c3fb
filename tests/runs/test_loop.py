"""The loop over States, and what is measured of one."""

from dataclasses import replace

import numpy as np
import pytest

from esfem.reference_solutions import PerturbedSphere, StationarySphere
from esfem.runs.loop import Ending, measured
from esfem.runs.recorder import NUMBERS, level_numbers
from esfem.solver import Diverged, SolverFailure, State
from esfem.solver.laws import energy_of
from esfem.solver.scheme import Work


def until(stop: Exception):
    """Two levels, and then this."""
    yield "first"
    yield "second"
    raise stop


class TestMeasured:
    def test_every_level_is_watched_with_its_number(self):
        seen = []
        assert measured("abc", lambda *level: seen.append(level), first=5) == Ending()
        assert seen == [(5, "a"), (6, "b"), (7, "c")]

    @pytest.mark.parametrize(
        ("kind", "status"), [(Diverged, "diverged"), (SolverFailure, "failed")]
    )
    def test_what_stops_a_flow_is_a_result(self, kind, status):
        seen, stop = [], kind("no pivot", 0.25)
        ending = measured(until(stop), lambda n, state: seen.append(state))
        assert (ending, seen) == (Ending(status, 0.25, "no pivot"), ["first", "second"])
        assert str(ending) == f"{status} at t = 0.25"
        assert ending.told == str(stop)

    def test_so_is_what_stops_the_measuring(self):
        def watch(n: int, state: str) -> None:
            raise SolverFailure("singular", 0.5)

        assert measured(["first"], watch).status == "failed"

    def test_any_other_error_is_none(self):
        with pytest.raises(KeyError):
            measured(until(KeyError("x")), lambda n, state: None)

    def test_one_that_came_to_its_end_has_nothing_to_tell(self):
        assert (str(Ending()), Ending().told) == ("ok", "")


class TestLevelNumbers:
    @pytest.fixture(scope="class")
    @staticmethod
    def sphere(raised):
        """P_3 on the unit sphere, with H = 2 and V = -3, after five iterations."""
        mesh, x = raised("sphere", 240, 3)
        f = StationarySphere().fields(x, 0.0)
        V = np.full(len(x), -3.0)
        return mesh, State(0.5, x, 2.0 * f.nu, f.H, V, f.z, Work(5, {}))

    def test_are_those_of_a_sphere(self, sphere):
        found = level_numbers(tuple(NUMBERS), *sphere, energy_of("willmore"))
        exact = {
            "t": 0.5,
            "energy": 8.0 * np.pi,
            "dissipation": 9.0 * 4.0 * np.pi,
            "willmore": 8.0 * np.pi,
            "area": 4.0 * np.pi,
            "volume": 4.0 / 3.0 * np.pi,
            "least_normal": 2.0,
            "greatest_normal": 2.0,
            "least_H": 2.0,
            "greatest_H": 2.0,
            "speed": 3.0,
            "least_distance": 1.0,
            "greatest_distance": 1.0,
            "iterations": 5.0,
        }
        rest = found.keys() - exact.keys()
        assert rest == {"least_area_element", "quality"}
        for name, value in exact.items():  # interpolation of degree 3 at h = 0.3
            assert found[name] == pytest.approx(value, rel=1e-4), name
        assert all(0.3 < found[name] < 1.0 for name in rest)

    def test_least_and_greatest_are_those_of_the_nodes(self, sphere):
        mesh, state = sphere
        spread = np.linspace(1.0, 1.5, len(state.x))
        moved = replace(state, x=spread[:, None] * state.x, nu=spread[:, None] * state.nu, H=spread)
        names = ("normal", "H", "distance")
        both = [f"{end}_{name}" for name in names for end in ("least", "greatest")]
        found = level_numbers(both, mesh, moved, energy_of("willmore"))
        expected = [2.0, 3.0, 1.0, 1.5, 1.0, 1.5]
        np.testing.assert_allclose(list(found.values()), expected, rtol=1e-14)

    def test_the_energy_is_that_of_the_law(self, sphere):
        (energy,) = level_numbers(("energy",), *sphere, energy_of("mean_curvature")).values()
        assert energy == pytest.approx(4.0 * np.pi, rel=1e-4)

    def test_surface_diffusion_dissipates_by_the_gradient_of_H(self, sphere):
        mesh, state = sphere
        state = replace(state, z=np.full_like(state.z, 2.0))
        names = ("willmore", "mean_curvature", "surface_diffusion")
        found = [
            level_numbers(("dissipation",), mesh, state, energy_of(name))["dissipation"]
            for name in names
        ]
        expected = np.array([9.0, 9.0, 12.0]) * 4.0 * np.pi
        np.testing.assert_allclose(found, expected, rtol=1e-4)

    def test_elements_that_are_squeezed_have_less_quality(self, sphere):
        mesh, state = sphere
        squeezed = replace(state, x=state.x * np.array([1.0, 1.0, 0.1]))
        names = ("quality", "least_area_element")
        before, after = (
            level_numbers(names, mesh, one, energy_of("willmore")) for one in (state, squeezed)
        )
        assert all(after[name] < 0.5 * before[name] for name in names)

    def test_a_decaying_mode_has_an_amplitude(self, sphere):
        mesh, state = sphere
        mode = PerturbedSphere(degree=2, amplitude=1e-3)
        x = mode.closest_point(state.x, 0.0)
        found = level_numbers((), mesh, replace(state, x=x), energy_of("willmore"), mode)
        assert found == {"amplitude": pytest.approx(1e-3, rel=1e-2)}
