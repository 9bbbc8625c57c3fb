"""Everything a step assembles on one surface, patch by patch.

A patch is a stretch of elements whose fields at quadrature points stay in the processor's cache:
with more than some ten thousand nodes, memory is slower than the formulas.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np
import scipy.sparse as sp

from esfem.solver import forms
from esfem.solver.assembly import local_mass, local_stiffness, matrix, scatter
from esfem.solver.forms import Curvature
from esfem.solver.geometry import Geometry, geometry
from esfem.solver.laws import AnyLaw
from esfem.solver.mesh import Mesh, Patch
from esfem.solver.reference_element import Array
from esfem.solver.threads import spread


@dataclass(frozen=True)
class System:
    """M, A (N, N), and f = (0; f2), g = (g1; g2), dual (N, 4), on Gamma_h[x] with u = (H; nu)."""

    mesh: Mesh
    M: sp.csr_array
    A: sp.csr_array
    f: Array
    g: Array
    fields: list[tuple[Geometry, Curvature]]  # by patch

    def F(self, w: Array) -> Array:
        """F w = (F1 V; F2 z): nodal w (N, 4) -> dual (N, 4)."""
        return self._by_patch(forms.local_F, w)

    def linear(self, pair: Array) -> Array:
        """F1 V and int q H phi_j: the nodal pair (H, V) (N, 2) -> dual (N, 2)."""
        return self._by_patch(forms.local_linear, pair)

    def _by_patch(self, form: Callable[[Geometry, Curvature, Array], Array], y: Array) -> Array:
        """The dual vector (N, C) of a form of nodal y (N, C)."""
        local = np.empty((y.shape[1], *self.mesh.cells.T.shape))

        def on(patch: Patch, fields: tuple[Geometry, Curvature]) -> None:
            local[:, :, patch.elements] = form(*fields, y)

        spread(on, self.mesh.patches, self.fields)
        return scatter(self.mesh, local)


def assembled(
    mesh: Mesh, x: Array, u: Array, law: AnyLaw, t: float, quadrature_degree: int | None
) -> System:
    """The system on the surface with nodes x (N, 3), its forms evaluated at u = (H; nu) (N, 4)."""
    E, n = mesh.cells.shape
    mass, stiffness, loads = np.empty((n * n, E)), np.empty((n * n, E)), np.empty((7, n, E))

    def on(patch: Patch) -> tuple[Geometry, Curvature]:
        geo = geometry(cast(Mesh, patch), x, quadrature_degree)
        curvature = forms.curvature(geo, u, law, t)
        mass[:, patch.elements] = local_mass(geo)
        stiffness[:, patch.elements] = local_stiffness(geo)
        loads[:, :, patch.elements] = forms.local_loads(geo, curvature)
        return geo, curvature

    fields = spread(on, mesh.patches)
    f, g = forms.loads_of(scatter(mesh, loads))
    return System(mesh, matrix(mesh, mass), matrix(mesh, stiffness), f, g, fields)
