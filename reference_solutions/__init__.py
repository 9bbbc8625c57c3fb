"""Exact surfaces and exact flows: an independent witness of what the solver should compute.

Nothing here imports `esfem.solver`, nor any room; the formulas are closed forms of differential
geometry. Conventions: lengths and times are dimensionless; nu points outward; H = kappa_1 + kappa_2
> 0 on spheres; the gradient of a vector field has the gradients of the components as columns,
``(grad f)[a, b] = d_a f_b``.

The registry `SOLUTIONS` maps the name used in study files to the class of the exact solution,
`STARTS` that of all from which a run can start.
"""

from esfem.reference_solutions.breathing_ellipsoid import BreathingEllipsoid
from esfem.reference_solutions.exact import (
    DecayingMode,
    ExactSolution,
    Fields,
    InitialSurface,
    decays,
)
from esfem.reference_solutions.helfrich_sphere import HelfrichSphere
from esfem.reference_solutions.perturbed_sphere import PerturbedSphere
from esfem.reference_solutions.perturbed_torus import PerturbedCliffordTorus
from esfem.reference_solutions.sphere import LogisticSphere, ShrinkingSphere, StationarySphere
from esfem.reference_solutions.spheroid import Spheroid
from esfem.reference_solutions.surface_flow import SurfaceFlow
from esfem.reference_solutions.torus import CliffordTorus, RoundTorus, Torus

SOLUTIONS: dict[str, type[ExactSolution]] = {
    solution.name: solution
    for solution in (
        StationarySphere,
        CliffordTorus,
        HelfrichSphere,
        LogisticSphere,
        ShrinkingSphere,
        BreathingEllipsoid,
        PerturbedSphere,
        PerturbedCliffordTorus,
    )
}

STARTS: dict[str, type[InitialSurface]] = {
    **SOLUTIONS,
    SurfaceFlow.name: SurfaceFlow,
    RoundTorus.name: RoundTorus,
}

__all__ = [
    "SOLUTIONS",
    "STARTS",
    "BreathingEllipsoid",
    "CliffordTorus",
    "DecayingMode",
    "ExactSolution",
    "Fields",
    "HelfrichSphere",
    "InitialSurface",
    "LogisticSphere",
    "PerturbedCliffordTorus",
    "PerturbedSphere",
    "RoundTorus",
    "ShrinkingSphere",
    "Spheroid",
    "StationarySphere",
    "SurfaceFlow",
    "Torus",
    "decays",
]
