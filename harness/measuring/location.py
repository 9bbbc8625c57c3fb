"""Where labels p of Gamma(0) lie on the curved elements of a mesh of it.

On the discrete initial surface the label p is the point X(xi) = p + s nu(p): the lift of the paper
(section 3.5) read backwards.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from esfem.solver.mesh import Integers, Mesh
from esfem.solver.reference_element import Array, tabulate

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
    phi, _ = tabulate(coarse.degree, np.full((1, 2), 1 / 3))
    tree = cKDTree(phi[0] @ p_coarse[coarse.cells])
    T = tangents(nu)
    cell, reference = np.zeros(len(p), dtype=np.int64), np.zeros((len(p), 2))
    least = np.full(len(p), -np.inf)
    for neighbours in NEIGHBOURS:
        i = np.flatnonzero(least < -TOLERANCE)
        near = np.asarray(tree.query(p[i], k=min(neighbours, tree.n))[1])
        cell[i], reference[i], least[i] = _best(coarse, p_coarse, p[i], T[i], near)
    if len(p) and least.min() < -TOLERANCE:
        worst = int(least.argmin())
        raise ValueError(
            f"p[{worst}] = {p[worst]}: on no cell of the coarse mesh, least barycentric coordinate "
            f"{least[worst]:.2g} must be at least {-TOLERANCE:g}"
        )
    return Location(cell, reference)


def evaluate(mesh: Mesh, u: Array, cell: Integers, reference: Array) -> tuple[Array, Array]:
    """Values (P, C) and derivatives d_r u_c (P, 2, C) of nodal u at one point a cell (P,)."""
    phi, dphi = tabulate(mesh.degree, reference)
    value, du = np.zeros(()), np.zeros(())
    for i, node in enumerate(mesh.cells[cell].T):  # all u[cells] at once would be n times as large
        u_i = u[node]
        value = value + phi[:, i, None] * u_i
        du = du + dphi[:, :, i, None] * u_i[:, None]
    return value, du


def tangents(nu: Array) -> Array:
    """T (M, 2, 3), orthonormal and normal to nu, T0 x T1 = nu."""
    axis = np.eye(3)[np.abs(nu).argmin(axis=1)]
    T0 = np.cross(axis, nu)
    T0 /= np.linalg.norm(T0, axis=1, keepdims=True)
    return np.stack([T0, np.cross(nu, T0)], axis=1)


def solve(A: Array, b: Array) -> tuple[Array, Array]:
    """y with sum_r y_r A_ra = b_a, and det A: (..., 2, 2), (..., 2) -> (..., 2), (...)."""

    def cross(a: Array, b: Array) -> Array:
        return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]

    det = cross(A[..., 0, :], A[..., 1, :])
    y = np.stack([cross(b, A[..., 1, :]), cross(A[..., 0, :], b)], axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return y / det[..., None], det


def _best(
    coarse: Mesh, x: Array, p: Array, T: Array, near: Integers
) -> tuple[Integers, Array, Array]:
    """Of the cells near (M, K) the one that holds p best: cell, reference, least barycentric.

    Cells are tried until one holds the point; -inf if none is met.
    """
    candidates, guess = _flat_guess(coarse, x, p, T, near)
    cell, reference = np.zeros(len(p), dtype=np.int64), np.zeros((len(p), 2))
    least = np.full(len(p), -np.inf)
    for tried, start in zip(candidates.T, np.swapaxes(guess, 0, 1), strict=True):
        i = np.flatnonzero(least < -ROUNDING)
        found = _newton(coarse, x, p[i], T[i], tried[i], start[i])
        held = least_barycentric(found)
        better = held > least[i]  # False for NaN
        i = i[better]
        cell[i], reference[i], least[i] = tried[i], found[better], held[better]
    return cell, reference, least


def _flat_guess(
    coarse: Mesh, x: Array, p: Array, T: Array, near: Integers
) -> tuple[Integers, Array]:
    """Cells near (M, K) and coordinates (M, K, 2) on their flat triangles, likeliest first.

    A triangle seen from behind comes last.
    """
    corners = x[coarse.triangles[near]]
    origin = corners[..., 0, :]
    sides = np.einsum("mkrb,mab->mkra", corners[..., 1:, :] - origin[..., None, :], T)
    xi, det = solve(sides, np.einsum("mab,mkb->mka", T, p[:, None] - origin))
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
        X, dX = evaluate(coarse, x, cell[open_], xi[open_])
        off = X - p[open_]
        step, det = solve(
            np.einsum("pra,pba->prb", dX, T[open_]), np.einsum("pba,pa->pb", T[open_], off)
        )
        done = np.abs(step).max(axis=1) < CONVERGED
        met = done & (det > 0) & (np.linalg.norm(off, axis=1) < width[open_])
        found[open_[met]] = xi[open_[met]] - step[met]
        xi[open_] = np.clip(xi[open_] - step, *BOX)
        open_ = open_[~done]
    return found
