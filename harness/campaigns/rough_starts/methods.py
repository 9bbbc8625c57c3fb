"""Helfrich flow of the surface |x| = 1 + 0.2 P2 by BDF q with divided first steps, to t = 0.1.

All on one mesh. Differences of runs with successive tau are errors in time alone; the energy is
compared with an axisymmetric solution beside that.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from time import process_time

import numpy as np
import pandas as pd
import scipy.sparse as sp

from esfem.meshes import surface_mesh
from esfem.runs.problem import initial_state
from esfem.runs.run_case import computational_mesh
from esfem.solver import BDF, Levels, Mesh, Scheme, State, evolve
from esfem.solver.assembly import mass_matrix
from esfem.solver.geometry import geometry
from esfem.solver.laws import velocity_law
from esfem.solver.reference_element import Array
from esfem.studies.case import Law, Solution

H0 = 1.0  # spontaneous curvature
LAW = Law(name="helfrich", spontaneous_curvature=H0)
SURFACE = Solution(name="surface", surface="p2_sphere", reference="axisymmetric")
DEGREE, VERTICES = 4, 120
REACTION = "implicit"
T = 0.1
# Half the integral of (H - H0)^2 at t = T, to all these digits, by two axisymmetric solvers.
ENERGY = 5.17995709
COARSEST = 5  # steps of tau to T; halved so many times:
HALVINGS = 7
# Of the modes l on the unit sphere, to leading order: (l - 1) l (l + 1) (l + 2).
RATES = {4: 360.0, 6: 1680.0}
FASTEST = RATES[6]


@dataclass(frozen=True)
class Method:
    """BDF ``q``; the first ``stretch`` times q steps have ``substeps`` each; theta on or off."""

    q: int
    substeps: int
    theta: bool = True
    stretch: int = 1

    def levels(self, steps: int) -> Levels:
        """The time levels to T with so many steps of tau."""
        return Levels.started(T / steps, steps, self.stretch * self.q, self.substeps)


METHODS = (
    *(Method(q, m) for q in (1, 2, 3, 4) for m in (1, 4, 16, 64)),
    *(Method(q, 16, stretch=4) for q in (2, 3, 4)),
    *(Method(4, m, theta=False) for m in (1, 16)),
)


@cache
def ground() -> tuple[Mesh, State]:
    """The mesh, and the exact State at t = 0."""
    solution = SURFACE.initial()
    mesh, p = computational_mesh(surface_mesh(solution.mesh_surface, VERTICES), solution, DEGREE)
    return mesh, initial_state(LAW, p, solution)


def energy(mesh: Mesh, state: State) -> float:
    """The Helfrich energy of a State."""
    return LAW.energy.value(geometry(mesh, state.x), state.H)


def final(method: Method, levels: Levels) -> State:
    """The State at the last level."""
    mesh, initial = ground()
    scheme = Scheme(
        bdf=BDF.of_order(method.q),
        law=velocity_law(LAW.name, **LAW.parameters),
        theta=method.theta,
        reaction=REACTION,
    )
    *_, last = evolve(mesh, initial, scheme, levels)
    return last


def measured(method: Method, halvings: int = HALVINGS) -> pd.DataFrame:
    """A row a tau, large ones first.

    ``error_E`` is that of the energy at T; ``difference_x`` and ``difference_H`` are, in L^2 of the
    surface at t = 0, how far x and H at T are from those with tau / 2; ``order_x`` and ``order_H``
    are their `orders` in tau; ``steps`` counts substeps too.
    """
    mesh, initial = ground()
    M = mass_matrix(geometry(mesh, initial.x))
    counts = [COARSEST * 2**j for j in range(halvings + 1)]
    runs = [timed_final(method, method.levels(n)) for n in counts]
    states = [state for state, _ in runs]
    found = pd.DataFrame(
        {
            "q": method.q,
            "first_steps": method.substeps,
            "divided": [min(method.stretch * method.q, n) for n in counts],
            "stretch": method.stretch,
            "theta": method.theta,
            "tau": [T / n for n in counts],
            "tau_rate": [FASTEST * T / n for n in counts],
            "steps": [method.levels(n).steps for n in counts],
            "cpu_seconds": [seconds for _, seconds in runs],
            "error_E": [energy(mesh, state) - ENERGY for state in states],
        }
    )
    for name in ("x", "H"):
        values = [getattr(state, name) for state in states]
        d = [norm(M, fine - coarse) for coarse, fine in pairwise(values)]
        found[f"difference_{name}"] = [*d, np.nan]
        found[f"order_{name}"] = [np.nan, *orders(d), np.nan, np.nan]
    return found


def norm(M: sp.csr_array, values: Array) -> float:
    """sqrt(sum_c v_c^T M v_c), of nodal scalars or vectors."""
    return float(np.sqrt(np.sum(values * (M @ values))))


def orders(differences: Sequence[float]) -> list[float]:
    """Of each difference but the first and the last, from 2 tau to tau / 2.

    Over a factor of four, as errors that change their sign make every second ratio meaningless.
    """
    around = zip(differences, differences[2:], strict=False)
    return [float(np.log2(coarse / fine)) / 2.0 for coarse, fine in around]


def timed_final(method: Method, levels: Levels) -> tuple[State, float]:
    """The `final` State, and the seconds of the processor that it took."""
    began = process_time()
    return final(method, levels), process_time() - began
