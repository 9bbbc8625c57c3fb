"""Solutions somewhere else, and of another size: all their quantities move and scale with them."""

import numpy as np
import pytest

from esfem.reference_solutions import (
    SOLUTIONS,
    STARTS,
    BreathingEllipsoid,
    CliffordTorus,
    HelfrichSphere,
    LogisticSphere,
    PerturbedCliffordTorus,
    PerturbedSphere,
    ShrinkingSphere,
    StationarySphere,
    SurfaceFlow,
    decays,
)
from esfem.reference_solutions.placed import Placed

CENTRE = (16.0, -8.0, 32.0)  # with points of 40 binary digits their sums are exact
# Of a size l, all lengths times l and all times l^4, or l^2.
OF_SIZE = {
    "sphere": lambda l, **c: StationarySphere(l, **c),
    "clifford_torus": lambda l, **c: CliffordTorus(l, **c),
    "helfrich_sphere": lambda l, **c: HelfrichSphere(l, 1.0 / l, **c),
    "logistic_sphere": lambda l, **c: LogisticSphere(l, 2.0 * l, 0.5 / l**4, **c),
    "shrinking_sphere": lambda l, **c: ShrinkingSphere(l, **c),
    "breathing_ellipsoid": lambda l, **c: BreathingEllipsoid(0.25, l**4, l, **c),
    "perturbed_sphere": lambda l, **c: PerturbedSphere(l, 0.2, **c),
    "perturbed_clifford_torus": lambda l, **c: PerturbedCliffordTorus(l, 0.1 * l, **c),
}
POWERS = {"nu": 0, "H": -1, "z": -2, "S": -1, "grad_z": -3, "laplace_H": -3}
T = 0.01
each = pytest.mark.parametrize("name", OF_SIZE)


def near(solution, size: float = 1.0, count: int = 400) -> np.ndarray:
    """Points a little off Gamma(T) of a solution about the origin, of 40 binary digits."""
    rng = np.random.default_rng(0)
    if solution.mesh_surface == "sphere":
        x = rng.standard_normal((count, 3))
        x /= np.linalg.norm(x, axis=1, keepdims=True)
    else:
        a, b = rng.uniform(0.0, 2.0 * np.pi, (2, count))
        rho = 1.0 + np.cos(a) / np.sqrt(2.0)
        x = np.stack([rho * np.cos(b), rho * np.sin(b), np.sin(a) / np.sqrt(2.0)], axis=1)
    x *= 1.0 + 0.05 * rng.uniform(-1.0, 1.0, (count, 1))
    return size * np.round(x * 2.0**40) / 2.0**40


def test_all_solutions_are_walked():
    assert set(OF_SIZE) == set(SOLUTIONS)
    assert all(issubclass(solution, Placed) for solution in STARTS.values())


@each
class TestCentre:
    def test_points_move_with_it(self, name):
        c = np.array(CENTRE)
        here, there = OF_SIZE[name](1.0), OF_SIZE[name](1.0, centre=CENTRE)
        x = near(here)
        y = here.closest_point(x, T)
        np.testing.assert_array_equal(there.closest_point(c + x, T), c + y)
        p = here.closest_point(x, 0.0)
        p = np.round(p * 2.0**40) / 2.0**40
        for t in (0.0, T):
            np.testing.assert_array_equal(there.trajectories(c + p)(t), c + here.trajectories(p)(t))

    def test_fields_are_those_of_the_same_point(self, name):
        c = np.array(CENTRE)
        here, there = OF_SIZE[name](1.0), OF_SIZE[name](1.0, centre=CENTRE)
        x = near(here)
        for field, value in vars(here.fields(x, T)).items():
            np.testing.assert_array_equal(getattr(there.fields(c + x, T), field), value)
        np.testing.assert_array_equal(
            there.closest_point_derivative(c + x, T), here.closest_point_derivative(x, T)
        )
        assert there.willmore(T) == here.willmore(T)
        assert there.length == here.length

    def test_forcing_and_modes_follow(self, name):
        c = np.array(CENTRE)
        here, there = OF_SIZE[name](1.0), OF_SIZE[name](1.0, centre=CENTRE)
        x, law = near(here), here.laws[0]
        f, g = (s.forcing(law, s.law_parameters) for s in (here, there))
        assert (f is None) == (g is None)
        if f is not None:
            np.testing.assert_array_equal(g(c + x, T), f(x, T))
        if decays(here):
            weights = np.ones(len(x))
            assert there.mode_amplitude(c + x, weights) == here.mode_amplitude(x, weights)


@each
class TestSize:
    @pytest.mark.parametrize("exponent", [-10, 10])
    def test_scales_to_the_last_bit(self, name, exponent):
        """By powers of two, whatever the formulas do inside."""
        l = 2.0**exponent
        one, many = OF_SIZE[name](1.0), OF_SIZE[name](l)
        time = l**2 if name == "shrinking_sphere" else l**4
        t, x = T * time, near(one)
        y = one.closest_point(x, T)
        np.testing.assert_array_equal(many.closest_point(l * x, t), l * y)
        np.testing.assert_array_equal(
            many.closest_point_derivative(l * x, t), one.closest_point_derivative(x, T)
        )
        np.testing.assert_array_equal(many.trajectories(l * y)(t), l * one.trajectories(y)(T))
        found, expected = many.fields(l * y, t), one.fields(y, T)
        for field, power in POWERS.items():
            value = getattr(found, field) / l**power
            np.testing.assert_array_equal(value, getattr(expected, field), err_msg=field)
        np.testing.assert_array_equal(found.V * time / l, expected.V)
        np.testing.assert_array_equal(found.grad_V * time, expected.grad_V)
        assert many.willmore(t) == one.willmore(T)

    def test_forcing_scales_to_the_last_bit(self, name):
        l = 2.0**10
        one, many = OF_SIZE[name](1.0), OF_SIZE[name](l)
        x = near(one)
        for law in one.laws:
            parameters = [
                {k: v / s.scale for k, v in WANTED.get(law, {}).items()} for s in (one, many)
            ]
            f, g = (
                s.forcing(law, s.law_parameters or p)
                for s, p in zip((one, many), parameters, strict=True)
            )
            if f is not None:
                np.testing.assert_array_equal(g(l * x, T * l**4) * l**3, f(x, T))


WANTED = {"helfrich": {"spontaneous_curvature": 0.7}}


class TestBadInput:
    @pytest.mark.parametrize("name", STARTS)
    @pytest.mark.parametrize(
        ("wrong", "named"),
        [((0.0, np.nan, 0.0), r"centre\[1\] = nan"), ((1.0, 2.0), r"centre = \(1.0, 2.0\)")],
    )
    def test_centre_is_three_finite_numbers(self, name, wrong, named):
        given = {"surface": "ellipsoid"} if name == "surface" else {}
        with pytest.raises(ValueError, match=named):
            STARTS[name](**given, centre=wrong)

    def test_a_list_will_do(self):
        assert SurfaceFlow("ellipsoid", centre=[1, 2, 3]).centre == (1.0, 2.0, 3.0)
