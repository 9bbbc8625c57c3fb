"""Plots of a study: errors and final energy against h.  SVG for screens, PDF for papers."""

from pathlib import Path
from textwrap import fill

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from harness.claims import claims
from harness.palette import MARKERS, PALETTE, STYLE
from harness.provenance import provenance_line
from harness.quantities import QUANTITIES
from harness.selection import direction
from harness.study import Study
from harness.tables import series
from harness.words import describe, norms
from reference_solutions import SurfaceFlow

ROUNDING = 1e-9  # errors that are all below this are shown as exact,
LEAST = 1e-15  # and zeros among them here, for an axis of logarithms has no zero

AXES = {"h": "mesh width $h$", "tau": r"time step $\tau$"}


def save_plots(folder: Path, study: Study, records: pd.DataFrame) -> None:
    """Write errors.svg/.pdf and energy.svg/.pdf into the folder."""
    with plt.rc_context(STYLE):
        for name, figure in (
            ("errors", error_figure(study, records)),
            ("energy", energy_figure(study, records)),
        ):
            note = f"{study.study.title}; {provenance_line()}"
            figure.savefig(folder / f"{name}.svg", metadata={"Description": note, "Date": None})
            figure.savefig(folder / f"{name}.pdf", metadata={"Subject": note, "CreationDate": None})
            plt.close(figure)


def error_figure(study: Study, records: pd.DataFrame) -> Figure:
    """Log-log errors of all variables against h or tau, with the runs that stopped."""
    columns = {1: 1, 2: 2, 4: 2}.get(len(study.variables), 3)
    rows = -(-len(study.variables) // columns)
    size = (max(5.0, 3.0 * columns), 1.4 + 2.4 * rows if rows > 1 else 4.0)
    figure, axes = plt.subplots(
        rows, columns, figsize=size, sharex=True, layout="constrained", squeeze=False
    )
    for axis, name in zip(axes.flat, study.variables, strict=False):
        _error_panel(axis, study, records, name)
    for axis in axes.flat[len(study.variables) :]:
        axis.remove()
    for axis in axes.flat[max(0, len(study.variables) - columns) : len(study.variables)]:
        axis.set_xlabel(AXES[direction(study)])
        axis.xaxis.set_tick_params(labelbottom=True)
    for axis in axes[:, 0]:
        axis.set_ylabel("error")
    handles, labels = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 6))
    # A title is text: "$x_{$" is no formula.
    width = int(12 * size[0])
    heading = f"{study.study.title}\n{fill(describe(study), width)}\n{fill(norms(study), width)}"
    figure.suptitle(heading, fontsize=9, parse_math=False)
    return figure


def energy_figure(study: Study, records: pd.DataFrame) -> Figure:
    """W_h(T) against h or tau, with the exact value."""
    figure, axis = plt.subplots(figsize=(5.0, 3.8), layout="constrained")
    parameter = direction(study)
    for i, (label, runs, color, marker) in enumerate(_series(study, records)):
        finished = runs[runs["status"] == "ok"]
        look = {"color": color, "marker": marker, "label": label, "gid": series_gid(i, "W")}
        axis.semilogx(finished[parameter], finished["energy_T"], **look)
    exact = known_energy(study)
    if exact is not None:
        axis.axhline(exact, color="black", linestyle="--", linewidth=1, label=f"exact {exact:.4f}")
    _log_ticks(axis, records[parameter])
    axis.set_xlabel(AXES[parameter])
    axis.set_ylabel(r"Willmore energy $W_h(T)$")
    axis.set_title(f"{study.study.title}\nfinal energy", fontsize=9, parse_math=False)
    axis.legend(fontsize=8)
    return figure


def known_energy(study: Study) -> float | None:
    """W(T) of the solution, or of the axisymmetric reference; None if there is neither."""
    solution, T = study.solution.initial(), study.sweep.final_time
    if not isinstance(solution, SurfaceFlow):
        return solution.energy(T)
    if solution.reference != "axisymmetric":
        return None
    law = study.law
    return float(solution.profile_flow(law.name, law.parameters, (0.0, T)).energies[-1])


def series_gid(i: int, what: str) -> str:
    """Name of the group of an SVG that draws what belongs to the i-th series."""
    return f"series-{i}-{what}"


def _error_panel(axis: Axes, study: Study, records: pd.DataFrame, name: str) -> None:
    column = f"err_{name}"
    parameter, claim = direction(study), claims().get(study.study.claim or "")
    exact = records[column].max() < ROUNDING
    for i, (label, runs, color, marker) in enumerate(_series(study, records)):
        finished = runs[runs["status"] == "ok"]
        look = {"color": color, "marker": marker, "label": label, "gid": series_gid(i, name)}
        shown = finished[column].clip(lower=LEAST) if exact else finished[column]
        axis.loglog(finished[parameter], shown, **look)
    # Text of an SVG has no calligraphic letters: matplotlib's own font for them is not on a page.
    symbol = QUANTITIES[name].tex.replace(r"\mathcal{V}", r"\mathrm{vol}")
    axis.set_title(f"${symbol}$", fontsize=10)
    if exact:
        axis.set_ylim(LEAST, 10 * ROUNDING)
        axis.text(0.5, 0.9, "exact up to rounding", ha="center", transform=axis.transAxes)
    elif claim is not None and claim.limit is not None and name in claim.variables:
        axis.axhline(claim.limit, color="black", linestyle="--", linewidth=1.0, label="limit")
    else:
        _slope_triangle(axis, records, parameter, column, _reference_order(study))
    _mark_stopped(axis, study, records, name)
    _log_ticks(axis, records[parameter])


def _mark_stopped(axis: Axes, study: Study, records: pd.DataFrame, name: str) -> None:
    """Crosses in a band above the data, a row a line: stopped runs have no error, but a place."""
    if records["stopped_at"].isna().all():
        return
    lines = _series(study, records)
    rows, spacing = len(lines), 0.045
    low, high = np.log(axis.get_ylim())
    axis.set_ylim(np.exp(low), np.exp(low + (high - low) / (1.0 - spacing * (rows + 0.5))))
    for i, (_, runs, color, _) in enumerate(lines):
        stopped = runs.loc[runs["stopped_at"].notna(), direction(study)]
        height = [1.0 - spacing * (i + 0.75)] * len(stopped)
        look = {"color": color, "gid": series_gid(i, f"{name}-stopped")}
        axis.plot(stopped, height, "x", transform=axis.get_xaxis_transform(), **look)
    axis.plot([], [], "x", color="black", label="stopped early")


def _reference_order(study: Study) -> float:
    claim = claims().get(study.study.claim or "")
    degree, bdf = study.scheme.degree, study.scheme.order
    bounded = claim is None or claim.limit is not None
    return float(degree) if bounded else claim.expected_order(degree, bdf)


def _slope_triangle(
    axis: Axes, records: pd.DataFrame, parameter: str, column: str, order: float
) -> None:
    """A triangle of the given slope below the finest end of the data."""
    finished = records[(records["status"] == "ok") & (records[column] > 0)]
    if finished[parameter].nunique() < 2:
        return
    h0 = finished[parameter].min()
    h1 = min(h0 * 1.6, finished[parameter].max())
    # Below every point over the triangle's own width, so that it crosses no line.
    over = finished[finished[parameter] <= 1.05 * h1]
    e0 = 0.35 * np.min(over[column] * (h0 / over[parameter]) ** order)
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


def _log_ticks(axis: Axes, s: pd.Series) -> None:
    """Ticks at the levels of the sweep that can be read."""
    levels = sorted(s.unique())
    axis.set_xticks(levels[:: max(1, len(levels) // 4)])
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.2g}"))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())


def _series(study: Study, records: pd.DataFrame) -> list[tuple[str, pd.DataFrame, str, str]]:
    """Label, runs, colour and marker of each line."""
    lines = series(records, direction(study))
    return [
        (
            label.replace("tau", r"$\tau$"),
            runs,
            PALETTE[i % len(PALETTE)],
            MARKERS[i % len(MARKERS)],
        )
        for i, (label, runs) in enumerate(lines)
    ]
