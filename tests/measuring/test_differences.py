"""How far two States lie apart: a norm of their difference, with closed forms and by matrices."""

from dataclasses import replace

import numpy as np
import pytest

from esfem.measuring.differences import differences, flow_map_difference
from esfem.measuring.lift import VARIABLES, error_quadrature, exact_state
from esfem.reference_solutions import StationarySphere
from esfem.solver import State
from esfem.solver.assembly import mass_matrix, stiffness_matrix
from esfem.solver.functionals import area
from esfem.solver.geometry import geometry

DEGREE = 2
LENGTH = 0.7


@pytest.fixture
def sphere(raised):
    mesh, p = raised("sphere", 60, DEGREE)
    return mesh, exact_state(StationarySphere(), p, 0.0)


def disturbed(state: State, size: float = 1e-3) -> State:
    rng = np.random.default_rng(0)
    arrays = {name: getattr(state, name) for name in ("x", "nu", "H", "V", "z")}
    return replace(state, **{n: a + size * rng.standard_normal(a.shape) for n, a in arrays.items()})


def longhand(mesh, state, other, length) -> dict[str, float]:
    """By M and A: sqrt(d.M d / L^2 + d.A d), component by component."""
    geo = geometry(mesh, state.x, error_quadrature(DEGREE))
    M, A = mass_matrix(geo), stiffness_matrix(geo)
    found = {}
    for name in VARIABLES:
        d = getattr(other, name) - getattr(state, name)
        components = d.T if d.ndim == 2 else [d]
        found[name] = np.sqrt(sum(c @ (M @ c) / length**2 + c @ (A @ c) for c in components))
    return found


def test_they_are_the_norms_by_mass_and_stiffness_matrix(sphere):
    mesh, state = sphere
    other = disturbed(state)
    found, expected = differences(mesh, state, other, LENGTH), longhand(mesh, state, other, LENGTH)
    for name in VARIABLES:
        assert found[name] == pytest.approx(expected[name], rel=1e-10), name


def test_a_constant_difference_has_no_gradient(sphere):
    mesh, state = sphere
    found = differences(mesh, state, replace(state, H=state.H + 3.0), LENGTH)
    size = 3.0 * np.sqrt(area(geometry(mesh, state.x, error_quadrature(DEGREE)))) / LENGTH
    assert found["H"] == pytest.approx(size, rel=1e-12)
    assert all(found[name] == 0.0 for name in ("x", "nu", "z", "distance"))


def test_a_state_does_not_lie_apart_from_itself(sphere):
    assert set(differences(*sphere, sphere[1], LENGTH).values()) == {0.0}


def test_distance_does_not_see_nodes_that_slide(sphere):
    """Turned by a, nodes move by 2 a, and the surface by O(h^k a + a^2)."""
    mesh, state = sphere
    a = 1e-3
    turn = np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]])
    found = differences(mesh, state, replace(state, x=state.x @ turn.T), 1.0)
    assert found["distance"] < 0.05 * a < found["x"]
    outwards = differences(mesh, state, replace(state, x=(1.0 + a) * state.x), 1.0)
    assert outwards["distance"] == pytest.approx(a, rel=0.01)


@pytest.mark.parametrize("factor", [2.0**-10, 2.0**10])
def test_another_unit_of_length_is_a_factor_to_the_last_bit(sphere, factor):
    """x is a length, nu a number, H one over a length; integrals bring another length."""
    mesh, state = sphere
    other = disturbed(state)

    def scaled(s: State) -> State:
        return replace(s, x=factor * s.x, H=s.H / factor)

    found = differences(mesh, scaled(state), scaled(other), factor)
    unit = differences(mesh, state, other, 1.0)
    assert found["x"] == factor * unit["x"]
    assert found["nu"] == unit["nu"]
    assert found["H"] == unit["H"] / factor


def test_flow_maps_are_compared_on_the_surface_of_the_start(sphere):
    """A sphere of radius 3 and one of 3.1: 0.1 times the identity of the unit sphere."""
    mesh, state = sphere
    start = geometry(mesh, state.x, error_quadrature(DEGREE))
    one, other = (replace(state, x=r * state.x) for r in (3.0, 3.1))
    found = flow_map_difference(start, one, other, LENGTH)
    exact = 0.1 * np.sqrt(4.0 * np.pi * (1.0 / LENGTH**2 + 2.0))
    assert found == pytest.approx(exact, rel=1e-2)
    assert differences(mesh, one, other, LENGTH)["x"] > 1.2 * found
