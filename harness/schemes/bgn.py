"""Barrett, Garcke, Nuernberg 2007, 2008: Willmore flow and surface diffusion, nodes that slide."""

from collections.abc import Sequence

from esfem.schemes import Level, Plugin, Problem
from esfem.solver import LAWS
from esfem.solver.geometry import geometry
from esfem.solver.schemes.bgn import step as bgn_step


def step(problem: Problem, past: Sequence[Level], t: float) -> Level:
    """One step on the surface of the last level."""
    before = past[0]
    assert before.H is not None and problem.law is not None
    geo = geometry(problem.mesh, before.x, problem.options.quadrature)
    x, H = bgn_step(geo, before.x, before.H, problem.tau, problem.law, t)
    return Level(t, x, H=H, v=(x - before.x) / problem.tau)


SCHEME = Plugin(
    title="Barrett, Garcke, Nuernberg: V = Lap H + Q with tangential redistribution",
    laws=tuple(LAWS),
    offers=("x", "H", "v"),
    step=step,
    slides=True,
)
