"""Finite element functions of different, non-nested meshes of one Gamma(0), compared.

A node carries its label p on Gamma(0), and all discretisations move labels by the same normal
velocity: u_h(p, t) are functions on Gamma(0).

Errors against the finest level are norms over its surface of u(xi(eta)) - u_fine(eta), eta its
quadrature points.  Nodal differences would not do: interpolation on the fine mesh takes away the
part of the error that oscillates as fast, and orders come out too high (k = 2, V = 960 to 1920
against 3840: by 0.25 in H1; k = 1: by 1).

Errors against the interpolation take away just that part, of the coarse mesh. I_h u_fine has the
values of u_fine where the labels of the coarse nodes lie on the fine mesh; u - I_h u_fine is
measured on the coarse surface whose nodes are I_h x_fine, as u - I_h u is of an exact solution.

Both are norms in L^2 and seminorms, as in `measuring.lift`.
"""

from dataclasses import dataclass

import numpy as np

from esfem.measuring.lift import (
    ByVariable,
    error_quadrature,
    nodal_norms,
    norms_by_variable,
    squared_norms,
    weighted_metric,
)
from esfem.measuring.location import Location, evaluate, locate, solve, tangents
from esfem.solver.assembly import mass_matrix, stiffness_matrix
from esfem.solver.geometry import geometry, interpolate, reference_gradient, values
from esfem.solver.mesh import Mesh
from esfem.solver.reference_element import Array, reference_element


@dataclass(frozen=True)
class Overlay:
    """The quadrature points of a fine mesh on a coarse one.

    Attributes
    ----------
    location : of the P = E Q points, reference coordinates xi.
    derivative : (P, 2, 2), d xi_s / d eta_r by the reference coordinates eta of the fine mesh.
    """

    location: Location
    derivative: Array


def overlay(coarse: Mesh, p_coarse: Array, fine: Mesh, p_fine: Array, nu_fine: Array) -> Overlay:
    """The fine quadrature points on the coarse mesh, along the interpolated normals.

    X(xi) - p = s nu is tangentially zero, so T dX dxi = T (dp + s dnu) with T nu = 0.  Between
    nodes p and nu are those of the fine P_k surface, which moves labels by O(h^{2k+2}) only.

    Parameters
    ----------
    coarse, p_coarse : a mesh and its nodes (N, 3) on Gamma(0).
    fine, p_fine, nu_fine : another, its nodes (M, 3) on Gamma(0) and the unit normals there.

    Raises
    ------
    ValueError
        As `locate`.
    """
    element = reference_element(fine.degree, error_quadrature(fine.degree))
    frame = np.hstack([p_fine, nu_fine])
    p, nu = np.split(values(fine, element, frame).reshape(-1, 6), 2, axis=-1)
    dp, dnu = np.split(reference_gradient(fine, element, frame).reshape(-1, 2, 6), 2, axis=-1)
    location, T = locate(coarse, p_coarse, p, nu), tangents(nu)
    X, dX = evaluate(coarse, p_coarse, location.cell, location.reference)
    s = np.einsum("pa,pa->p", X - p, nu) / np.einsum("pa,pa->p", nu, nu)
    rhs = np.einsum("pra,pba->prb", dp + s[:, None, None] * dnu, T)
    derivative, _ = solve(np.einsum("pra,pba->prb", dX, T)[:, None], rhs)
    return Overlay(location, derivative)


def against_finest(over: Overlay, coarse: Mesh, u: Array, fine: Mesh, u_fine: Array) -> ByVariable:
    """The norms on Gamma_fine(t) of u - u_fine for each of `measuring.lift.VARIABLES`.

    Parameters
    ----------
    over : of the two meshes, from their nodes on Gamma(0).
    coarse, u : a mesh and its `esfem.measuring.lift.unknowns` (N, 14) at time t.
    fine, u_fine : those of the finest level (M, 14), at the same time.
    """
    return norms_by_variable(*squared_differences(over, coarse, u, fine, u_fine[:, :3], u_fine))


def squared_differences(
    over: Overlay, coarse: Mesh, u: Array, fine: Mesh, x_fine: Array, u_fine: Array
) -> tuple[Array, Array]:
    """`squared_norms` of e = u(xi(eta)) - u_fine(eta), de = dxi du - du_fine, (C,) each.

    The columns u (N, C) and u_fine (M, C) are nodal values on the coarse and the fine mesh, the
    norms those of the surface with nodes x_fine (M, 3).
    """
    geo = geometry(fine, x_fine, error_quadrature(fine.degree))
    shape = *geo.dA.shape, -1
    value, du = evaluate(coarse, u, over.location.cell, over.location.reference)
    e = value.reshape(shape) - interpolate(geo, u_fine)
    d_fine = reference_gradient(fine, geo.element, u_fine)
    de = (over.derivative @ du).reshape(d_fine.shape) - d_fine
    return squared_norms(geo, weighted_metric(geo), e, de)


def against_interpolation(
    at: Location, coarse: Mesh, u: Array, fine: Mesh, u_fine: Array
) -> ByVariable:
    """The norms of u - I_h u_fine on the surface with nodes I_h x_fine.

    Parameters
    ----------
    at : of the labels of the coarse nodes on the fine mesh.
    coarse, u, fine, u_fine : as in `against_finest`.
    """
    u_star, _ = evaluate(fine, u_fine, at.cell, at.reference)
    geo = geometry(coarse, u_star[:, :3], error_quadrature(coarse.degree))
    return nodal_norms(mass_matrix(geo), stiffness_matrix(geo), u - u_star)
