"""Matrices and load vectors on Gamma_h, without a word about any equation.

Local matrices of all elements are one matrix product with reference tables; one fixed CSR pattern a
mesh.
"""

import numpy as np
import scipy.sparse as sp

from esfem.solver.geometry import Geometry, inverse_metric
from esfem.solver.mesh import Mesh
from esfem.solver.reference_element import Array


def mass_matrix(geo: Geometry, weight: Array | None = None) -> sp.csr_array:
    """int weight phi_i phi_j, (N, N); ``weight`` (E, Q), 1 by default.  Paper: M(x)."""
    return matrix(geo.mesh, local_mass(geo, weight))


def stiffness_matrix(geo: Geometry) -> sp.csr_array:
    """int grad phi_i . grad phi_j, (N, N).  Paper: A(x)."""
    return matrix(geo.mesh, local_stiffness(geo))


def local_mass(geo: Geometry, weight: Array | None = None) -> Array:
    """The entries of `mass_matrix` by element, (n n, E)."""
    dA = geo.dA if weight is None else geo.dA * weight
    return geo.element.mass_table @ dA.T


def local_stiffness(geo: Geometry) -> Array:
    """The entries of `stiffness_matrix` by element, (n n, E)."""
    weights = np.concatenate([(geo.dA * entry).T for entry in inverse_metric(geo)])
    return geo.element.stiffness_table @ weights


def load(geo: Geometry, g: Array) -> Array:
    """int g phi_j, dual, from g at the quadrature points: (E, Q) -> (N,), (E, Q, C) -> (N, C)."""
    weighted = geo.dA.T * g.T
    return scatter(geo.mesh, geo.element.phi.T @ weighted)


def gradient_load(geo: Geometry, G: Array) -> Array:
    """int G_ac d_a phi_j, dual, from G at the quadrature points: (E, Q, 3, C) -> (N, C)."""
    flux = np.einsum("ep,epar,epac->eprc", geo.dA, geo.B, G, optimize=True)
    columns = flux.T.reshape(G.shape[-1], -1, len(flux))
    return scatter(geo.mesh, geo.element.dphi_table.T @ columns)


def matrix(mesh: Mesh, local: Array) -> sp.csr_array:
    """Sum local matrices (n n, E) into the pattern of the mesh."""
    pattern, N = mesh.pattern, mesh.node_count
    data = np.bincount(pattern.scatter, weights=local.ravel(), minlength=len(pattern.indices))
    return sp.csr_array((data, pattern.indices, pattern.indptr), shape=(N, N))


def scatter(mesh: Mesh, local: Array) -> Array:
    """Sum local loads (n, E) into (N,), or (C, n, E) into (N, C)."""
    columns = local.reshape(-1, mesh.cells.size)
    nodes = mesh.cells.T.ravel()
    sums = [np.bincount(nodes, weights=column, minlength=mesh.node_count) for column in columns]
    # With weights, np.bincount gives floating-point numbers; its type says integers.
    return sums[0] if local.ndim == 2 else np.stack(sums).T  # type: ignore[return-value]
