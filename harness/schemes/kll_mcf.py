"""Kovacs, Li, Lubich 2019: mean curvature flow by evolution equations for nu and H."""

from collections.abc import Sequence
from typing import Literal

from esfem.schemes import BDFOptions, Level, Plugin, Problem
from esfem.solver import BDF, State
from esfem.solver.schemes.kll_mcf import start_step
from esfem.solver.schemes.kll_mcf import step as mcf_step


class Options(BDFOptions):
    """[scheme] of kll-mcf."""

    velocity: Literal["interpolated", "ritz"] = "ritz"


def level_of(s: State) -> Level:
    """A given State; what the next step needs is u = (H; nu)."""
    return Level(s.t, s.x, s.nu, s.H, s.V, v=s.v, memory=s.u)


def step(problem: Problem, past: Sequence[Level], t: float) -> Level:
    """One step of BDF q; the first q - 1 levels are exact, or made by `start_step`, of order q."""
    options = problem.options
    assert isinstance(options, Options)
    starts, ritz = len(past) < options.bdf, options.velocity == "ritz"
    if starts and problem.exact is not None:
        return level_of(problem.exact(t))
    mesh, tau, quadrature = problem.mesh, problem.tau, options.quadrature
    x, u = [level.x for level in past], [level.memory for level in past]
    if starts:
        x_new, v, u_new = start_step(mesh, x[0], u[0], tau, options.bdf, ritz, quadrature)
    else:
        x_new, v, u_new = mcf_step(mesh, x, u, tau, BDF.of_order(options.bdf), ritz, quadrature)
    return Level(t, x_new, nu=u_new[:, 1:], H=u_new[:, 0], V=-u_new[:, 0], v=v, memory=u_new)


SCHEME = Plugin(
    title="Kovacs, Li, Lubich: mean curvature flow by evolution equations for nu and H",
    laws=("mean_curvature",),
    offers=("x", "nu", "H", "V", "v"),
    start=lambda problem: level_of(problem.initial),
    step=step,
    options=Options,
    remembers=lambda options: options.bdf,
    substeps=True,
)
