"""Finite element functions of different, non-nested meshes of one Gamma(0), compared.

A node carries its label p on Gamma(0), and all discretisations move labels by the same normal
velocity: u_h(p, t) are functions on Gamma(0).  The label p is seen on the discrete initial surface
Gamma_h(0) along the normal of Gamma(0), X(xi) = p + s nu(p), which is the lift of the paper (section
3.5) read backwards.  Errors against the finest level are norms of nodal differences there.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from harness.errors import error_quadrature, norms_by_variable, squared_norms, weighted_metric
from solver.geometry import geometry, interpolate, reference_gradient
from solver.mesh import Integers, Mesh
from solver.reference_element import Array, tabulate

NEIGHBOURS = (12, 60)  # cells that are tried for a point, by distance; more if none of 12 holds it
TOLERANCE = 1e-6  # a point may lie off its cell by this much, in barycentric coordinates
ROUNDING = 1e-12  # so little off: on an edge, no better cell is looked for
NEWTON_STEPS = 12
CONVERGED = 1e-9  # last step of Newton; the next, of its square, is below rounding
BOX = (-0.5, 1.5)  # iterates stay here: far from the triangle P_4 is no surface


@dataclass(frozen=True)
class Location:
    """Where points of Gamma(0) lie on a mesh: ``cell`` (M,), ``reference`` coordinates (M, 2)."""

    cell: Integers
    reference: Array


def least_barycentric(reference: Array) -> Array:
    """min(1 - r - s, r, s) of reference points (..., 2), not negative in the triangle, (...)."""
    return np.minimum(1.0 - reference.sum(axis=-1), reference.min(axis=-1))


def locate(coarse: Mesh, p_coarse: Array, p: Array, nu: Array) -> Location:
    """The points of the surface with nodes p_coarse on the lines p + s nu.

    Parameters
    ----------
    coarse, p_coarse : a mesh and its nodes (N, 3) on Gamma(0).
    p, nu : (M, 3) points of Gamma(0) and its unit normals there, to the side of the elements'
        orientation.

    Raises
    ------
    ValueError
        If a line meets no nearby cell: off all by more than 1e-6 in barycentric coordinates.
    """
    centroid, _ = _evaluate(coarse, p_coarse, np.arange(len(coarse.cells)), np.array([1, 1]) / 3)
    tree = cKDTree(centroid)
    T = _tangents(nu)
    cell, reference = np.zeros(len(p), dtype=np.int64), np.zeros((len(p), 2))
    least = np.full(len(p), -np.inf)
    for neighbours in NEIGHBOURS:
        missing = np.flatnonzero(least < -TOLERANCE)
        _, near = tree.query(p[missing], k=min(neighbours, len(centroid)))
        candidates, guess = _flat_guess(coarse, p_coarse, p[missing], T[missing], near)
        for rank in range(near.shape[1]):
            rows = np.flatnonzero(least[missing] < -ROUNDING)
            i, tried = missing[rows], candidates[rows, rank]
            found = _newton(coarse, p_coarse, p[i], T[i], tried, guess[rows, rank])
            held = least_barycentric(found)
            better = held > least[i]
            i = i[better]
            cell[i], reference[i], least[i] = tried[better], found[better], held[better]
    if len(p) and not least.min() >= -TOLERANCE:
        i = int(least.argmin())
        raise ValueError(
            f"p[{i}] = {p[i]}: on no cell of the coarse mesh, least barycentric coordinate "
            f"{least[i]:.2g} must be at least {-TOLERANCE:g}"
        )
    return Location(cell, reference)


def transferred(location: Location, coarse: Mesh, u: Array) -> Array:
    """Nodal u (N, C) of the coarse mesh at the located points, (M, C)."""
    return _evaluate(coarse, u, location.cell, location.reference)[0]


def difference_norms(fine: Mesh, x_fine: Array, e: Array) -> tuple[Array, Array]:
    """The norms L2 and H1, (C,) each, of nodal e (M, C) on the surface with nodes x_fine (M, 3)."""
    l2, seminorm = _squared_norms(fine, x_fine, e)
    return np.sqrt(l2), np.sqrt(l2 + seminorm)


def against_finest(
    location: Location, coarse: Mesh, u: Array, fine: Mesh, u_fine: Array
) -> dict[str, tuple[float, float]]:
    """The norms (L2, H1) on Gamma_fine(t) of u - u_fine for each of `harness.errors.VARIABLES`.

    Parameters
    ----------
    location : of the initial nodes of the fine mesh on the coarse one.
    coarse, u : a mesh and its `harness.errors.unknowns` (N, 14) at time t.
    fine, u_fine : those of the finest level (M, 14), at the same time.
    """
    e = transferred(location, coarse, u) - u_fine
    return norms_by_variable(*_squared_norms(fine, u_fine[:, :3], e))


def _squared_norms(fine: Mesh, x_fine: Array, e: Array) -> tuple[Array, Array]:
    """`squared_norms` of nodal e (M, C), by the quadrature of the errors."""
    geo = geometry(fine, x_fine, error_quadrature(fine.degree))
    de = reference_gradient(fine, geo.element, e)
    return squared_norms(geo, weighted_metric(geo), interpolate(geo, e), de)


def _evaluate(mesh: Mesh, u: Array, cell: Integers, reference: Array) -> tuple[Array, Array]:
    """Values (P, C) and derivatives d_r u_c (P, 2, C) of nodal u, one point (P, 2) a cell (P,)."""
    phi, dphi = tabulate(mesh.degree, np.atleast_2d(reference))
    u_local = u[mesh.cells[cell]]
    return np.squeeze(phi[:, None, :] @ u_local, axis=1), dphi @ u_local


def _tangents(nu: Array) -> Array:
    """T (M, 2, 3), orthonormal and normal to nu, T0 x T1 = nu."""
    axis = np.eye(3)[np.abs(nu).argmin(axis=1)]
    T0 = np.cross(axis, nu)
    T0 /= np.linalg.norm(T0, axis=1, keepdims=True)
    return np.stack([T0, np.cross(nu, T0)], axis=1)


def _solve(A: Array, b: Array) -> tuple[Array, Array]:
    """y with sum_r y_r A_ra = b_a, and det A: (..., 2, 2), (..., 2) -> (..., 2), (...)."""

    def cross(a: Array, b: Array) -> Array:
        return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]

    det = cross(A[..., 0, :], A[..., 1, :])
    y = np.stack([cross(b, A[..., 1, :]), cross(A[..., 0, :], b)], axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return y / det[..., None], det


def _flat_guess(
    coarse: Mesh, x: Array, p: Array, T: Array, near: Integers
) -> tuple[Integers, Array]:
    """Cells near (M, K) and reference coordinates (M, K, 2) on their flat triangles, likeliest first.

    A triangle seen from behind comes last.
    """
    corners = x[coarse.triangles[near]]
    origin = corners[..., 0, :]
    sides = np.einsum("mkrb,mab->mkra", corners[..., 1:, :] - origin[..., None, :], T)
    xi, det = _solve(sides, np.einsum("mab,mkb->mka", T, p[:, None] - origin))
    likely = np.where(det > 0, least_barycentric(xi), -np.inf)
    order = np.argsort(-likely, axis=1, kind="stable")
    xi = np.take_along_axis(xi, order[..., None], axis=1)
    return np.take_along_axis(near, order, axis=1), xi


def _newton(coarse: Mesh, x: Array, p: Array, T: Array, cell: Integers, xi: Array) -> Array:
    """xi (P, 2) with T (X(xi) - p) = 0 on one cell (P,) a point; NaN where there is none.

    There is none, too, where the surface is met from behind, or farther away than the cell is wide:
    a normal of a closed surface meets it again.
    """
    corners = x[coarse.triangles[cell]]
    width = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    found, xi = np.full(xi.shape, np.nan), np.clip(xi, *BOX)
    open_ = np.arange(len(p))
    for _ in range(NEWTON_STEPS):
        X, dX = _evaluate(coarse, x, cell[open_], xi[open_])
        off = X - p[open_]
        step, det = _solve(
            np.einsum("pra,pba->prb", dX, T[open_]), np.einsum("pba,pa->pb", T[open_], off)
        )
        done = np.abs(step).max(axis=1) < CONVERGED
        met = done & (det > 0) & (np.linalg.norm(off, axis=1) < width[open_])
        found[open_[met]] = xi[open_[met]] - step[met]
        xi[open_] = np.clip(xi[open_] - step, *BOX)
        open_ = open_[~done]
    return found
