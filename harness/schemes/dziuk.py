"""Dziuk 2008: Willmore flow by x and w = -H nu, semi-implicit."""

from collections.abc import Sequence

import numpy as np

from esfem.schemes import Level, Plugin, Problem
from esfem.solver.assembly import mass_matrix
from esfem.solver.geometry import geometry
from esfem.solver.schemes.dziuk import curvature_vector
from esfem.solver.schemes.dziuk import step as dziuk_step


def start(problem: Problem) -> Level:
    """The exact nodes; w from them."""
    x = problem.initial.x
    w = curvature_vector(geometry(problem.mesh, x, problem.options.quadrature), x)
    return Level(0.0, x, memory=w)


def step(problem: Problem, past: Sequence[Level], t: float) -> Level:
    """One step on the surface of the last level."""
    before = past[0]
    geo = geometry(problem.mesh, before.x, problem.options.quadrature)
    f = None if problem.forcing is None else problem.forcing(geo.points, t)
    x, w = dziuk_step(geo, before.x, before.memory, problem.tau, f)
    return Level(t, x, v=(x - before.x) / problem.tau, memory=w)


def energy(problem: Problem, level: Level) -> float:
    """1/2 int |w_h|^2 of the surface: what the scheme descends, without a normal."""
    geo = geometry(problem.mesh, level.x, problem.options.quadrature)
    w = curvature_vector(geo, level.x)
    return 0.5 * float(np.sum(w * (mass_matrix(geo) @ w)))


SCHEME = Plugin(
    title="Dziuk: Willmore flow as the gradient flow of the discrete energy",
    laws=("willmore",),
    offers=("x", "v"),
    start=start,
    step=step,
    energy=energy,
)
