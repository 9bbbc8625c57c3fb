"""The axisymmetric reference solver: geometry, laws and flows.

Expected flow values come from separate one-dimensional codes (a graph over the sphere, and a
level set), given to the digits shown; a tolerance of half a unit of the last digit would be met by
chance of rounding only, so one unit is allowed.
"""

import numpy as np
import pytest
from profiles import SHAPES, torus_profile

from esfem.reference_solutions.axisymmetric import (
    DENSITIES,
    VELOCITIES,
    coefficient_jacobian,
    coefficient_velocity,
    coefficients,
    evolve_profile,
    geometry,
    measure,
)
from esfem.reference_solutions.profile_curve import (
    Galerkin,
    Profile,
    equal_arclength,
    fit_profile,
    perturbed_sphere_profile,
    red_blood_cell_profile,
    spheroid_profile,
)
from esfem.reference_solutions.profile_distance import distance_to_curve


def on_nodes(profile, K):
    """Space, coefficients and geometry of the profile in arclength."""
    even = equal_arclength(profile, K)
    space = Galerkin(even.genus, K)
    return space, coefficients(even), geometry(space, coefficients(even))


def spheroid_error(a, c, K):
    """Largest relative errors of H, |S|^2 and Lap H on a spheroid, against calculus by hand.

    With sin p = rho/a, cos p = -z/c, q = a^2 cos^2 p + c^2 sin^2 p, D = c^2 - a^2:
    kappa_1 = a c q^(-3/2), kappa_2 = (c/a) q^(-1/2), and rho H_p/sqrt(q) = -a D f B with
    f = sin^2 p cos p, B = 3 a c q^-3 + (c/a) q^-2.
    """
    space, x, G = on_nodes(spheroid_profile(a, c), K)
    n = space.rho_waves[0].shape[1]
    sin, cos = G.rho / a, -(space.z_waves[0] @ x[n:]) / c
    D = c**2 - a**2
    q = a**2 * cos**2 + c**2 * sin**2
    q_p = 2.0 * D * sin * cos
    kappa_1, kappa_2 = a * c * q**-1.5, c / a * q**-0.5
    f, f_p = sin**2 * cos, 2.0 * sin * cos**2 - sin**3
    B, B_p = 3.0 * a * c / q**3 + c / a / q**2, -q_p * (9.0 * a * c / q**4 + 2.0 * c / a / q**3)
    laplace_H = -a * D * (f_p * B + f * B_p) / (np.sqrt(q) * a * sin)
    pairs = (
        (G.H, kappa_1 + kappa_2),
        (G.S2, kappa_1**2 + kappa_2**2),
        (G.laplace_H, laplace_H),
    )
    return np.array([np.abs(u - v).max() / np.abs(v).max() for u, v in pairs])


class TestGeometry:
    @pytest.mark.parametrize("radius", [0.5, 1.0, 3.0])
    def test_sphere(self, radius):
        _, _, G = on_nodes(spheroid_profile(radius, radius), 16)
        np.testing.assert_allclose(G.H, 2.0 / radius, rtol=1e-12)  # round-off times k^2
        np.testing.assert_allclose(G.S2, 2.0 / radius**2, rtol=1e-12)
        np.testing.assert_allclose(G.laplace_H, 0.0, atol=1e-9 / radius**3)  # times k^4

    def test_torus(self):
        """H = 1/r + cos/rho, and Lap H from V = R (R^2 - 2 r^2)/(2 r^3 rho^3)."""
        R, r = 1.0, 0.6
        _, _, G = on_nodes(torus_profile(R, r), 16)  # H_k falls like 3^-k, resolved to k = 31
        kappa = (G.rho - R) / (r * G.rho)
        # round-off, 1e-14 in each coefficient (of k s), times k^2, and in V times k^4
        np.testing.assert_allclose(G.H, 1.0 / r + kappa, rtol=1e-10)
        np.testing.assert_allclose(G.S2, 1.0 / r**2 + kappa**2, rtol=1e-10)
        V = VELOCITIES["willmore"](G, 0.0)
        expected = R * (R**2 - 2.0 * r**2) / (2.0 * r**3 * G.rho**3)
        np.testing.assert_allclose(V, expected, atol=1e-7)

    @pytest.mark.parametrize(("a", "c"), [(1.0, 1.5), (1.0, 0.7)])
    def test_spheroid_curvatures_converge_spectrally(self, a, c):
        """Twice the modes square the error, until round-off times k^4 (about 1e-8)."""
        coarse, fine = spheroid_error(a, c, 16), spheroid_error(a, c, 32)
        assert np.all(coarse < 3e-2)
        assert np.all(fine < coarse**1.8)
        assert np.all(spheroid_error(a, c, 48) < 1e-7)

    def test_nodes_are_equally_spaced_in_arclength(self):
        for profile in SHAPES.values():
            _, _, G = on_nodes(profile, 48)
            np.testing.assert_allclose(G.g, G.g.mean(), rtol=1e-6)  # K = 48: tails below 1e-8

    def test_equal_arclength_keeps_the_curve(self):
        for profile in SHAPES.values():
            rho, z = equal_arclength(profile, 48)(np.linspace(0.1, 3.0, 50))
            assert distance_to_curve(rho, z, profile).max() < 1e-7  # tails below 1e-8


class TestMeasures:
    def test_spheroid_volume(self):
        measured = measure(equal_arclength(spheroid_profile(1.0, 2.0), 64))
        assert measured["volumes"] == pytest.approx(8.0 * np.pi / 3.0, rel=1e-9)
        np.testing.assert_allclose(measured["poles"], [-2.0, 2.0], atol=1e-8)
        assert measured["equators"] == pytest.approx(1.0, abs=1e-8)

    def test_torus_area_volume_energy(self):
        R, r = 1.0, 0.6
        measured = measure(equal_arclength(torus_profile(R, r), 32))
        q = R / r
        assert measured["areas"] == pytest.approx(4.0 * np.pi**2 * R * r, rel=1e-12)
        assert measured["volumes"] == pytest.approx(2.0 * np.pi**2 * R * r**2, rel=1e-12)
        W = 2.0 * np.pi**2 * q**2 / np.sqrt(q**2 - 1.0)
        assert measured["willmore"] == pytest.approx(W, rel=1e-11)
        assert measured["poles"].shape == (0,)
        assert measured["equators"] == pytest.approx(R + r, abs=1e-12)

    @pytest.mark.parametrize(
        ("profile", "W"),
        [
            (spheroid_profile(1.0, 1.5), 27.15748311),
            (spheroid_profile(1.0, 2.0), 30.90321329),
            (perturbed_sphere_profile(0.2, 2), 26.25458556),
            (red_blood_cell_profile(), 46.148734656),
        ],
    )
    def test_willmore_at_the_start(self, profile, W):
        assert measure(equal_arclength(profile, 64))["willmore"] == pytest.approx(W, abs=1e-8)

    @pytest.mark.parametrize("law", VELOCITIES)
    def test_the_energy_is_that_of_the_law_and_W_stands_beside_it(self, law):
        measured = measure(equal_arclength(torus_profile(1.0, 0.6), 32), law, 0.7)
        W, A, total_H = measured["willmore"], measured["areas"], 4.0 * np.pi**2  # int H of a torus
        energies = {"willmore": W, "helfrich": W - 0.7 * total_H + 0.245 * A}
        assert measured["energies"] == pytest.approx(energies.get(law, A), rel=1e-11)
        assert measure(equal_arclength(torus_profile(1.0, 0.6), 32))["willmore"] == W

    def test_area_and_volume_of_the_red_blood_cell(self):
        measured = measure(equal_arclength(red_blood_cell_profile(), 64))
        assert measured["areas"] == pytest.approx(33.257086818, abs=2e-9)
        assert measured["volumes"] == pytest.approx(11.728612573, abs=2e-9)


def variation(profile, law, H0, functional):
    """(d/dt of the functional along the law's velocity, geometry, V, area element)."""
    space, c, G = on_nodes(profile, 64)
    rate = coefficient_velocity(space, c, law, H0)
    element = 2.0 * np.pi * space.weights * G.rho * G.g
    moved = geometry(space, c + 1e-30j * rate)
    rate_of = functional(space, moved).imag / 1e-30
    return rate_of, G, VELOCITIES[law](G, H0), element


class TestLaws:
    """First variations: they tie Q, its signs and Lap H to the energy alone."""

    @pytest.mark.parametrize("shape", SHAPES)
    @pytest.mark.parametrize(
        ("law", "H0"), [("willmore", 0.0), ("helfrich", 0.7), ("mean_curvature", 0.0)]
    )
    def test_energy_falls_by_the_square_of_the_velocity(self, shape, law, H0):
        """L2 gradient flows; surface diffusion, in H^-1, has its own test."""

        def energy(space, G):
            return 2.0 * np.pi * space.weights @ (DENSITIES[law](G.H, H0) * G.rho * G.g)

        rate, _, V, element = variation(SHAPES[shape], law, H0, energy)
        # velocities are truncated at K = 64, where the rows of V are below 1e-6 of the largest
        assert rate == pytest.approx(-element @ V**2, rel=1e-6)

    @pytest.mark.parametrize("shape", SHAPES)
    def test_surface_diffusion_shrinks_area_and_keeps_volume(self, shape):
        def area(space, G):
            return 2.0 * np.pi * space.weights @ (G.rho * G.g)

        def volume(space, G):
            return np.pi * space.weights @ (G.rho**2 * G.z_s)

        rate, G, V, element = variation(SHAPES[shape], "surface_diffusion", 0.0, area)
        assert rate == pytest.approx(element @ (G.H * V), rel=1e-6)
        assert rate < 0.0
        rate, *_ = variation(SHAPES[shape], "surface_diffusion", 0.0, volume)
        assert abs(rate) < 1e-7 * (element @ np.abs(V))

    @pytest.mark.parametrize("law", VELOCITIES)
    def test_tangential_motion_keeps_equal_arclength(self, law):
        space, c, _ = on_nodes(SHAPES["spheroid"], 64)
        moved = geometry(space, c + 1e-30j * coefficient_velocity(space, c, law, 0.0))
        g_t = moved.g.imag / 1e-30
        np.testing.assert_allclose(g_t, g_t.mean(), atol=1e-6 * np.abs(g_t.mean()))

    @pytest.mark.parametrize("law", ["willmore", "surface_diffusion"])
    def test_decay_rates_on_the_sphere(self, law):
        """(l-1) l (l+1) (l+2) = 24, 120, 360, 840 are the slowest of the linearised flow."""
        space, c, _ = on_nodes(spheroid_profile(1.0, 1.0), 24)
        rates = -np.linalg.eigvals(coefficient_jacobian(space, c, law, 0.0)).real
        decaying = np.sort(rates[np.abs(rates) > 1.0])
        np.testing.assert_allclose(decaying[:4], [24.0, 120.0, 360.0, 840.0], rtol=1e-8)

    def test_decay_rates_on_the_clifford_torus(self):
        space, c, _ = on_nodes(torus_profile(1.0, np.sqrt(0.5)), 24)
        rates = -np.linalg.eigvals(coefficient_jacobian(space, c, "willmore", 0.0)).real
        decaying = np.sort(rates[np.abs(rates) > 1.0])
        np.testing.assert_allclose(decaying[:2], [17.2643, 33.3319], atol=1e-4)  # digits given


class TestFlow:
    @pytest.mark.parametrize(
        ("law", "column", "expected"),
        [
            ("willmore", "willmore", [25.87939379, 25.28653528, 25.15033277, 25.13293194]),
            ("willmore", "areas", [12.93404885, 12.88435456, 12.87276402, 12.87127920]),
            ("willmore", "volumes", [4.30715036, 4.33530053, 4.34139010, 4.34214909]),
            ("willmore", "poles", [1.17774967, 1.08576174, 1.03665744, 1.01460518]),
            ("willmore", "equators", [0.92579497, 0.97473996, 0.99970739, 1.01078472]),
            ("surface_diffusion", "willmore", [25.89599107, 25.29711450, 25.15156705, 25.13293399]),
            ("surface_diffusion", "areas", [12.90516920, 12.79873871, 12.77364075, 12.77046873]),
        ],
    )
    def test_perturbed_sphere(self, law, column, expected):
        flow = evolve_profile(SHAPES["perturbed_sphere"], law, [0, 0.01, 0.05, 0.1, 0.2], 0, 40)
        values = flow.poles[:, 1] if column == "poles" else getattr(flow, column)
        np.testing.assert_allclose(values[1:], expected, atol=1e-8)

    def test_helfrich_energy_of_the_perturbed_sphere(self):
        flow = evolve_profile(SHAPES["perturbed_sphere"], "helfrich", [0.0, 0.1, 1.0], 1.0, 40)
        expected = [6.98253138, 5.17995709, 1.77347768]
        np.testing.assert_allclose(flow.energies, expected, rtol=0, atol=1e-8)
        assert flow.willmore[0] == pytest.approx(26.25458556, rel=0, abs=1e-8)

    @pytest.mark.parametrize(
        ("shape", "K", "areas", "volumes"),
        [
            ("perturbed_sphere", 40, [10.34914163, 7.75294998], [3.07180758, 1.99922698]),
            ("ellipsoid", 64, [18.42052344, 15.41862504], [6.71104315, 5.18408762]),
        ],
    )
    def test_mean_curvature_flow(self, shape, K, areas, volumes):
        start = {**SHAPES, "ellipsoid": spheroid_profile(1.0, 2.0)}[shape]
        flow = evolve_profile(start, "mean_curvature", [0.0, 0.05, 0.1], 0.0, K)
        np.testing.assert_allclose(flow.areas[1:], areas, rtol=0, atol=1e-8)
        np.testing.assert_allclose(flow.volumes[1:], volumes, rtol=0, atol=1e-8)

    def test_mean_curvature_shrinks_spheres(self):
        """R^2 = R0^2 - 4 t."""
        flow = evolve_profile(spheroid_profile(1.0, 1.0), "mean_curvature", [0, 0.1, 0.2], 0, 16)
        np.testing.assert_allclose(flow.equators, np.sqrt([1.0, 0.6, 0.2]), rtol=1e-8)

    def test_a_flow_beyond_its_extinction_is_refused_by_time(self):
        with pytest.raises(RuntimeError, match=r"not met at t = 0\.2"):
            evolve_profile(spheroid_profile(1.0, 1.0), "mean_curvature", [0.0, 0.3], 0.0, 16)

    @pytest.mark.parametrize("law", ["surface_diffusion", "mean_curvature"])
    def test_the_energy_of_flows_of_the_area_is_the_area(self, law):
        flow = evolve_profile(SHAPES["spheroid"], law, [0.0, 0.01], 0.0, 32)
        np.testing.assert_allclose(flow.energies, flow.areas, rtol=1e-13)

    @pytest.mark.parametrize(
        ("R0", "H0", "t", "R"),
        [
            (1.0, 1.0, 1.0, 1.46528861820),
            (1.0, 1.0, 4.0, 1.81653745976),
            (3.0, 1.0, 1.0, 2.89107493519),
            (1.0, -1.0, 0.1, 0.53993754361),
        ],
    )
    def test_sphere_with_spontaneous_curvature(self, R0, H0, t, R):
        """R' = H0 (2 - H0 R)/R^2."""
        flow = evolve_profile(spheroid_profile(R0, R0), "helfrich", [0, t], H0, 8, 1e-10)
        assert flow.equators[-1] == pytest.approx(R, rel=1e-8)
        np.testing.assert_allclose(flow.poles[-1], [-R, R], rtol=1e-8)

    @pytest.mark.parametrize("law", ["willmore", "surface_diffusion"])
    def test_sphere_stands_still(self, law):
        flow = evolve_profile(spheroid_profile(2.0, 2.0), law, [0.0, 10.0], 0.0, 16)
        np.testing.assert_allclose(flow.willmore, 8.0 * np.pi, rtol=1e-10)
        np.testing.assert_allclose(flow.equators, 2.0, rtol=1e-10)

    @pytest.mark.parametrize("law", ["willmore", "surface_diffusion"])
    def test_scaling(self, law):
        """x -> x/64, t -> t/64^4: the same digits, for the tolerance is relative to the size."""
        size = 1.0 / 64.0
        one = evolve_profile(spheroid_profile(1.0, 1.5), law, [0.0, 0.05], 0.0, 32)
        start = spheroid_profile(size, 1.5 * size)
        small = evolve_profile(start, law, [0.0, 0.05 * size**4], 0.0, 32)
        assert small.willmore[-1] == pytest.approx(one.willmore[-1], rel=1e-9)
        assert small.areas[-1] == pytest.approx(one.areas[-1] * size**2, rel=1e-9)
        assert small.equators[-1] == pytest.approx(one.equators[-1] * size, rel=1e-9)

    def test_times_between_change_nothing(self):
        """Each time is reached by a step; also one so near that the next step must be cut."""
        start = SHAPES["spheroid"]
        one = evolve_profile(start, "willmore", [0.0, 0.05], 0.0, 32)
        many = evolve_profile(start, "willmore", [0.0, 0.02, 0.02 + 1e-9, 0.05], 0.0, 32)
        assert many.energies[-1] == pytest.approx(one.energies[-1], rel=1e-8)  # ten times rtol
        assert many.energies[2] == pytest.approx(many.energies[1], rel=1e-6)

    def test_willmore_flow_of_a_torus_tends_to_a_clifford_torus(self):
        """Linear rate 17.2643 at R = 1, so 2 * 17.2643/R^4 for the energy at the limit's R."""
        flow = evolve_profile(SHAPES["torus"], "willmore", [0.0, 0.1, 0.2, 0.3], 0.0, 32)
        excess = flow.energies - 4.0 * np.pi**2
        assert np.all(np.diff(flow.energies) < 0.0)
        assert np.all(excess > 0.0)
        R = flow.equators[-1] / (1.0 + np.sqrt(0.5))
        rate = np.log(excess[2] / excess[3]) / 0.1 * R**4 / 2.0
        # the next order of the excess, about sqrt(excess) = 6e-3 at t = .2, is what is left
        assert rate == pytest.approx(17.2643, rel=3e-3)

    def test_resolution_and_tolerance_agree(self):
        coarse = evolve_profile(SHAPES["pear"], "willmore", [0.0, 0.02], 0.0, 32, 1e-7)
        fine = evolve_profile(SHAPES["pear"], "willmore", [0.0, 0.02], 0.0, 48, 1e-9)
        s = np.linspace(0.0, np.pi, 40)
        assert distance_to_curve(*coarse.profile(1)(s), fine.profile(1)).max() < 1e-7

    @pytest.mark.slow
    def test_red_blood_cell(self):
        times = [0, 0.001, 0.01, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 3.0]
        flow = evolve_profile(red_blood_cell_profile(), "willmore", times)
        expected = [45.74854, 44.10985, 38.22892, 33.09775, 27.95119]
        np.testing.assert_allclose(flow.energies[1:6], expected, atol=1e-5)
        np.testing.assert_allclose(flow.energies[6:8], [25.285682, 25.134647], atol=1e-6)
        assert np.sqrt(flow.areas[-1] / (4.0 * np.pi)) == pytest.approx(1.541363, abs=1e-6)

    @pytest.mark.slow
    def test_long_ellipsoid(self):
        start = spheroid_profile(1.0, 2.0)
        flow = evolve_profile(start, "willmore", [0, 0.1, 0.15, 0.5])
        np.testing.assert_allclose(
            flow.energies[1:], [26.85344907, 26.04256894, 25.13603378], atol=1e-8
        )
        flow = evolve_profile(start, "surface_diffusion", [0, 0.1, 0.15])
        np.testing.assert_allclose(flow.willmore[1:], [27.02490938, 26.14920374], atol=1e-8)
        np.testing.assert_allclose(flow.areas[1:], [20.48733952, 20.23048819], atol=1e-8)
        np.testing.assert_allclose(flow.volumes, 8.37758041, atol=1e-8)
        np.testing.assert_allclose(flow.poles[-1], [-1.50964028, 1.50964028], atol=1e-8)
        assert flow.equators[-1] == pytest.approx(1.13759681, abs=1e-8)

    @pytest.mark.slow
    def test_short_ellipsoid(self):
        flow = evolve_profile(spheroid_profile(1.0, 1.5), "willmore", [0, 0.1, 2.0])
        assert flow.energies[1] == pytest.approx(25.34731438, abs=1e-8)
        assert flow.equators[-1] == pytest.approx(1.15330126, abs=1e-8)


class TestBadInput:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"law": "ricci"}, "law = 'ricci': must be one of willmore, helfrich, surface_diff"),
            ({"times": [0.0, 0.2, 0.1]}, r"times = \[0.0, 0.2, 0.1\]: must start with 0"),
            ({"times": [0.1, 0.2]}, r"times = \[0.1, 0.2\]: must start with 0"),
            ({"times": []}, r"times = \[\]: must start with 0"),
            ({"spontaneous_curvature": 1.0}, "spontaneous_curvature = 1.0: must be 0"),
            ({"resolution": 4}, "resolution = 4: must be at least 8"),
            ({"resolution": 8}, "resolution = 8: leaves a tail"),
            ({"rtol": 0.0}, "rtol = 0.0: must be a positive"),
        ],
    )
    def test_evolve_profile(self, arguments, message):
        good = {"profile": spheroid_profile(1.0, 2.0), "law": "willmore", "times": [0.0, 0.1]}
        with pytest.raises(ValueError, match=message):
            evolve_profile(**(good | arguments))

    def test_profile_that_meets_the_axis(self):
        with pytest.raises(ValueError, match=r"rho = -0\..*must be > 0 off the poles"):
            torus_profile(0.5, 0.6)

    def test_clockwise_profile(self):
        with pytest.raises(ValueError, match="must run counterclockwise"):
            fit_profile(0, lambda s: (np.sin(s), np.cos(s)), 2)

    def test_genus(self):
        with pytest.raises(ValueError, match="genus = 2: must be 0 or 1"):
            Profile(2, np.ones(3), np.ones(3))

    def test_numbers_of_coefficients(self):
        with pytest.raises(ValueError, match="z = 3 coefficients: must be 4"):
            Profile(0, np.ones(3), np.ones(3))

    @pytest.mark.parametrize(("a", "c", "name"), [(0.0, 1.0, "a = 0.0"), (1.0, -1.0, "c = -1.0")])
    def test_half_axes(self, a, c, name):
        with pytest.raises(ValueError, match=f"{name}: must be a positive"):
            spheroid_profile(a, c)

    def test_extinction_is_an_error(self):
        """The sphere with H0 = -1, R0 = 1 vanishes at t = 0.12186."""
        with pytest.raises(RuntimeError, match=r"not met at t = 0.12186"):
            evolve_profile(spheroid_profile(1.0, 1.0), "helfrich", [0.0, 0.13], -1.0, 8)

    def test_curve_that_outgrows_its_resolution_is_an_error(self):
        """A dumbbell just before its neck pinches off, at t = 0.01446 for K = 128."""

        def dumbbell(s):
            return np.sin(s) * (1.0 - 0.8 * np.sin(s) ** 2), -4.0 * np.cos(s)

        with pytest.raises(RuntimeError, match=r"resolution = 48: leaves a tail .* at t = 0.0144"):
            evolve_profile(
                fit_profile(0, dumbbell, 8), "surface_diffusion", [0, 0.0144], 0.0, 48, 1e-8
            )
