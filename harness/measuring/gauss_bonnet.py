"""The theorem of Gauss and Bonnet for the discrete curvature: int K = 2 pi chi.

Of H_h and nu_h, which are solved for and not read off the surface, 2 K = H^2 - |S|^2 holds in the
limit alone, and needs no exact solution to be tested.
"""

import numpy as np

from esfem.solver import Mesh
from esfem.solver.geometry import Geometry, gradient, interpolate
from esfem.solver.reference_element import Array


def euler_characteristic(mesh: Mesh) -> int:
    """Vertices - edges + triangles of a closed triangulation, of three edges to two triangles."""
    return mesh.vertex_count - len(mesh.triangles) // 2


def total_curvature(geo: Geometry, nu: Array, H: Array) -> float:
    """1/2 int (H_h^2 - |S_h|^2) of nodal nu (N, 3) and H (N,), S_h the symmetric part of grad nu_h,
    as in the forms of the scheme (paper: A_h)."""
    grad_nu = gradient(geo, nu)
    S = 0.5 * (grad_nu + grad_nu.swapaxes(-1, -2))
    S2 = np.einsum("epab,epab->ep", S, S)
    return 0.5 * float(np.sum(geo.dA * (interpolate(geo, H) ** 2 - S2)))


def gauss_bonnet_error(geo: Geometry, nu: Array, H: Array) -> float:
    """|`total_curvature` - 2 pi chi|, without a unit."""
    return abs(total_curvature(geo, nu, H) - 2.0 * np.pi * euler_characteristic(geo.mesh))
