"""Matrices and load vectors on Gamma_h, without a word about any equation.

Local matrices of all elements are one matrix product with reference tables; one fixed CSR pattern a
mesh.
"""

import numpy as np
import scipy.sparse as sp

from solver.geometry import Geometry, inverse_metric
from solver.reference_element import Array


def mass_matrix(geo: Geometry, weight: Array | None = None) -> sp.csr_array:
    """int weight phi_i phi_j, (N, N); ``weight`` (E, Q), 1 by default.  Paper: M(x)."""
    dA = geo.dA if weight is None else geo.dA * weight
    return _matrix(geo, dA @ geo.element.mass_table)


def stiffness_matrix(geo: Geometry) -> sp.csr_array:
    """int grad phi_i . grad phi_j, (N, N).  Paper: A(x)."""
    metric = np.stack(inverse_metric(geo), axis=-1)
    weights = (geo.dA[..., None] * metric).reshape(len(geo.dA), -1)
    return _matrix(geo, weights @ geo.element.stiffness_table)


def load(geo: Geometry, g: Array) -> Array:
    """int g phi_j, dual, from g at the quadrature points: (E, Q) -> (N,), (E, Q, C) -> (N, C)."""
    weighted = geo.dA.reshape(*geo.dA.shape, *(1,) * (g.ndim - 2)) * g
    columns = weighted.reshape(*geo.dA.shape, -1)
    return _scatter(geo, geo.element.phi.T @ columns).reshape(-1, *g.shape[2:])


def gradient_load(geo: Geometry, G: Array) -> Array:
    """int G_ac d_a phi_j, dual, from G at the quadrature points: (E, Q, 3, C) -> (N, C)."""
    flux = np.einsum("ep,epar,epac->eprc", geo.dA, geo.B, G, optimize=True)
    dphi = geo.element.dphi.reshape(-1, geo.element.dphi.shape[-1])
    return _scatter(geo, dphi.T @ flux.reshape(len(flux), len(dphi), -1))


def _matrix(geo: Geometry, local: Array) -> sp.csr_array:
    """Sum local matrices (E, n n) into the pattern of the mesh."""
    pattern, N = geo.mesh.pattern, geo.mesh.node_count
    data = np.bincount(pattern.scatter, weights=local.ravel(), minlength=len(pattern.indices))
    return sp.csr_array((data, pattern.indices, pattern.indptr), shape=(N, N))


def _scatter(geo: Geometry, local: Array) -> Array:
    """Sum local loads (E, n, C) into (N, C)."""
    nodes, N = geo.mesh.cells.ravel(), geo.mesh.node_count
    columns = local.reshape(len(nodes), -1)
    return np.stack(
        [np.bincount(nodes, weights=column, minlength=N) for column in columns.T], axis=1
    )
