"""The three ways to take the reaction terms: what README, "Decisions", says of them is measured.

Tables in `OUT`, on a machine that does nothing else:

- ``errors``: on solutions that move, with the order in tau between the two finest steps;
- ``steps``: what a step costs; ``stable``: the largest step of 20 that stay bounded;
- ``rounding``: by what a step multiplies the distance of two flows that start side by side;
- ``starts``: the error of W on two of the paper's flows, with and without divided first steps.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product, takewhile
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console

from esfem.campaigns.contest.contest import GROUNDS, PRINCIPAL
from esfem.campaigns.contest.entrant_run import is_stable, largest_stable
from esfem.common.files import write_text
from esfem.common.provenance import provenance_line
from esfem.flows.checks import reference_flow
from esfem.flows.flow_file import load_flow
from esfem.flows.start import exact_start
from esfem.measuring.lift import VARIABLES
from esfem.meshes import surface_mesh
from esfem.reference_solutions import BreathingEllipsoid, StationarySphere
from esfem.results.records import run_errors
from esfem.runs.problem import exact_states, initial_state
from esfem.runs.run_case import computational_mesh, run_case
from esfem.solver import BDF, Levels, Mesh, Scheme, State, evolve
from esfem.solver.functionals import willmore_energy
from esfem.solver.geometry import geometry
from esfem.solver.laws import forced, willmore
from esfem.studies.case import Case, Law
from esfem.studies.catalogue import flow_path

OUT = Path("results/bench")
REACTIONS = ("implicit", "extrapolated", "linearised")
LARGE = 1e-3  # of a distance in u, above which flows are no longer side by side
WILLMORE = Law(name="willmore")
Row = dict[str, Any]


@dataclass(frozen=True)
class Ground:
    """A solution that moves, its mesh and its time steps; ``errors`` names columns of a record."""

    solution: Row
    law: Row
    degree: int
    vertices: int
    final_time: float
    tau: tuple[float, ...]
    errors: dict[str, str]

    def case(self, q: int, reaction: str, tau: float) -> Case:
        """The run by BDF q; the W of a flow is compared at its end."""
        exact = self.solution["name"] != "surface"
        options = {"degree": self.degree, "bdf": q, "project": True, "theta": exact}
        return Case.model_validate(
            {
                "solution": self.solution,
                "law": self.law,
                "scheme": {**options, "reaction": reaction},
                "vertices": self.vertices,
                "tau": tau,
                "final_time": self.final_time,
                "compare_at": () if exact else (self.final_time,),
            }
        )


NODAL = {name: f"nodal_{name}" for name in VARIABLES}
BREATHING = {"name": "breathing_ellipsoid", "amplitude": 0.25, "period": 0.2}
CELL = {"name": "surface", "surface": "red_blood_cell", "reference": "axisymmetric"}
HELFRICH = {"name": "helfrich", "spontaneous_curvature": 1.0}
GROUND = (
    Ground(BREATHING, {"name": "willmore"}, 4, 240, 0.025, (2.5e-3, 1.25e-3, 6.25e-4), NODAL),
    Ground({"name": "helfrich_sphere"}, HELFRICH, 3, 240, 0.5, (0.05, 0.025, 0.0125), NODAL),
    Ground(CELL, {"name": "willmore"}, 2, 480, 0.2, (0.01, 0.005, 0.0025), {"W": "err_W"}),
)


def errors() -> Iterator[Row]:
    """The largest errors against the interpolation, or of W, at the finest step; their orders."""
    for ground, q, reaction in product(GROUND, (1, 2, 3), REACTIONS):
        found = [run(ground.case(q, reaction, tau)) for tau in ground.tau]
        row = {"solution": ground.solution["name"], "BDF": q, "reaction": reaction}
        row["tau"] = ground.tau[-1]
        for name, column in ground.errors.items():
            coarse, fine = found[-2][column], found[-1][column]
            row |= {name: f"{fine:.3g}", f"order of {name}": f"{np.log2(coarse / fine):.2f}"}
        yield row


def run(case: Case) -> dict[str, float]:
    """The errors of a run, by their columns."""
    surface = surface_mesh(case.solution.initial().mesh_surface, case.vertices)
    return run_errors(run_case(case, surface)[0])


def steps() -> Iterator[Row]:
    """Processor milliseconds of a step on a moving surface, P2, BDF2, after the first four."""
    solution = BreathingEllipsoid(0.25, 1.0)
    law = forced(willmore, solution.forcing("willmore", {}))
    for vertices, reaction in product((960, 3840), REACTIONS):
        surface = surface_mesh(solution.mesh_surface, vertices)
        mesh, p = computational_mesh(surface, solution, 2)
        scheme = Scheme(bdf=BDF.of_order(2), law=law, theta=True, reaction=reaction)
        start = initial_state(WILLMORE, p, solution), exact_states(solution, p)
        spent = timed(mesh, *start, scheme, Levels.equal(2.5e-3, 16))
        milliseconds = 1e3 * float(np.mean(spent[4:]))
        yield {"N": mesh.node_count, "reaction": reaction, "ms": f"{milliseconds:.1f}"}


def timed(mesh: Mesh, initial: State, start: Any, scheme: Scheme, levels: Levels) -> list[float]:
    """Processor seconds of each step."""
    states, spent = evolve(mesh, initial, scheme, levels, start), []
    next(states)
    for _ in range(levels.steps):
        began = process_time()
        next(states)
        spent.append(process_time() - began)
    return spent


def stable() -> Iterator[Row]:
    """The largest step of 20 that stay bounded, P2, BDF1, V = 120."""
    for name in ("Clifford torus", "ellipsoid 2:1:1", "red blood cell"):
        row = {"surface": name}
        for reaction in REACTIONS:
            options = {**PRINCIPAL["kll"], "reaction": reaction}

            def bounded(tau: float, options: Any = options, name: str = name) -> bool:
                return is_stable(options, GROUNDS[name], 120, tau)

            row[reaction] = f"{largest_stable(bounded):.2g}"
        yield row


def rounding() -> Iterator[Row]:
    """On a unit sphere at rest, P2, V = 120, with theta: growth of a disturbance in a step."""
    solution = StationarySphere()
    mesh, p = computational_mesh(surface_mesh("sphere", 120), solution, 2)
    initial = initial_state(WILLMORE, p, solution)
    noise = np.random.default_rng(0).standard_normal(len(p))
    other = replace(initial, H=initial.H * (1.0 + 1e-9 * noise))
    every = (
        *product((0.05,), (2, 3, 4, 5)),
        *product((0.01,), (3, 4, 5)),
        (0.1, 2),
        (0.2, 2),
        (0.2, 1),
    )
    for tau, q in every:
        row: Row = {"tau": tau, "BDF": q}
        for reaction in REACTIONS:
            scheme = Scheme(bdf=BDF.of_order(q), theta=True, reaction=reaction)
            flows = (evolve(mesh, s, scheme, Levels.equal(tau, 60)) for s in (initial, other))
            distances = (np.linalg.norm(a.u - b.u) for a, b in zip(*flows, strict=True))
            row[reaction] = f"{growth(list(takewhile(lambda d: d < LARGE, distances))):.2f}"
        yield row


def growth(distances: list[float]) -> float:
    """The mean factor a step, over the later half."""
    half = distances[len(distances) // 2 :]
    return float((half[-1] / half[0]) ** (1.0 / (len(half) - 1)))


def starts() -> Iterator[Row]:
    """The largest relative error of W at the times of comparison up to 0.2."""
    for name, reaction, m in product(("red-blood-cell", "ellipsoid"), REACTIONS, (1, 4)):
        flow = load_flow(flow_path(name))
        reference = reference_flow(flow)
        start = exact_start(flow, OUT / "meshes", Console(quiet=True))
        levels = Levels.started(flow.time.tau, round(0.2 / flow.time.tau), flow.scheme.bdf, m)
        scheme = Scheme(bdf=BDF.of_order(flow.scheme.bdf), reaction=reaction)
        at = {levels.at(t): i for i, t in enumerate(reference.times) if 0.0 < t <= 0.2}
        worst = 0.0
        for n, state in enumerate(evolve(start.mesh, start.state, scheme, levels)):
            if n in at:
                W = willmore_energy(geometry(start.mesh, state.x), state.H)
                worst = max(worst, abs(W / reference.willmore[at[n]] - 1.0))
        yield {"flow": name, "reaction": reaction, "first_steps": m, "error of W": f"{worst:.1e}"}


def main() -> None:
    """Write and print all tables."""
    for table in (errors, steps, stable, rounding, starts):
        frame = pd.DataFrame(table())
        text = f"# {provenance_line()}\n{frame.to_csv(index=False)}"
        write_text(OUT / f"reactions-{table.__name__}.csv", text)
        print(f"{table.__name__}: {table.__doc__}\n{frame.to_string(index=False, na_rep='')}\n")


if __name__ == "__main__":
    main()
