"""Geometry at quadrature points: dual bases, invariances, decay of errors under refinement."""

import dataclasses

import numpy as np
import pytest
from scipy.stats import ortho_group

from esfem.reference_solutions import CliffordTorus, StationarySphere
from esfem.solver.functionals import mesh_width
from esfem.solver.geometry import geometry, gradient, interpolate, reference_gradient
from esfem.solver.mesh import Mesh
from esfem.solver.reference_element import DEGREES

each_degree = pytest.mark.parametrize("k", DEGREES)
SOLUTIONS = {"sphere": StationarySphere(), "clifford_torus": CliffordTorus()}
AREA = {"sphere": 4.0 * np.pi, "clifford_torus": 2.0 * np.sqrt(2.0) * np.pi**2}
LEVELS = (240, 480, 960)
ROUNDING = {"rtol": 0, "atol": 1e-12}  # fields of size one, elements of size about 1/3


def orders(raised, surface: str, k: int, error) -> np.ndarray:
    """log(error ratio) / log(width ratio) of consecutive levels."""
    h, e = [], []
    for V in LEVELS:
        mesh, x = raised(surface, V, k)
        geo = geometry(mesh, x)
        h.append(mesh_width(geo))
        e.append(error(geo))
    return np.diff(np.log(e)) / np.diff(np.log(h))


def rotation(seed: int = 0) -> np.ndarray:
    R = ortho_group.rvs(3, random_state=seed)
    return R * np.sign(np.linalg.det(R))


class TestOrders:
    """Errors of all levels lie far above round-off: the least is 1e-9 (area, sphere, k = 4)."""

    # Interpolation of degree k: symmetry of the rule gives even orders of the area.
    @pytest.mark.parametrize(("k", "order"), [(1, 2), (2, 4), (3, 4), (4, 6)])
    @pytest.mark.parametrize("surface", SOLUTIONS)
    def test_area(self, raised, surface, k, order):
        measured = orders(raised, surface, k, lambda geo: abs(geo.dA.sum() - AREA[surface]))
        np.testing.assert_allclose(measured, order, rtol=0, atol=0.2)  # irregular levels

    # Order k; on a sphere, which is umbilic, P_2 and P_4 do one better.
    @pytest.mark.parametrize(
        ("surface", "k", "order"),
        [("sphere", 1, 1), ("sphere", 2, 3), ("sphere", 3, 3), ("sphere", 4, 5)]
        + [("clifford_torus", k, k) for k in DEGREES],
    )
    def test_normal(self, raised, surface, k, order):
        solution = SOLUTIONS[surface]

        def error(geo):
            nu = solution.fields(solution.closest_point(geo.points, 0.0), 0.0).nu
            return np.sqrt(np.einsum("ep,epa->", geo.dA, (geo.normal - nu) ** 2))

        measured = orders(raised, surface, k, error)
        np.testing.assert_allclose(measured, order, rtol=0, atol=0.2)


class TestPointwise:
    @pytest.fixture(params=DEGREES)
    def surface(self, make_rough, request):
        rough = make_rough(request.param)
        return rough, geometry(rough.mesh, rough.x)

    def test_normal_has_length_one(self, surface):
        _, geo = surface
        np.testing.assert_allclose(np.linalg.norm(geo.normal, axis=-1), 1.0, **ROUNDING)

    def test_normal_points_outward_on_the_torus(self, raised):
        mesh, x = raised("torus", 60, 2)
        geo = geometry(mesh, x)
        core = geo.points * [1, 1, 0] / np.hypot(*geo.points[..., :2].T).T[..., None]
        assert (np.einsum("epa,epa->ep", geo.normal, geo.points - core) > 0).all()

    def test_B_is_dual_to_J(self, surface):
        rough, geo = surface
        J = reference_gradient(rough.mesh, geo.element, rough.x)  # (E, Q, 2, 3), transposed
        product = np.einsum("epra,epas->eprs", J, geo.B)
        np.testing.assert_allclose(product, np.eye(2) + 0 * product, **ROUNDING)

    def test_B_is_tangential(self, surface):
        _, geo = surface
        normal_part = np.einsum("epa,epar->epr", geo.normal, geo.B)
        np.testing.assert_allclose(normal_part, 0.0, rtol=0, atol=1e-12)

    def test_area_element_is_root_of_gram_determinant(self, surface):
        rough, geo = surface
        J = reference_gradient(rough.mesh, geo.element, rough.x)
        gram = np.linalg.det(J @ np.swapaxes(J, -1, -2))
        expected = np.sqrt(gram) * geo.element.weights
        np.testing.assert_allclose(geo.dA, expected, rtol=1e-10, atol=0)  # cancellation in det

    def test_gradient_of_linear_function_is_its_tangential_part(self, surface):
        rough, geo = surface
        a = np.array([1.0, -2.0, 0.5])
        expected = a - np.einsum("epa,a->ep", geo.normal, a)[..., None] * geo.normal
        np.testing.assert_allclose(gradient(geo, rough.x @ a), expected, **ROUNDING)

    def test_gradient_has_gradients_of_components_as_columns(self, surface):
        rough, geo = surface
        whole = gradient(geo, rough.u)
        for c in range(4):
            np.testing.assert_allclose(whole[..., c], gradient(geo, rough.u[:, c]), **ROUNDING)

    def test_interpolation_of_nodes_is_position(self, surface):
        rough, geo = surface
        np.testing.assert_allclose(interpolate(geo, rough.x), geo.points, **ROUNDING)

    def test_scalars_and_columns_interpolate_alike(self, surface):
        rough, geo = surface
        whole = interpolate(geo, rough.u)
        for c in range(4):
            np.testing.assert_allclose(whole[..., c], interpolate(geo, rough.u[:, c]), **ROUNDING)


class TestInvariance:
    @each_degree
    def test_rotation_turns_normals_and_keeps_areas(self, make_rough, k):
        rough, R = make_rough(k), rotation()
        geo, turned = geometry(rough.mesh, rough.x), geometry(rough.mesh, rough.x @ R.T)
        np.testing.assert_allclose(turned.dA, geo.dA, rtol=1e-11, atol=0)
        np.testing.assert_allclose(turned.normal, geo.normal @ R.T, **ROUNDING)
        np.testing.assert_allclose(turned.B, R @ geo.B, rtol=0, atol=1e-11)

    @each_degree
    def test_enlarging_scales_areas_by_the_square(self, make_rough, k):
        rough = make_rough(k)
        geo, large = geometry(rough.mesh, rough.x), geometry(rough.mesh, 3.0 * rough.x)
        np.testing.assert_allclose(large.dA, 9.0 * geo.dA, rtol=1e-12, atol=0)

    @each_degree
    def test_renumbering_of_nodes_changes_nothing(self, make_rough, k):
        rough = make_rough(k)
        mesh, new = rough.mesh, np.random.default_rng(1).permutation(rough.mesh.node_count)
        renumbered = Mesh(k, new[mesh.cells[:, :3]], new[mesh.cells], mesh.node_count)
        x = np.empty_like(rough.x)
        x[new] = rough.x
        np.testing.assert_array_equal(geometry(renumbered, x).dA, geometry(mesh, rough.x).dA)

    @each_degree
    def test_turning_an_element_inside_out_flips_its_normal(self, make_rough, k):
        rough = make_rough(k)
        mirrored = geometry(rough.mesh, rough.x * [1, 1, -1])
        geo = geometry(rough.mesh, rough.x)
        np.testing.assert_allclose(mirrored.normal, -geo.normal * [1, 1, -1], **ROUNDING)


class TestDegenerate:
    @each_degree
    def test_collapsed_element_gives_non_finite_B(self, make_rough, k):
        rough = make_rough(k)
        x, collapsed = rough.x.copy(), rough.mesh.cells[5]
        x[collapsed] = 0.0  # exactly: at another point rounding would leave an area of 1e-33
        geo = geometry(rough.mesh, x)
        assert (geo.dA[5] == 0).all()
        assert not np.isfinite(geo.B[5]).any()

    @each_degree
    def test_collapsed_element_leaves_far_elements_alone(self, make_rough, k):
        rough = make_rough(k)
        x, collapsed = rough.x.copy(), rough.mesh.cells[5]
        x[collapsed] = 0.0
        far = ~np.isin(rough.mesh.cells, collapsed).any(axis=1)
        assert far.any()
        expected = geometry(rough.mesh, rough.x).B[far]
        np.testing.assert_array_equal(geometry(rough.mesh, x).B[far], expected)

    def test_bad_quadrature_degree_is_refused(self, make_rough):
        rough = make_rough(2)
        with pytest.raises(ValueError, match="quadrature_degree = 0"):
            geometry(rough.mesh, rough.x, 0)

    def test_geometry_is_frozen(self, make_rough):
        rough = make_rough(1)
        with pytest.raises(dataclasses.FrozenInstanceError):
            geometry(rough.mesh, rough.x).dA = 0.0
