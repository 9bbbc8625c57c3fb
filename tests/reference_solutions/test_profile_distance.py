"""The distance of points to a surface of revolution, and back."""

import numpy as np
import pytest
from profiles import SHAPES

from esfem.reference_solutions.profile_curve import red_blood_cell_profile, spheroid_profile
from esfem.reference_solutions.profile_distance import (
    distance_to_curve,
    profile_distance,
    surface_samples,
)


def sphere_points(n, radius=1.0):
    return surface_samples(spheroid_profile(radius, radius), n)


class TestDistance:
    @pytest.mark.parametrize("shape", SHAPES)
    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_zero_on_exact_points(self, shape, axis):
        x = np.roll(surface_samples(SHAPES[shape], 500), axis - 2, axis=1)
        distance = profile_distance(x, SHAPES[shape], axis)
        assert distance.maximum_to_profile < 1e-12  # round-off
        assert distance.mean_to_profile < 1e-13

    @pytest.mark.parametrize("radius", [0.9, 1.25])
    def test_concentric_spheres(self, radius):
        x = sphere_points(2000, radius)
        distance = profile_distance(
            x,
            spheroid_profile(1.0, 1.0),
            surface=lambda y: np.abs(np.linalg.norm(y, axis=1) - radius),
        )
        for value in vars(distance).values():
            assert value == pytest.approx(abs(radius - 1.0), abs=1e-12)

    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_sphere_shifted_along_the_axis(self, axis):
        shift = 0.1 * np.eye(3)[axis]
        x = np.concatenate([sphere_points(1000), np.eye(3), -np.eye(3)]) + shift
        distance = profile_distance(x, spheroid_profile(1.0, 1.0), axis)
        np.testing.assert_allclose(distance.maximum_to_profile, 0.1, atol=1e-12)
        expected = np.mean(np.abs(np.linalg.norm(x, axis=1) - 1.0))
        assert distance.mean_to_profile == pytest.approx(expected, abs=1e-12)

    def test_centre_of_a_sphere(self):
        """All points of the curve are as near, and the second derivative is zero."""
        computed = distance_to_curve(np.zeros(1), np.zeros(1), spheroid_profile(1.0, 1.0))
        assert computed[0] == pytest.approx(1.0, abs=1e-14)

    def test_weights_of_the_mean(self):
        x = np.array([[1.1, 0.0, 0.0], [1.3, 0.0, 0.0]])
        distance = profile_distance(x, spheroid_profile(1.0, 1.0), weights=np.array([3.0, 1.0]))
        assert distance.mean_to_profile == pytest.approx(0.15, abs=1e-12)

    def test_missing_part_shows_in_one_direction_only(self):
        """Without its cap z > 1/2 a unit sphere is at the chord 2 sin(30 degrees) = 1 at most."""
        x = sphere_points(4000)
        distance = profile_distance(x[x[:, 2] <= 0.5], spheroid_profile(1.0, 1.0))
        assert distance.maximum_to_profile < 1e-12
        assert distance.maximum_from_profile == pytest.approx(1.0, abs=0.06)  # the spacing

    def test_without_the_surface_it_is_of_the_order_of_the_spacing(self):
        sphere = spheroid_profile(1.0, 1.0)
        found = [profile_distance(sphere_points(n), sphere).mean_from_profile for n in (500, 2000)]
        assert 0.9 < np.log2(found[0] / found[1]) < 1.1

    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_the_surface_is_asked_in_the_coordinates_of_the_points(self, axis):
        """A plane across the axis: distances are heights."""
        height = 0.3
        x = np.roll(sphere_points(100), axis - 2, axis=1)
        distance = profile_distance(
            x, spheroid_profile(1.0, 1.0), axis, surface=lambda y: np.abs(y[:, axis] - height)
        )
        assert distance.maximum_from_profile == pytest.approx(1.0 + height, abs=1e-4)

    def test_points_near_the_axis_and_centres_of_curvature(self):
        """Longhand: the least of many samples is too large by the square of their spacing."""
        profile = red_blood_cell_profile()
        rho, z = (u.ravel() for u in np.meshgrid(np.linspace(0, 2.5, 41), np.linspace(-1, 1, 41)))
        samples = np.stack(profile(np.linspace(0.0, np.pi, 8001)))
        brute = np.array([np.hypot(*(samples - p[:, None])).min() for p in np.stack([rho, z], -1)])
        computed = distance_to_curve(rho, z, profile)
        np.testing.assert_allclose(computed, brute, atol=2.1 * np.pi / 8000)
        # two branches as near: the square of the 1024 samples' spacing, 6e-3, over eight distances
        assert np.all(computed <= brute + 1e-5)


class TestBadInput:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"x": np.ones((3, 2))}, r"x = array of shape \(3, 2\)"),
            ({"x": np.full((3, 3), np.nan)}, "must be finite"),
            ({"axis": 3}, "axis = 3: must be 0, 1 or 2"),
            ({"weights": np.ones(5)}, r"weights = shape \(5,\): must be 4"),
        ],
    )
    def test_profile_distance(self, arguments, message):
        good = {"x": np.ones((4, 3)), "profile": spheroid_profile(1.0, 1.0)}
        with pytest.raises(ValueError, match=message):
            profile_distance(**(good | arguments))
