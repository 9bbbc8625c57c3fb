"""Ablation on the Clifford torus: theta, projections, BDF, and how a step takes the reaction terms.

All combinations, F1 and F2 apart among them, on two meshes that resolve the surface. The runs are
no studies, since no study file asks for F1 or F2 alone; they are swept and stored as those are.
"""

from itertools import product
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from pydantic import create_model
from rich.console import Console

from esfem.campaigns.paper.plan import ABLATION
from esfem.campaigns.paper.stored_results import Missing, Row, stopped_runs
from esfem.common.drawing import labelled_map, styled, subplots
from esfem.common.files import writable_folder
from esfem.meshes import surface_mesh
from esfem.report.extra import Extra
from esfem.results.records import rows_of
from esfem.runs.store import Cell, stored_records
from esfem.runs.sweep import How, sweep
from esfem.schemes.kll import KLLOptions
from esfem.solver.reference_element import Array
from esfem.studies.case import Case, Law, Solution
from esfem.studies.words import PROJECTIONS

Reaction = Literal["implicit", "implicit-F1", "implicit-F2", "extrapolated", "linearised"]
REACTIONS: tuple[str, ...] = get_args(Reaction)
FACTORS = ("bdf", "theta", "project", "reaction")  # what is varied
VERTICES = (240, 480)
TAUS = (0.2, 0.1, 0.05, 0.025, 0.0125, 0.00625)
FINAL_TIME = 1.0
SHOWN = ("x", "nu", "H")
DARK, BRIGHT = 1e-3, 1.0  # the ends of the scale of colours


# [scheme] of kll with every way that the solver has to take the reaction terms.
Options = create_model(
    "Options", __base__=KLLOptions, __module__=__name__, reaction=(Reaction, ...)
)


def variants() -> list[KLLOptions]:
    """All combinations of the factors."""
    every = product((1, 2), (False, True), (True, False), REACTIONS)
    return [
        Options.model_validate({"degree": 2, **dict(zip(FACTORS, values, strict=True))})
        for values in every
    ]


def cases() -> list[Case]:
    """The runs: all variants on all meshes with all time steps."""
    torus, law = Solution(name="clifford_torus", scale=1.0), Law(name="willmore")
    every = product(variants(), VERTICES, TAUS)
    return [
        Case(solution=torus, law=law, scheme=s, vertices=v, tau=tau, final_time=FINAL_TIME)
        for s, v, tau in every
    ]


def cells(runs: Path) -> list[Cell]:
    """The runs with the folder of their records, below ``runs``."""
    meshes = {vertices: surface_mesh("clifford_torus", vertices) for vertices in VERTICES}
    folder = (runs / ABLATION).resolve()
    return [Cell(ABLATION, folder, case, meshes[case.vertices]) for case in cases()]


def run_ablation(runs: Path, jobs: int | None, console: Console) -> None:
    """Run what is not stored below ``runs``, in ``jobs`` processes, by default on all cores.

    Raises
    ------
    BadInput
        If the folder cannot be written.
    """
    writable_folder(runs / ABLATION, "records", "progress")
    how = How(jobs=jobs)
    sweep(cells(runs), how.workers(), how, console)


def ablation(runs: Path) -> Extra:
    """The table, a line a variant, and maps of the errors and stops on the finer mesh.

    Raises
    ------
    Missing
        Unless all runs are stored.
    """
    every = cells(runs)
    stored = rows_of(every, stored_records(every))
    if len(stored) < len(every):
        raise Missing("the ablation has not been run")
    found, finest = pd.DataFrame(stored.values()), max(VERTICES)
    return Extra(
        title="Ablation on the Clifford torus: theta, projections, BDF, reaction",
        text=(
            f"P2, V = {' and '.join(map(str, VERTICES))}, tau = {TAUS[0]:g} to {TAUS[-1]:g}, "
            f"T = {FINAL_TIME:g}. Reaction: how F w and the leading part of Q are taken; "
            "extrapolated is the paper's, implicit-F1 and implicit-F2 take one of the two terms "
            "of F w from the new time level. The maps have the error of x against its "
            f"interpolation on V = {finest}; a run that stopped is white, with the time at which "
            "it did. In the table the errors are the largest over the time steps that reach T on "
            f"V = {finest}, in L-infinity(0,T; H^1), first |u_h - u| and then |u_h - I_h u|; what "
            "stops is named with its time."
        ),
        table=rows_by_variant(found),
        figure=figure(found[found["vertices"] == finest]),
        alt="Maps of reactions and time steps, with the error of x or the time of the stop",
    )


def rows_by_variant(found: pd.DataFrame) -> list[Row]:
    """The table: a line a variant, in their order."""
    return [row(runs) for _, runs in found.groupby(list(FACTORS), sort=False)]


def row(runs: pd.DataFrame) -> Row:
    """One line of the table, from the runs of a variant."""
    bdf, theta, project, reaction = runs.iloc[0][list(FACTORS)]
    ended = runs[runs["status"] == "ok"]
    counts = {v: (ended["vertices"] == v).sum() for v in VERTICES}
    finest = ended[ended["vertices"] == max(VERTICES)]
    columns = {f"{name}_h - {name}": f"err_{name}" for name in SHOWN}
    columns |= {f"{name}_h - I_h {name}": f"nodal_{name}" for name in SHOWN}
    return {
        "BDF": int(bdf),
        "theta": "yes" if theta else "no",
        "projection": PROJECTIONS[bool(project)],
        "reaction": reaction,
        **{f"reach T, V = {v}": f"{n} of {len(TAUS)}" for v, n in counts.items()},
        **{shown: largest(finest[column]) for shown, column in columns.items()},
        "stops early": stopped_runs(runs),
    }


def largest(errors: pd.Series) -> float | None:
    """The largest one, to three digits."""
    return None if errors.empty else float(f"{errors.max():.3g}")


@styled({"axes.grid": False})
def figure(found: pd.DataFrame) -> Figure:
    """A map for BDF, theta and projection: reactions over time steps."""
    groups = found.groupby(["bdf", "theta", "project"], sort=False)
    drawn, axes = subplots(2, len(groups) // 2, (13.0, 5.0), sharex=True, sharey=True)
    for axis, ((bdf, theta, project), runs) in zip(axes.flat, groups, strict=True):
        image = panel(axis, runs)
        words = [f"BDF{bdf}", r"$\vartheta$" if theta else r"no $\vartheta$"]
        words.append(f"projection {PROJECTIONS[bool(project)]}")
        axis.set_title(", ".join(words), fontsize=9)
    for axis in axes[-1]:
        axis.set_xlabel(r"time step $\tau$")
    label = r"error of $x_h - I_h x$; †: $t$ at which the run stops"
    drawn.colorbar(image, ax=axes, shrink=0.8, label=label, extend="both")
    return drawn


def panel(axis: Axes, runs: pd.DataFrame) -> ScalarMappable:
    """One map."""

    def grid(column: str) -> Array:
        table = runs.pivot(index="reaction", columns="tau", values=column)
        return table.reindex(index=REACTIONS, columns=TAUS).to_numpy(float)

    errors, norm = grid("nodal_x"), LogNorm(DARK, BRIGHT)
    texts = np.vectorize(_told)(errors, grid("stopped_at"))
    on_dark = errors > np.sqrt(DARK * BRIGHT)
    image = labelled_map(axis, errors, texts, "viridis_r", norm, on_dark)
    axis.set_xticks(range(len(TAUS)), [f"{tau:g}" for tau in TAUS], rotation=45, fontsize=7)
    axis.set_yticks(range(len(REACTIONS)), REACTIONS, fontsize=8)
    return image


def _told(error: float, stop: float) -> str:
    """An error, or the time of a stop."""
    number = f"{error:.1e}".replace("e-0", "e-").replace("e+00", "e0")
    return number if np.isfinite(error) else f"†{stop:.2g}"
