"""Dziuk 2008: Willmore flow by x and w = -H nu, semi-implicit."""

from collections.abc import Sequence

from harness.plugin import Level, Plugin, Problem
from solver.geometry import geometry
from solver.schemes.dziuk import curvature_vector
from solver.schemes.dziuk import step as dziuk_step


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


SCHEME = Plugin(
    title="Dziuk: Willmore flow as the gradient flow of the discrete energy",
    laws=("willmore",),
    offers=("x", "v"),
    start=start,
    step=step,
)
