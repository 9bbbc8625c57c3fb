"""The unit of length of each solution: from its area, known independently, and scaling with it."""

import numpy as np
import pytest

from esfem.reference_solutions import (
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
    Torus,
)
from esfem.reference_solutions.axisymmetric import measure
from esfem.reference_solutions.calculus.embedded_area import embedded_area
from esfem.reference_solutions.exact import length_of
from esfem.reference_solutions.profile_curve import equal_arclength
from esfem.reference_solutions.surfaces import named_surface, surfaces

PROLATE = 2.0 * np.pi * (1.0 + 4.0 / np.sqrt(3.0) * np.arcsin(np.sqrt(3.0) / 2.0))  # 2:1:1
# Areas by other programs, in one dimension or symbolic: all digits shown agree of two resolutions.
AREAS = {
    "p2_sphere": (12.96379802, 1e-8),
    "red_blood_cell": (33.257086818, 1e-9),
    "wave_torus": (31.907602638, 1e-9),
    "beads_torus": (17.220882783, 1e-9),
    "ellipsoid": (PROLATE, 1e-10),
}
# With all lengths times a factor l.
BY_SIZE = {
    "sphere": lambda l: StationarySphere(l),
    "clifford_torus": lambda l: CliffordTorus(l),
    "helfrich_sphere": lambda l: HelfrichSphere(l, 1.0 / l),
    "logistic_sphere": lambda l: LogisticSphere(l, 2.0 * l, 0.5 / l**4),
    "shrinking_sphere": lambda l: ShrinkingSphere(l),
    "perturbed_sphere": lambda l: PerturbedSphere(l, 0.2),
    "perturbed_clifford_torus": lambda l: PerturbedCliffordTorus(l, 0.1 * l),
}


class TestLength:
    @pytest.mark.parametrize("name", AREAS)
    def test_of_the_named_surfaces(self, name):
        area, error = AREAS[name]
        found = 4.0 * np.pi * SurfaceFlow(name).length ** 2
        assert abs(found - area) < error, found

    @pytest.mark.parametrize("name", [n for n, s in surfaces().items() if s.profile is not None])
    def test_agrees_with_the_profile_curve(self, name):
        profile = equal_arclength(named_surface(name).profile(), 64)
        expected = length_of(measure(profile)["areas"])
        assert abs(SurfaceFlow(name).length / expected - 1.0) < 1e-10

    def test_of_spheres_is_the_radius(self):
        assert StationarySphere(1.7).length == 1.7
        assert LogisticSphere(1.3).length == 1.3
        assert BreathingEllipsoid().length == 1.0

    def test_of_the_clifford_torus(self):
        """sqrt(pi R r)."""
        expected = np.sqrt(np.pi * 2.0 * np.sqrt(2.0))
        assert abs(CliffordTorus(2.0).length / expected - 1.0) < 1e-15

    def test_of_perturbed_surfaces_against_the_embedding(self):
        sphere = PerturbedSphere(1.0, 0.2)  # that of the named surface
        assert abs(4.0 * np.pi * sphere.length**2 - AREAS["p2_sphere"][0]) < 1e-8
        torus = PerturbedCliffordTorus(1.0, 0.1)

        def embed(p):
            tube = torus.torus.r + torus.amplitude * torus.mode(p[:, 1], p[:, 0])
            rho, height = 1.0 + tube * np.cos(p[:, 1]), tube * np.sin(p[:, 1])
            return np.stack([rho * np.cos(p[:, 0]), rho * np.sin(p[:, 0]), height], axis=1)

        assert abs(torus.length / length_of(embedded_area(embed, 1)) - 1.0) < 1e-10

    @pytest.mark.parametrize("exponent", [-10, 10])
    @pytest.mark.parametrize("name", BY_SIZE)
    def test_scales_exactly_by_powers_of_two(self, name, exponent):
        l = 2.0**exponent
        assert BY_SIZE[name](l).length == l * BY_SIZE[name](1.0).length

    def test_every_solution_has_one(self):
        for name, solution in STARTS.items():
            made = SurfaceFlow("ellipsoid") if name == "surface" else solution()
            assert 0.0 < made.length < np.inf


class TestEmbeddedArea:
    def test_of_a_torus(self):
        torus = Torus(1.0, 0.6)

        def embed(p):
            rho, height = 1.0 + 0.6 * np.cos(p[:, 1]), 0.6 * np.sin(p[:, 1])
            return np.stack([rho * np.cos(p[:, 0]), rho * np.sin(p[:, 0]), height], axis=1)

        assert abs(embedded_area(embed, 1) / torus.area - 1.0) < 1e-12

    def test_does_not_depend_on_where_the_poles_are(self):
        axes = np.array([2.0, 1.0, 1.0])
        for order in ([0, 1, 2], [1, 2, 0], [2, 0, 1]):
            assert abs(embedded_area(lambda p, a=axes[order]: p * a, 0) - PROLATE) < 1e-11

    def test_refuses_what_it_does_not_resolve(self):
        with pytest.raises(ValueError, match="do not resolve the surface"):
            embedded_area(lambda p: p * (1.0 + 0.1 * np.abs(p[:, :1])), 0)
