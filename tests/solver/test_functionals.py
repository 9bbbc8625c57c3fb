"""Area, volume, energy and widths of spheres and tori: exact limits, orders and scaling."""

import numpy as np
import pytest
import trimesh

from esfem.reference_solutions import StationarySphere
from esfem.solver import functionals, triangulation
from esfem.solver.geometry import geometry
from esfem.solver.reference_element import DEGREES

SURFACES = ("sphere", "torus")
# R = 1, r = 0.6 for the torus.
AREA = {"sphere": 4 * np.pi, "torus": 4 * np.pi**2 * 0.6}
VOLUME = {"sphere": 4 * np.pi / 3, "torus": 2 * np.pi**2 * 0.36}
ENERGY = {"sphere": 8 * np.pi, "torus": 2 * np.pi**2 / 0.36 / np.sqrt(1 / 0.36 - 1)}
LEVELS = (240, 480, 960)
# Interpolation of degree k; symmetric rules give the even orders.
ORDERS = pytest.mark.parametrize(("k", "order"), [(1, 2), (2, 4), (3, 4), (4, 6)])

each_degree = pytest.mark.parametrize("k", DEGREES)
each_surface = pytest.mark.parametrize("surface", SURFACES)


@pytest.fixture
def exact_H(torus):
    def at(surface: str, x: np.ndarray) -> np.ndarray:
        return StationarySphere().fields(x, 0.0).H if surface == "sphere" else torus.fields(x).H

    return at


def rates(raised, surface: str, k: int, functional, exact: float) -> np.ndarray:
    """Signed orders of consecutive levels; the least error is 1e-9, far above rounding."""
    h, e = [], []
    for V in LEVELS:
        mesh, x = raised(surface, V, k)
        geo = geometry(mesh, x)
        h.append(functionals.mesh_width(geo))
        e.append(abs(functional(geo, x) - exact))
    return np.diff(np.log(e)) / np.diff(np.log(h))


class TestOrders:
    """Within 0.2, for irregular levels: measured 1.98 to 2.02, 3.91 to 4.02, 5.89 to 6.01."""

    @ORDERS
    @each_surface
    def test_area(self, raised, surface, k, order):
        measured = rates(raised, surface, k, lambda geo, x: functionals.area(geo), AREA[surface])
        np.testing.assert_allclose(measured, order, rtol=0, atol=0.2)

    @ORDERS
    @each_surface
    def test_volume(self, raised, surface, k, order):
        exact = VOLUME[surface]
        measured = rates(raised, surface, k, lambda geo, x: functionals.volume(geo), exact)
        np.testing.assert_allclose(measured, order, rtol=0, atol=0.2)

    @ORDERS
    @each_surface
    def test_willmore_energy(self, raised, exact_H, surface, k, order):
        def energy(geo, x):
            return functionals.willmore_energy(geo, exact_H(surface, x))

        measured = rates(raised, surface, k, energy, ENERGY[surface])
        np.testing.assert_allclose(measured, order, rtol=0, atol=0.2)


class TestScaling:
    @each_degree
    @pytest.mark.parametrize(
        ("functional", "power"),
        [(functionals.area, 2), (functionals.volume, 3), (functionals.mesh_width, 1)],
    )
    def test_scales_with_its_power(self, make_rough, functional, power, k):
        rough = make_rough(k)
        small, large = (functional(geometry(rough.mesh, l * rough.x)) for l in (1.0, 3.0))
        assert large == pytest.approx(3.0**power * small, rel=1e-12, abs=0)

    @each_degree
    def test_willmore_energy_does_not_see_the_size(self, make_rough, k):
        rough = make_rough(k)
        H = rough.u[:, 0]
        small = functionals.willmore_energy(geometry(rough.mesh, rough.x), H)
        large = functionals.willmore_energy(geometry(rough.mesh, 3 * rough.x), H / 3)
        assert large == pytest.approx(small, rel=1e-12, abs=0)

    @each_degree
    def test_volume_does_not_see_the_place(self, make_rough, k):
        """Gamma_h is closed, and the rule is exact for the polynomial x . (J0 x J1)."""
        rough = make_rough(k)
        here = functionals.volume(geometry(rough.mesh, rough.x))
        there = functionals.volume(geometry(rough.mesh, rough.x + np.array([3.0, -2.0, 5.0])))
        assert there == pytest.approx(here, rel=1e-11, abs=0)


class TestAsTrimeshSeesIt:
    @pytest.fixture
    def flat(self, make_rough):
        rough = make_rough(1)
        rough.geo = geometry(rough.mesh, rough.x)
        rough.trimesh = trimesh.Trimesh(rough.x, rough.mesh.triangles, process=False)
        return rough

    def test_area(self, flat):
        assert functionals.area(flat.geo) == pytest.approx(flat.trimesh.area, rel=1e-12, abs=0)

    def test_volume(self, flat):
        assert functionals.volume(flat.geo) == pytest.approx(flat.trimesh.volume, rel=1e-12, abs=0)

    def test_largest_diameter_is_the_longest_edge(self, flat):
        expected = flat.trimesh.edges_unique_length.max()
        result = functionals.largest_diameter(flat.mesh, flat.x)
        assert result == pytest.approx(expected, rel=1e-14, abs=0)

    @pytest.mark.parametrize("first", [0, 1, 2])
    def test_largest_diameter_looks_at_all_edges(self, flat, first):
        """However the triangles are turned: all begin at the same end of their longest edge."""
        corners = flat.x[flat.mesh.triangles]
        opposite = np.linalg.norm(np.roll(corners, 1, 1) - np.roll(corners, -1, 1), axis=2)
        longest = opposite.argmax(axis=1)[:, None]
        turned = np.take_along_axis(
            flat.mesh.triangles, (longest + first + np.arange(3)) % 3, axis=1
        )
        result = functionals.largest_diameter(triangulation(turned), flat.x)
        expected = flat.trimesh.edges_unique_length.max()
        assert result == pytest.approx(expected, rel=1e-14, abs=0)

    @each_degree
    def test_largest_diameter_looks_at_vertices_only(self, raised, k):
        mesh, x = raised("sphere", 30, k)
        flat, corners = raised("sphere", 30, 1)
        expected = functionals.largest_diameter(flat, corners)
        result = functionals.largest_diameter(mesh, x)
        assert result == pytest.approx(expected, rel=1e-14, abs=0)


class TestWidths:
    def test_mesh_width_of_equilateral_triangles_is_their_edge(self):
        corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
        mesh = triangulation(np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
        width = functionals.mesh_width(geometry(mesh, corners))
        assert width == pytest.approx(np.sqrt(8.0), rel=1e-14, abs=0)

    def test_mesh_width_does_not_see_the_degree(self, raised):
        """Up to the difference of the areas, which is O(h^2) of degree 1."""
        widths = [functionals.mesh_width(geometry(*raised("sphere", 240, k))) for k in (2, 3, 4)]
        np.testing.assert_allclose(widths, widths[0], rtol=1e-4, atol=0)


class TestNormalLengths:
    def test_are_the_extremes(self):
        nu = np.array([[0.0, 0.0, 1.5], [3.0, 4.0, 0.0], [0.6, 0.8, 0.0]])
        assert functionals.normal_lengths(nu) == pytest.approx((1.0, 5.0), rel=1e-15, abs=0)

    def test_of_unit_normals_are_one(self, raised):
        _, x = raised("sphere", 60, 2)
        assert functionals.normal_lengths(x) == pytest.approx((1.0, 1.0), rel=1e-14, abs=0)
