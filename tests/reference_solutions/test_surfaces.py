"""Smooth closed surfaces by name: exact start data, closest points, the registry."""

from functools import cache

import numpy as np
import pytest
import sympy
from sympy import Rational, cos, sin
from sympy.abc import u, v, x, y, z

import esfem.reference_solutions.surfaces as registry
from esfem.reference_solutions import PerturbedSphere, Spheroid, Torus, laws
from esfem.reference_solutions.calculus import LevelSet, Parametrised, StartFields
from esfem.reference_solutions.surfaces import (
    named_surface,
    surface_digest,
    surface_names,
    surfaces,
)

NAMES = surface_names()
FIELDS = ("nu", "H", "z", "S", "grad_z", "laplace_H")
# W, area, volume by independent one-dimensional spectral codes; nan where none was given.
REFERENCE = {
    "ellipsoid": (30.90321329, np.nan, 8.37758041),
    "spheroid": (27.15748311, np.nan, 2.0 * np.pi),
    "red_blood_cell": (46.148734656, 33.257086818, 11.728612573),
    "p2_sphere": (26.25458556, 12.96379802, 4.29123605),
    "wave_torus": (298.763464, 31.907602638, 8.339815719),
    "beads_torus": (114.957175345, 17.220882783, 3.256969452),
    # By the trapezoidal rule in u, v with 128 and with 256 points a side, which agree.
    "rippled_torus": (61.678367074, 107.752410407, 60.341947066),
}
POLES = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])

RADIUS = sympy.sqrt(x**2 + y**2 + z**2)
RHO = 1 + Rational(6, 10) * cos(v)
ROUND_TORUS = {
    "level_set": LevelSet(
        phi=(sympy.sqrt(x**2 + y**2) - 1) ** 2 + z**2 - Rational(36, 100),
        start=(RHO * cos(u), RHO * sin(u), sin(v) / 2),
        genus=1,
    ),
    "parametrised": Parametrised(X=(RHO * cos(u), RHO * sin(u), Rational(6, 10) * sin(v)), genus=1),
}

each_surface = pytest.mark.parametrize("name", NAMES)


def parameters(genus: int, count: int, seed: int = 0) -> np.ndarray:
    """Random parameters; on the sphere the poles of the usual angles are among them."""
    rng = np.random.default_rng(seed)
    if genus == 1:
        return rng.random((count, 2)) * 2.0 * np.pi
    p = np.vstack([POLES, rng.standard_normal((count, 3))])
    return p / np.linalg.norm(p, axis=1, keepdims=True)


def start_map(surface) -> Parametrised:
    """The map of a surface; the start maps of the level sets here lie on them."""
    if isinstance(surface, Parametrised):
        return surface
    return Parametrised(surface.start, surface.genus)


@cache
def quadrature(name: str):
    """Weights (n,) with the area element, points, fields: Gauss by trapezoid, spectral."""
    surface = named_surface(name)
    n = 320 if surface.genus == 1 else 100
    angle = 2.0 * np.pi * np.arange(n) / n
    if surface.genus == 0:
        height, weight = np.polynomial.legendre.leggauss(100)
        weight = np.repeat(weight, n) * 2.0 * np.pi / n
        h, phi = (a.ravel() for a in np.meshgrid(height, angle, indexing="ij"))
        r = np.sqrt(1.0 - h**2)
        p = np.stack([r * np.cos(phi), r * np.sin(phi), h], axis=1)
    else:
        weight = np.full(n * n, (2.0 * np.pi / n) ** 2)
        p = np.stack(np.meshgrid(angle, angle, indexing="ij"), axis=-1).reshape(-1, 2)
    X = start_map(surface).jet(p.T, 1)
    area = np.linalg.norm(np.cross(X[1, 0], X[0, 1], axis=0), axis=0)
    points = surface.embed(p)
    return weight * area, points, surface.fields(points)


def assert_same_fields(actual: StartFields, expected: object, tolerance: float = 1e-11) -> None:
    """To ``tolerance`` of the largest entry, or of 1: round-off times powers of the curvature."""
    for name in FIELDS:
        a, b = getattr(actual, name), getattr(expected, name)
        atol = tolerance * max(1.0, np.abs(b).max())
        np.testing.assert_allclose(a, b, rtol=0, atol=atol, err_msg=name)


class TestFields:
    @each_surface
    def test_energy_area_and_volume_are_those_of_independent_codes(self, name):
        weight, points, fields = quadrature(name)
        found = (
            0.5 * np.sum(weight * fields.H**2),
            np.sum(weight),
            np.sum(weight * np.einsum("na,na->n", points, fields.nu)) / 3.0,
        )
        for value, expected in zip(found, REFERENCE[name], strict=True):
            if not np.isnan(expected):  # all digits that the reference shows
                np.testing.assert_allclose(value, expected, rtol=2e-9, atol=0)

    @each_surface
    def test_total_curvature_is_that_of_the_genus(self, name):
        weight, _, fields = quadrature(name)
        K = 0.5 * (fields.H**2 - (fields.S**2).sum(axis=(1, 2)))
        euler = 2 - 2 * named_surface(name).genus
        np.testing.assert_allclose(np.sum(weight * K), 2 * np.pi * euler, rtol=0, atol=1e-9)

    @each_surface
    def test_laplace_H_has_mean_zero(self, name):
        weight, _, fields = quadrature(name)
        scale = np.sum(weight * np.abs(fields.laplace_H))
        np.testing.assert_allclose(np.sum(weight * fields.laplace_H), 0, rtol=0, atol=1e-10 * scale)

    @each_surface
    def test_fields_belong_together(self, name):
        fields = quadrature(name)[2]
        np.testing.assert_allclose(np.linalg.norm(fields.nu, axis=1), 1.0, rtol=0, atol=1e-14)
        np.testing.assert_array_equal(fields.S, np.swapaxes(fields.S, 1, 2))
        largest = np.abs(fields.grad_z).max()
        for found, expected, scale in (
            (np.einsum("naa->n", fields.S), fields.H, 100.0),
            (np.einsum("naa->n", fields.grad_z), fields.laplace_H, largest),
            (np.einsum("na,na->n", fields.z, fields.nu), 0.0, largest),
            (np.einsum("nab,na->nb", fields.S, fields.nu), 0.0, 100.0),
        ):
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * scale)

    @each_surface
    def test_tangential_differences_of_fields_are_fields(self, name):
        """d nu = S dy, dH = z.dy, dz = grad_z^T dy, along curves on the surface."""
        surface = named_surface(name)
        y = surface.embed(parameters(surface.genus, 300))
        fields, eps = surface.fields(y), 1e-5
        tangent = np.cross(fields.nu, np.random.default_rng(1).standard_normal(y.shape))
        ends = [surface.closest_point(y + eps * sign * tangent) for sign in (1, -1)]
        dy = (ends[0] - ends[1]) / (2 * eps)
        a, b = (surface.fields(end) for end in ends)
        # Second differences of features of size 1/27: eps^2 27^2, and round-off / eps.
        for of, expected in (
            ("nu", np.einsum("nab,na->nb", fields.S, dy)),
            ("H", np.einsum("na,na->n", fields.z, dy)),
            ("z", np.einsum("nab,na->nb", fields.grad_z, dy)),
        ):
            difference = (getattr(a, of) - getattr(b, of)) / (2 * eps)
            atol = 3e-6 * np.abs(expected).max()
            np.testing.assert_allclose(difference, expected, rtol=0, atol=atol, err_msg=of)

    @pytest.mark.parametrize("name", ["ellipsoid", "red_blood_cell", "p2_sphere"])
    def test_level_set_and_map_agree(self, name):
        surface = named_surface(name)
        p = parameters(0, 2000)
        points = surface.embed(p)
        assert_same_fields(surface.fields(points), start_map(surface).fields_at(p))
        assert_same_fields(start_map(surface).fields(points), surface.fields(points))

    @pytest.mark.parametrize("kind", ROUND_TORUS)
    def test_torus_is_that_of_the_closed_forms(self, kind):
        torus = ROUND_TORUS[kind]
        points = torus.embed(parameters(1, 2000))
        exact = Torus(R=1.0, r=0.6).fields(points)
        assert_same_fields(torus.fields(points), exact)
        V = laws.velocity("willmore", {}, torus.fields(points))
        np.testing.assert_allclose(V, exact.V, rtol=0, atol=1e-11 * np.abs(exact.V).max())

    def test_spheroid_is_that_of_the_closed_forms(self):
        """Of which the axis is the first: a cyclic exchange of the axes."""
        surface = named_surface("spheroid")
        points = surface.embed(parameters(0, 2000))
        exact, found = Spheroid(1.5).fields(np.roll(points, 1, axis=1)), surface.fields(points)
        for name in ("nu", "z"):
            rolled = np.roll(getattr(found, name), 1, axis=1)
            np.testing.assert_allclose(rolled, getattr(exact, name), rtol=0, atol=1e-13)
        for name in ("H", "laplace_H"):
            np.testing.assert_allclose(
                getattr(found, name), getattr(exact, name), rtol=0, atol=1e-12
            )

    def test_p2_sphere_is_that_of_the_closed_forms(self):
        surface = named_surface("p2_sphere")
        points = surface.embed(parameters(0, 2000)[4:])  # their formulas differ at the poles
        exact = PerturbedSphere(amplitude=0.2, degree=2).fields(points, 0.0)
        assert_same_fields(surface.fields(points), exact)

    @pytest.mark.parametrize("kind", ["level_set", "parametrised"])
    def test_sphere_off_centre(self, kind):
        map_ = (2 * x + 1, 2 * y, 2 * z - 3)
        surface = {
            "level_set": LevelSet((x - 1) ** 2 + y**2 + (z + 3) ** 2 - 4, map_),
            "parametrised": Parametrised(map_),
        }[kind]
        p = parameters(0, 50)
        points = surface.embed(p)
        fields = surface.fields(points)
        np.testing.assert_allclose(fields.nu, p, rtol=0, atol=1e-14)
        np.testing.assert_allclose(fields.H, 1.0, rtol=1e-14, atol=0)
        np.testing.assert_allclose(fields.laplace_H, 0.0, rtol=0, atol=1e-13)

    @each_surface
    def test_normal_and_shape_are_those_of_the_fields(self, name):
        surface = named_surface(name)
        points = surface.embed(parameters(surface.genus, 100))
        nu, S = surface.normal_and_shape(points)
        fields = surface.fields(points)
        np.testing.assert_allclose(nu, fields.nu, rtol=0, atol=1e-13)
        np.testing.assert_allclose(S, fields.S, rtol=0, atol=1e-12 * np.abs(S).max())

    @each_surface
    def test_any_shape_of_points(self, name):
        surface = named_surface(name)
        points = surface.embed(parameters(surface.genus, 8)[:6].reshape(2, 3, -1))
        fields = surface.fields(points)
        assert points.shape == fields.nu.shape == (2, 3, 3)
        assert fields.H.shape == (2, 3) and fields.S.shape == (2, 3, 3, 3)
        assert_same_fields(
            surface.fields(points[1, 2]),
            StartFields(*(getattr(fields, name)[1, 2] for name in FIELDS)),
        )
        assert surface.fields(points[:0]).S.shape == (0, 3, 3, 3)


class TestClosestPoint:
    @each_surface
    def test_is_found_along_the_normal(self, name):
        surface = named_surface(name)
        y = surface.embed(parameters(surface.genus, 1000))
        nu, S = surface.normal_and_shape(y)
        reach = 0.5 / np.abs(np.linalg.eigvalsh(S)).max()
        for distance in (-reach, 0.0, reach):
            found = surface.closest_point(y + distance * nu)
            np.testing.assert_allclose(found, y, rtol=0, atol=2e-14)

    @each_surface
    def test_no_sample_is_nearer(self, name):
        surface = named_surface(name)
        samples = surface.embed(parameters(surface.genus, 2000, seed=1))
        y = surface.embed(parameters(surface.genus, 100, seed=2))
        x = y + 0.03 * np.random.default_rng(3).standard_normal(y.shape)
        found = np.linalg.norm(surface.closest_point(x) - x, axis=1)
        nearest = np.linalg.norm(x[:, None] - samples, axis=2).min(axis=1)
        assert (found <= nearest + 1e-14).all()

    def test_far_outside_a_convex_surface(self):
        for name in ("ellipsoid", "spheroid"):
            surface = named_surface(name)
            y = surface.embed(parameters(0, 200))
            far = y + 20.0 * surface.normal_and_shape(y)[0]
            np.testing.assert_allclose(surface.closest_point(far), y, rtol=0, atol=1e-13)

    @each_surface
    @pytest.mark.parametrize("value", [np.nan, np.inf])
    def test_what_is_not_finite_is_refused(self, name, value):
        with pytest.raises(ValueError, match=r"x = .*must be finite"):
            named_surface(name).closest_point(np.array([[1.0, value, 0.0]]))

    def test_a_centre_has_no_closest_point(self):
        sphere = LevelSet(RADIUS - 1, (x, y, z))
        with pytest.raises(ValueError, match="too far"):
            sphere.closest_point(np.zeros((1, 3)))


class TestSizeAndPlace:
    """Tolerances are relative to the size of the surface, wherever it lies."""

    SIDES = (1, 2, Rational(3, 2))

    def ellipsoid(self, size: float, centre: tuple[float, float, float]) -> LevelSet:
        l, c = sympy.Float(size), [sympy.Float(a) for a in centre]
        terms = [((X - a) / (l * s)) ** 2 for X, a, s in zip((x, y, z), c, self.SIDES, strict=True)]
        start = [a + l * s * X for X, a, s in zip((x, y, z), c, self.SIDES, strict=True)]
        return LevelSet(sum(terms) - 1, tuple(start))

    @pytest.mark.parametrize(
        ("size", "centre", "tolerance"),
        [
            (2.0**-30, (0.0, 0.0, 0.0), 1e-13),
            (2.0**23, (0.0, 0.0, 0.0), 1e-13),
            (1.0, (1e5, 0.0, 0.0), 1e-9),  # of positions 1e-11 are lost, of their Newton steps more
            (1e-3, (0.0, 100.0, 0.0), 1e-9),
        ],
    )
    def test_fields_are_those_of_the_unit(self, size, centre, tolerance):
        unit, found = self.ellipsoid(1.0, (0.0, 0.0, 0.0)), self.ellipsoid(size, centre)
        p = parameters(0, 200)
        points = unit.embed(p)
        moved = found.embed(p)
        np.testing.assert_allclose((moved - centre) / size, points, rtol=0, atol=tolerance)
        off = points + 0.1 * unit.normal_and_shape(points)[0]
        back = found.closest_point(np.array(centre) + size * off)
        np.testing.assert_allclose((back - centre) / size, points, rtol=0, atol=tolerance)
        expected, fields = unit.fields(points), found.fields(back)
        for name, power in {"nu": 0, "H": 1, "S": 1, "z": 2, "grad_z": 3, "laplace_H": 3}.items():
            scale = np.abs(getattr(expected, name)).max()
            value = getattr(fields, name) * size**power
            np.testing.assert_allclose(
                value, getattr(expected, name), rtol=0, atol=10 * tolerance * scale, err_msg=name
            )

    def test_a_vanishing_gradient_is_still_refused(self):
        squared = LevelSet((x**2 + y**2 + z**2 - 1) ** 2, (x, y, z))
        with pytest.raises(ValueError, match="gradient"):
            squared.embed(parameters(0, 10))


class TestProfile:
    @pytest.mark.parametrize("name", ["ellipsoid", "spheroid", "red_blood_cell", "p2_sphere"])
    def test_profile_revolves_to_the_surface(self, name):
        surface = named_surface(name)
        s = np.linspace(0.0, np.pi, 101)
        rho, height = surface.profile()(s)
        for angle in (0.0, 2.0):
            points = np.stack([rho * np.cos(angle), rho * np.sin(angle), height], axis=1)
            found = surface.closest_point(points)
            np.testing.assert_allclose(found, points, rtol=0, atol=1e-13)


class TestRegistry:
    def test_all_surfaces_are_there(self):
        assert set(NAMES) == set(REFERENCE) == set(surfaces())

    def test_unknown_name_lists_the_known(self):
        with pytest.raises(ValueError, match=r"surface = 'cube': must be one of beads_torus, ell"):
            named_surface("cube")

    @pytest.fixture
    def folder(self, tmp_path, monkeypatch):
        monkeypatch.setattr(registry, "__path__", [*registry.__path__, str(tmp_path)])
        return tmp_path

    def test_a_new_file_is_found(self, folder):
        text = "from sympy.abc import x, y, z\n"
        text += "from esfem.reference_solutions.calculus import Parametrised\n"
        text += "SURFACE = Parametrised((x, y, 3 * z))\n"
        (folder / "found_surface.py").write_text(text)
        assert "found_surface" in surface_names()
        assert named_surface("found_surface").embed(POLES)[0, 2] == 3.0

    def test_a_file_without_surface_is_refused(self, folder):
        (folder / "empty_surface.py").write_text('"""Nothing."""\n')
        with pytest.raises(ValueError, match=r"empty_surface.*must define SURFACE"):
            named_surface("empty_surface")

    @pytest.mark.parametrize(
        ("old", "new", "same"), [("A comment.", "Words.", True), ("3 * z", "4 * z", False)]
    )
    def test_digest_sees_code_only(self, folder, old, new, same):
        text = '"""A comment."""\nfrom sympy.abc import x, y, z\n'
        text += "from esfem.reference_solutions.calculus import Parametrised\n"
        text += "SURFACE = Parametrised((x, y, 3 * z))\n"
        path = folder / f"digested_{same}.py"
        path.write_text(text)
        before = surface_digest(path.stem)
        path.write_text(text.replace(old, new))
        assert (surface_digest(path.stem) == before) is same

    def test_digests_differ(self):
        assert len({surface_digest(name) for name in NAMES}) == len(NAMES)

    @pytest.mark.parametrize(
        ("make", "message"),
        [
            (lambda: LevelSet(x, (x, y)), "start = .*three expressions"),
            (lambda: LevelSet(x, (x, y, z), genus=2), "genus = 2: must be 0 or 1"),
            (lambda: Parametrised((x, y)), "X = .*three expressions"),
            (lambda: Parametrised((x, y, z), genus=-1), "genus = -1: must be 0 or 1"),
        ],
    )
    def test_bad_surface_is_refused(self, make, message):
        with pytest.raises(ValueError, match=message):
            make()
