"""Kovacs, Li, Lubich 2019: mean curvature flow by evolution equations for nu and H."""

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from harness.case import SchemeOptions
from harness.plugin import Level, Plugin, Problem
from solver import BDF, State
from solver.schemes.kll_mcf import step as mcf_step


class Options(SchemeOptions):
    """[scheme] of kll-mcf."""

    bdf: Annotated[int, Field(ge=1, le=5)]
    velocity: Literal["interpolated", "ritz"] = "ritz"
    start: Literal["exact", "self"] | None = None  # exact if the solution is known at all times


def level_of(s: State) -> Level:
    """A given State."""
    return Level(s.t, s.x, s.nu, s.H, s.V, v=s.v)


def step(problem: Problem, past: Sequence[Level], t: float) -> Level:
    """One step of BDF q; the first q - 1 levels are exact, or made by BDF 1, 2, ..., q - 1."""
    options: Options = problem.options
    if len(past) < options.bdf and problem.exact is not None:
        return level_of(problem.exact(t))
    levels = list(past)
    x, v, u = mcf_step(
        problem.mesh,
        [level.x for level in levels],
        [np.column_stack([level.H, level.nu]) for level in levels],
        problem.tau,
        BDF.of_order(len(levels)),
        options.velocity == "ritz",
        options.quadrature,
    )
    return Level(t, x, nu=u[:, 1:], H=u[:, 0], V=-u[:, 0], v=v)


SCHEME = Plugin(
    title="Kovacs, Li, Lubich: mean curvature flow by evolution equations for nu and H",
    laws=("mean_curvature",),
    offers=("x", "nu", "H", "V", "v"),
    start=lambda problem: level_of(problem.initial),
    step=step,
    options=Options,
    remembers=lambda options: options.bdf,
)
