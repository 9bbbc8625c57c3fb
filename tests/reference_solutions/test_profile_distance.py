"""The distance of points to a surface of revolution, and back."""

import numpy as np
import pytest
from profiles import SHAPES
from scipy.spatial import ConvexHull

from esfem.reference_solutions.profile_curve import red_blood_cell_profile, spheroid_profile
from esfem.reference_solutions.profile_distance import (
    distance_to_curve,
    distance_to_triangle,
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
        distance = profile_distance(x, spheroid_profile(1.0, 1.0), 2, ConvexHull(x).simplices)
        assert distance.maximum_to_profile == pytest.approx(abs(radius - 1.0), abs=1e-12)
        assert distance.mean_to_profile == pytest.approx(abs(radius - 1.0), abs=1e-12)
        sagitta = (np.sqrt(4.0 * np.pi / 2000) * radius) ** 2 / (4.0 * radius)
        assert distance.mean_from_profile == pytest.approx(abs(radius - 1.0), abs=sagitta)
        assert distance.maximum_from_profile == pytest.approx(abs(radius - 1.0), abs=2 * sagitta)

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

    def test_triangles_lift_the_limit_by_the_spacing(self):
        """From the profile: first order in the spacing without triangles, second with them."""
        sphere, without, flat = spheroid_profile(1.0, 1.0), [], []
        for n in (500, 2000):
            x = sphere_points(n)
            without.append(profile_distance(x, sphere).mean_from_profile)
            triangles = ConvexHull(x).simplices
            flat.append(profile_distance(x, sphere, triangles=triangles).mean_from_profile)
        assert 0.9 < np.log2(without[0] / without[1]) < 1.1
        assert 1.8 < np.log2(flat[0] / flat[1]) < 2.2

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

    @pytest.mark.parametrize(
        ("point", "expected"),
        [
            ((0.2, 0.2, 0.7), 0.7),  # over the inside
            ((-3.0, -4.0, 0.0), 5.0),  # before a corner
            ((0.5, -2.0, 1.5), 2.5),  # before an edge
            ((1.0, 1.0, 0.0), np.sqrt(0.5)),  # before the long edge
        ],
    )
    def test_distance_to_a_triangle(self, point, expected):
        corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        for order in ([0, 1, 2], [2, 1, 0], [1, 2, 0]):
            computed = distance_to_triangle(np.array([point]), corners[None, order])
            assert computed[0] == pytest.approx(expected, abs=1e-14)


class TestBadInput:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"x": np.ones((3, 2))}, r"x = array of shape \(3, 2\)"),
            ({"x": np.full((3, 3), np.nan)}, "must be finite"),
            ({"axis": 3}, "axis = 3: must be 0, 1 or 2"),
            ({"weights": np.ones(5)}, r"weights = shape \(5,\): must be 4"),
            ({"triangles": np.array([[0, 1, 4]])}, "must index the 4 points"),
        ],
    )
    def test_profile_distance(self, arguments, message):
        good = {"x": np.ones((4, 3)), "profile": spheroid_profile(1.0, 1.0)}
        with pytest.raises(ValueError, match=message):
            profile_distance(**(good | arguments))
