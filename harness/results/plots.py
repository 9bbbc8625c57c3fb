"""Plots of a study: errors and final energy against h.  SVG for screens, PDF for papers."""

import math
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from esfem.common.bad_input import BadInput
from esfem.common.drawing import (
    level_ticks,
    save_figure,
    series_look,
    stopped_crosses,
    styled,
    subplots,
)
from esfem.measuring.lift import lifted_surface
from esfem.measuring.shape import profile_flow
from esfem.meshes import committed_sizes, surface_mesh
from esfem.reference_solutions import ExactSolution
from esfem.results.error_verdicts import PREFIXES
from esfem.results.study_result import StudyResult
from esfem.runs.run_case import computational_mesh
from esfem.solver.laws import Energy, energy_of
from esfem.studies.quantities import NODAL, QUANTITIES
from esfem.studies.study import Study

ENERGY_V = 240  # vertices of the mesh on which the energy of an exact surface is computed
ROUNDING = 1e-9  # errors that are all below this are shown as exact,
LEAST = 1e-15  # and zeros among them here, for an axis of logarithms has no zero

AXES = {"h": "mesh width $h$", "tau": r"time step $\tau$"}


def save_plots(folder: Path, result: StudyResult) -> None:
    """Write errors.svg/.pdf and energy.svg/.pdf into the folder."""
    for name, draw in (("errors", error_figure), ("energy", energy_figure)):
        save_figure(draw(result), folder / f"{name}.svg", result.study.title)


@styled()
def error_figure(result: StudyResult) -> Figure:
    """Log-log errors of all variables against h or tau, with the runs that stopped."""
    study = result.study
    columns = {1: 1, 2: 2, 4: 2}.get(len(study.variables), 3)
    rows = -(-len(study.variables) // columns)
    size = (max(5.0, 3.0 * columns), 1.4 + 2.4 * rows if rows > 1 else 4.0)
    figure, axes = subplots(rows, columns, size, sharex=True, squeeze=False)
    for axis, name in zip(axes.flat, study.variables, strict=False):
        _error_panel(axis, result, name)
    for axis in axes.flat[len(study.variables) :]:
        axis.remove()
    for axis in axes.flat[max(0, len(study.variables) - columns) : len(study.variables)]:
        axis.set_xlabel(AXES[study.direction])
        axis.xaxis.set_tick_params(labelbottom=True)
    for axis in axes[:, 0]:
        axis.set_ylabel("error")
    handles, labels = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 6))
    # A title is text: "$x_{$" is no formula.
    width = int(12 * size[0])
    told = [result.words.case, f"{result.words.errors}{_lines(result)}"]
    heading = "\n".join([study.title, *(fill(text, width) for text in told)])
    figure.suptitle(heading, fontsize=9, parse_math=False)
    return figure


@styled()
def energy_figure(result: StudyResult) -> Figure:
    """The energy of the law at T against h or tau, with the exact value; beside it W, where that is
    another one."""
    study = result.study
    shown = {"energy_T": study.law.energy, "willmore_T": energy_of("willmore")}
    if study.law.energy.symbol == "W":
        del shown["energy_T"]
    n = len(shown)
    figure, axes = subplots(1, n, (5.0 * n, 3.8), squeeze=False)
    known = known_energies(study)
    for axis, (column, energy) in zip(axes.flat, shown.items(), strict=True):
        _energy_panel(axis, result, column, energy)
        if column in known:
            exact = {"color": "black", "linestyle": "--", "linewidth": 1}
            axis.axhline(known[column], **exact, label=f"exact {known[column]:.4f}")
        axis.legend(fontsize=8)
    what = "final energy; forced, so that it need not decrease" if study.forced else "final energy"
    figure.suptitle(f"{study.title}\n{what}", fontsize=9, parse_math=False)
    return figure


def _energy_panel(axis: Axes, result: StudyResult, column: str, energy: Energy) -> None:
    parameter, symbol = result.study.direction, energy.symbol
    for i, (label, runs) in enumerate(_series(result)):
        finished = runs[runs["status"] == "ok"]
        look = {**series_look(i), "label": label, "gid": series_gid(i, symbol)}
        axis.semilogx(finished[parameter], finished[column], **look)
    _level_ticks(axis, result.records[parameter])
    axis.set_xlabel(AXES[parameter])
    axis.set_ylabel(f"{energy.name} ${symbol}_h(T)$")
    axis.set_title(f"${symbol} = {energy.tex}$", fontsize=9)


def known_energies(study: Study) -> dict[str, float]:
    """What columns of records.csv tend to: energy_T, that of the law, and willmore_T; of the
    solution, or of the axisymmetric reference, and {} if there is neither."""
    T, energy = study.sweep.final_time, study.law.energy
    solution: Any = study.initial  # a SurfaceFlow where it has a reference, else exact
    if solution.reference == "axisymmetric":
        times = sorted({0.0, *study.sweep.compare_at, T})
        try:
            flow = profile_flow(solution, study.law, tuple(times))
        except BadInput:  # the reference ends before T
            return {}
        return {"energy_T": float(flow.energies[-1]), "willmore_T": float(flow.willmore[-1])}
    if solution.reference in ("finest", "start"):
        return {}
    W = solution.willmore(T)
    own = W if energy.symbol == "W" else exact_energy(solution, energy, T)
    return {"energy_T": own, "willmore_T": W}


def exact_energy(solution: ExactSolution, energy: Energy, t: float) -> float:
    """An energy of Gamma(t), from its parametrisation over a mesh of P_4 and the exact H in its
    nodes: to about six digits."""
    name = solution.mesh_surface
    sizes = [v for v in committed_sizes(name) if v <= ENERGY_V]
    mesh, p = computational_mesh(surface_mesh(name, max(sizes, default=ENERGY_V)), solution, 4)
    x = solution.trajectories(p)(t)
    return energy.value(lifted_surface(mesh, solution, x, t).geometry, solution.fields(x, t).H)


def series_gid(i: int | str, what: str) -> str:
    """Name of the group of an SVG that draws what belongs to the i-th series."""
    return f"series-{i}-{what}"


def _lines(result: StudyResult) -> str:
    """Which line is which error, where two are drawn."""
    two = any(len(verdict.parts) > 1 for verdict in result.verdicts)
    told = f"; against the interpolation: {NODAL}. Solid: what decides; dashed: the other"
    return told if two else ""


def _error_panel(axis: Axes, result: StudyResult, name: str) -> None:
    verdict = next(v for v in result.verdicts if v.variable == name)
    column, limit = verdict.deciding.column(name), verdict.limit
    records, parameter = result.records, result.study.direction
    both = {f"{prefix}{name}" for prefix in PREFIXES.values()} & set(records)
    others, exact = both - {column}, records[column].max() < ROUNDING
    for i, (label, runs) in enumerate(_series(result)):
        finished = runs[runs["status"] == "ok"]
        look = {**series_look(i), "label": label, "gid": series_gid(i, name)}
        shown = finished[column].clip(lower=LEAST) if exact else finished[column]
        axis.loglog(finished[parameter], shown, **look)
        for other in others:
            if not exact:
                gid = series_gid(i, f"{name}-other")
                thin = {**series_look(i), "lw": 0.9, "ms": 2.0, "ls": "--", "gid": gid}
                axis.loglog(finished[parameter], finished[other].where(finished[other] > 0), **thin)
    # Text of an SVG has no calligraphic letters: matplotlib's own font for them is not on a page.
    symbol = QUANTITIES[name].tex.replace(r"\mathcal{V}", r"\mathrm{vol}")
    against = "" if column.startswith("err_") else ", against the interpolation"
    axis.set_title(f"${symbol}${against}", fontsize=10)
    if exact:
        axis.set_ylim(LEAST, 10 * ROUNDING)
        axis.text(0.5, 0.9, "exact up to rounding", ha="center", transform=axis.transAxes)
    bounded = np.isfinite(limit)
    if bounded and not exact:
        axis.axhline(limit, color="black", linestyle="--", linewidth=1.0, label="limit")
    # Where nobody claims anything, the triangle shows the order of the elements or of the method.
    claimed = np.isfinite(verdict.expected) or result.study.claimed is None
    if claimed and not exact:
        drawn = records[sorted({column, *others})]
        lowest = drawn.where(drawn > 0).min(axis=1).where(records["status"] == "ok")
        _slope_triangle(axis, records[parameter], lowest, _reference_order(result.study))
    _mark_stopped(axis, result, name)
    _level_ticks(axis, records[parameter])


def _mark_stopped(axis: Axes, result: StudyResult, name: str) -> None:
    """Crosses in a band above the data."""
    parameter = result.study.direction
    stopped = [runs.loc[runs["stopped_at"].notna(), parameter] for _, runs in result.series]
    stopped_crosses(axis, stopped, 0.045, series_gid("{i}", f"{name}-stopped"))


def _reference_order(study: Study) -> float:
    claimed = study.expected_order
    return float(study.scheme.degree) if math.isnan(claimed) else claimed


def _slope_triangle(axis: Axes, s: pd.Series, lowest: pd.Series, order: float) -> None:
    """A triangle of the given slope below the finest end of the data.

    Parameters
    ----------
    s, lowest : h or tau of the runs, and the lowest of the errors that are drawn there, NaN where
        none is.
    """
    s, lowest = s[lowest.notna()], lowest.dropna()
    if s.nunique() < 2:
        return
    h0 = s.min()
    h1 = min(h0 * 1.6, s.max())
    # Below every point over the triangle's own width, so that it crosses no line.
    over = s <= 1.05 * h1
    e0 = 0.35 * np.min(lowest[over] * (h0 / s[over]) ** order)
    e1 = e0 * (h1 / h0) ** order
    axis.plot([h0, h1, h1, h0], [e0, e0, e1, e0], color="0.35", linewidth=0.9)
    axis.annotate(
        f"{order:g}",
        (h1, np.sqrt(e0 * e1)),
        xytext=(3, 0),
        textcoords="offset points",
        va="center",
        fontsize=8,
    )


def _level_ticks(axis: Axes, s: pd.Series) -> None:
    """Ticks at the levels of the sweep that can be read."""
    levels = sorted(s.unique())
    level_ticks(axis, levels[:: max(1, len(levels) // 4)])


def _series(result: StudyResult) -> list[tuple[str, pd.DataFrame]]:
    """Label and runs of each line."""
    return [(label.replace("tau", r"$\tau$"), runs) for label, runs in result.series]
