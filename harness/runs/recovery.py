"""What a scheme lacks of a State, recovered from the surface by one method: L2 projection.

On Gamma_h[x], with the mass matrix M and the normal n of the surface itself,

    nu = m / |m|  with  M m = int n phi_j,
    H = -w . nu   with  M w = -int grad x . grad phi_j     (w = Lap x = -H nu),
    z             with  M z = int grad H phi_j,
    v = (x^n - x^{n-1}) / tau,  V = v . nu,

each only if the scheme does not offer it, from what it offers. On P_k surfaces n is of order k in
L2, so that errors of recovered quantities are one order poorer in H1 than those of unknowns.
"""

from collections.abc import Callable

import numpy as np

from esfem.schemes import Level
from esfem.solver import Mesh, State
from esfem.solver.assembly import load, mass_matrix, stiffness_matrix
from esfem.solver.direct import factored
from esfem.solver.geometry import geometry, gradient
from esfem.solver.reference_element import Array
from esfem.solver.scheme import Work, unit


def completed(
    mesh: Mesh, level: Level, before: Level, work: Work, quadrature: int | None = None
) -> State:
    """The State of a level, from it and the one before."""
    missing = [name for name in ("nu", "H", "V", "z") if getattr(level, name) is None]
    v = (level.x - before.x) / (level.t - before.t) if level.v is None else level.v
    if not missing:
        return State(level.t, level.x, level.nu, level.H, level.V, level.z, work, v)
    geo = geometry(mesh, level.x, quadrature)
    project: Callable[[Array], Array] | None = None

    def projected(r: Array) -> Array:
        nonlocal project
        project = project or factored(mass_matrix(geo))
        return project(r)

    nu = unit(projected(load(geo, geo.normal))) if level.nu is None else level.nu
    H = level.H
    if H is None:
        w = projected(-(stiffness_matrix(geo) @ level.x))
        H = -np.einsum("ja,ja->j", w, nu)
    V = np.einsum("ja,ja->j", v, nu) if level.V is None else level.V
    z = projected(load(geo, gradient(geo, H))) if level.z is None else level.z
    return State(level.t, level.x, nu, H, V, z, work, v)
