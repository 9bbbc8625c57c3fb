"""The consistency ladder: exact geometry put into the semi-discrete equations leaves O(h^k).

With nodal interpolations of exact x, u = (H; nu), w = (V; z) and exact material derivatives
mat H = -Lap V - |S|^2 V and mat nu = -grad V (the first from `profiles`), the defects

    d_u = M u' - A w - F w - f,    d_w = M w + A u - g

are measured in the norm of H^-1_h, sqrt(r^T (M + A)^-1 r).  Their order is k (paper, section 6).
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from profiles import laplace_V
from scipy.sparse.linalg import splu

from esfem.reference_solutions import CliffordTorus, StationarySphere
from esfem.solver import Mesh, forms
from esfem.solver.assembly import gradient_load, load, mass_matrix, stiffness_matrix
from esfem.solver.functionals import mesh_width
from esfem.solver.geometry import Geometry, geometry
from esfem.solver.laws import willmore

EQUATIONS = {"H": slice(0, 1), "nu": slice(1, 4), "V": slice(4, 5), "z": slice(5, 8)}
BAND = {2: (2.0, 2.6), 3: (2.9, 3.3), 4: (3.9, 4.4)}  # of the measured orders
LEVELS = {2: (480, 960, 1920, 3840), 3: (240, 480, 960, 1920), 4: (120, 240, 480, 960)}

each_degree = pytest.mark.parametrize("k", LEVELS)


@dataclass(frozen=True)
class Exact:
    """Nodal u, its material derivative and w, (N, 4) each."""

    u: np.ndarray
    u_dot: np.ndarray
    w: np.ndarray


@dataclass(frozen=True)
class Defect:
    """The defects (N, 8), stacked as in `EQUATIONS`, with what they were made from."""

    geo: Geometry
    curvature: forms.Curvature
    exact: Exact
    vectors: np.ndarray


def exact_on_torus(torus, x: np.ndarray) -> Exact:
    f = torus.fields(x)
    S2 = np.einsum("jab,jab->j", f.S, f.S)
    H_dot = -laplace_V(torus, x) - S2 * f.V
    return Exact(
        u=np.column_stack([f.H, f.nu]),
        u_dot=np.column_stack([H_dot, -f.grad_V]),
        w=np.column_stack([f.V, f.z]),
    )


def exact_on_sphere(x: np.ndarray) -> Exact:
    f = StationarySphere().fields(x, 0.0)
    u, w = np.column_stack([f.H, f.nu]), np.column_stack([f.V, f.z])
    return Exact(u, np.zeros_like(u), w)


def defect(mesh: Mesh, x: np.ndarray, exact: Exact) -> Defect:
    geo = geometry(mesh, x)
    M, A = mass_matrix(geo), stiffness_matrix(geo)
    c = forms.curvature(geo, exact.u, willmore, 0.0)
    f, g = forms.loads(geo, c)
    d_u = M @ exact.u_dot - A @ exact.w - forms.F(geo, c, exact.w) - f
    d_w = M @ exact.w + A @ exact.u - g
    return Defect(geo, c, exact, np.hstack([d_u, d_w]))


def dual_norms(geo: Geometry, r: np.ndarray) -> np.ndarray:
    """sqrt(r^T (M + A)^-1 r) of each column."""
    factors = splu((mass_matrix(geo) + stiffness_matrix(geo)).tocsc())
    return np.sqrt(np.einsum("jc,jc->c", r, factors.solve(r)))


def norms(d: Defect) -> dict[str, float]:
    columns = dual_norms(d.geo, d.vectors)
    return {name: float(np.linalg.norm(columns[part])) for name, part in EQUATIONS.items()}


@pytest.fixture(scope="module")
def defect_on(raised, torus):
    """The defect on the named surface with V vertices and degree k."""

    @cache
    def make(surface: str, V: int, k: int) -> Defect:
        mesh, x = raised(surface, V, k)
        if surface == "sphere":
            return defect(mesh, x, exact_on_sphere(x))
        return defect(
            mesh, x, exact_on_torus(torus if surface == "torus" else CliffordTorus().torus, x)
        )

    return make


@pytest.fixture(scope="module")
def ladder(defect_on):
    """Widths and norms of the defects over the finest levels."""

    @cache
    def make(surface: str, k: int) -> tuple[list[float], list[dict[str, float]]]:
        defects = [defect_on(surface, V, k) for V in LEVELS[k]]
        return [mesh_width(d.geo) for d in defects], [norms(d) for d in defects]

    return make


def slope(h: list[float], e: list[float]) -> float:
    return float(np.polyfit(np.log(h), np.log(e), 1)[0])


class TestOrder:
    """Signed least-squares slopes over four levels; the least defect is 1e-7, far above rounding.

    Degree 2 comes down from above (2.7 on coarse levels, 2.2 at V = 3840), so its band is wider.
    """

    @each_degree
    @pytest.mark.parametrize("equation", EQUATIONS)
    def test_is_k_on_a_moving_torus(self, ladder, equation, k):
        h, e = ladder("torus", k)
        least, most = BAND[k]
        assert least < slope(h, [level[equation] for level in e]) < most

    @each_degree
    @pytest.mark.parametrize("equation", ["nu", "V", "z"])
    def test_is_k_on_the_clifford_torus(self, ladder, equation, k):
        h, e = ladder("clifford_torus", k)
        least, most = BAND[k]
        assert least < slope(h, [level[equation] for level in e]) < most

    @pytest.mark.parametrize(("k", "order"), [(2, 3), (3, 3), (4, 5)])
    def test_of_z_on_the_sphere_is_that_of_its_normal(self, ladder, k, order):
        """P_2 and P_4 normals of an umbilic surface do one better, see test_geometry."""
        h, e = ladder("sphere", k)
        measured = slope(h, [level["z"] for level in e])
        np.testing.assert_allclose(measured, order, rtol=0, atol=0.15)


class TestExact:
    @each_degree
    def test_H_equation_holds_where_V_vanishes(self, defect_on, k):
        assert norms(defect_on("clifford_torus", 120, k))["H"] < 1e-15  # V itself is a rounding

    @each_degree
    @pytest.mark.parametrize("equation", ["H", "nu", "V"])
    def test_all_but_the_z_equation_hold_on_the_sphere(self, defect_on, equation, k):
        """nu_h = x_h, so S_h is the tangential projection of Gamma_h, |S_h|^2 = 2 and Q_h = 0."""
        d = defect_on("sphere", 240, k)
        assert norms(d)[equation] < 1e-10


def terms(d: Defect) -> dict[str, tuple[str, np.ndarray]]:
    """Every integral of F w, f and g, with its equation and the paper's sign; all on the right."""
    geo, c, V, z = d.geo, d.curvature, d.exact.w[:, 0], d.exact.w[:, 1:]
    S_grad_H = np.einsum("epab,epb->epa", c.S, c.grad_H)
    S2_grad_H = np.einsum("epab,epb->epa", c.S, S_grad_H)
    z_at = np.einsum("pi,eia->epa", geo.element.phi, z[geo.mesh.cells])
    V_at = np.einsum("pi,ei->ep", geo.element.phi, V[geo.mesh.cells])
    Sz = np.einsum("epab,epb->epa", c.S, z_at)
    H_cubed, S2_H = -0.5 * c.H**3, c.S2 * c.H

    def times(a, b):
        return a[..., None] * b

    return {
        "F1: |S|^2 V": ("H", load(geo, -c.S2 * V_at)),
        "F2: H S z": ("nu", load(geo, times(c.H, Sz))),
        "F2: S^2 z": ("nu", load(geo, -np.einsum("epab,epb->epa", c.S, Sz))),
        "f2: |grad H|^2 nu": ("nu", load(geo, times(np.sum(c.grad_H**2, axis=-1), c.nu))),
        "f2: S^2 grad H": ("nu", load(geo, S2_grad_H)),
        "f2: S grad H . grad phi nu": (
            "nu",
            gradient_load(geo, 2 * S_grad_H[..., :, None] * c.nu[..., None, :]),
        ),
        "f2: Q grad phi": ("nu", gradient_load(geo, c.Q[..., None, None] * np.eye(3))),
        "f2: Q H nu": ("nu", load(geo, times(-c.Q * c.H, c.nu))),
        "g1: -H^3/2": ("V", load(geo, H_cubed)),
        "g1: |S|^2 H": ("V", load(geo, S2_H)),
        "g2: |S|^2 nu": ("z", load(geo, times(c.S2, c.nu))),
    }


NAMES = (
    "F1: |S|^2 V",
    "F2: H S z",
    "F2: S^2 z",
    "f2: |grad H|^2 nu",
    "f2: S^2 grad H",
    "f2: S grad H . grad phi nu",
    "f2: Q grad phi",
    "f2: Q H nu",
    "g1: -H^3/2",
    "g1: |S|^2 H",
    "g2: |S|^2 nu",
)


class TestEveryTermMatters:
    """Without one integral, or with its sign turned, the defect stays where it is."""

    def test_the_terms_are_all_there_are(self, defect_on):
        d = defect_on("torus", 120, 2)
        parts = terms(d)
        assert tuple(parts) == NAMES
        geo, c = d.geo, d.curvature
        f, g = forms.loads(geo, c)
        right = np.hstack([forms.F(geo, c, d.exact.w) + f, g])
        for equation, part in EQUATIONS.items():
            total = sum(r.reshape(len(r), -1) for name, r in parts.values() if name == equation)
            # Rounding, against entries of size 1e-2.
            np.testing.assert_allclose(total, right[:, part], rtol=0, atol=1e-14)

    @pytest.mark.parametrize("factor", [1, 2], ids=["dropped", "turned"])
    @pytest.mark.parametrize("name", NAMES)
    def test_without_it_the_defect_does_not_converge(self, defect_on, name, factor):
        right, wrong = [], []
        for V in (240, 960):  # the width is halved: order 2 is a factor 4
            d = defect_on("torus", V, 2)
            equation, term = terms(d)[name]
            good = d.vectors[:, EQUATIONS[equation]]
            bad = good + factor * term.reshape(len(term), -1)
            right.append(np.linalg.norm(dual_norms(d.geo, good)))
            wrong.append(np.linalg.norm(dual_norms(d.geo, bad)))
        assert right[0] / right[1] > 3.5
        assert 0.95 < wrong[0] / wrong[1] < 1.05
        assert wrong[1] > 10 * right[1]
