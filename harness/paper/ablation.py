"""Ablation on the Clifford torus: theta, projections and BDF order, and where runs diverge."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.paper.evidence import Missing, StudyData, study_data
from harness.paper.extra import Extra, NoData
from harness.plots import STYLE
from harness.words import PROJECTIONS

VARIANTS = tuple(
    f"paper-torus{bdf}{theta}{projection}"
    for bdf in ("", "-bdf2")
    for theta in ("", "-theta")
    for projection in ("", "-unprojected")
)
NAMES = {"ok": "", "diverged": "diverged", "failed": "linear algebra failed"}


def ablation(runs: Path) -> Extra | NoData:
    """The table: a line a variant, on the meshes that all variants have."""
    try:
        found = variants(runs)
    except Missing as missing:
        return NoData(str(missing))
    meshes = sorted(found[0].records["vertices"].unique())
    return Extra(
        title="Ablation on the Clifford torus: theta, projections, BDF",
        text=(
            f"P2, V = {meshes[0]} to {meshes[-1]}, T = {found[0].study.sweep.final_time:g}. How "
            "many runs reach T; the least error of x on the finest mesh over all time steps, and "
            "at which step."
        ),
        table=[ablation_row(data) for data in found],
    )


def variants(runs: Path) -> list[StudyData]:
    """The studies of all variants, on the meshes that all have in common."""
    found = [study_data(runs / name, name) for name in VARIANTS]
    common = set.intersection(*(set(data.records["vertices"]) for data in found))
    return [
        StudyData(data.study, data.records[data.records["vertices"].isin(common)], data.verdicts)
        for data in found
    ]


def ablation_row(data: StudyData) -> dict[str, str | int | float | None]:
    """One line of the table."""
    scheme, records = data.study.scheme, data.records
    counts = records["status"].value_counts()
    finest = data.finished[data.finished["vertices"] == records["vertices"].max()]
    best = None if finest.empty else finest.loc[finest["err_x"].idxmin()]
    return {
        "BDF": scheme.bdf,
        "theta": "yes" if scheme.theta else "no",
        "projection": PROJECTIONS[scheme.project],
        **{status: int(counts.get(status, 0)) for status in NAMES},
        "least error of x": None if best is None else float(f"{best['err_x']:.3g}"),
        "at tau": None if best is None else float(best["tau"]),
    }


def divergence(runs: Path) -> Extra | NoData:
    """The map: which cells of the (h, tau) grids stop early, when, and what that is called."""
    try:
        found = variants(runs)
    except Missing as missing:
        return NoData(str(missing))
    return Extra(
        title="Where runs on the Clifford torus stop early",
        text=(
            "Each cell is a run; its colour and number are the time at which it stopped, white is "
            "a run that reached T. f marks runs whose linear algebra failed, all others diverged. "
            "The table names them."
        ),
        table=[row for data in found for row in stopped_rows(data)],
        figure=figure(found),
        alt="Maps of mesh sizes and time steps, with the time at which each run stopped",
    )


def stopped_rows(data: StudyData) -> list[dict[str, str | float | int]]:
    """A line a time step and name of the end: on which meshes, and when."""
    stopped = data.records[data.records["status"].isin([s for s in NAMES if NAMES[s]])]
    rows = []
    for (tau, status), runs in stopped.groupby(["tau", "status"], sort=False):
        ends = [f"{r.vertices} (t = {r.stopped_at:.3g})" for r in runs.itertuples()]
        named = {"study": data.study.name, "tau": float(tau), "end": NAMES[status]}
        rows.append({**named, "runs": len(runs), "V (stopped at)": ", ".join(ends)})
    return sorted(rows, key=lambda row: -row["tau"])


def figure(found: list[StudyData]) -> Figure:
    """A map a variant: BDF1 above BDF2."""
    with plt.rc_context({**STYLE, "axes.grid": False}):
        columns = len(found) // 2
        size = (2.75 * columns + 0.8, 6.2)
        drawn, axes = plt.subplots(
            2, columns, figsize=size, layout="constrained", sharex=True, sharey=True
        )
        for axis, data in zip(axes.flat, found, strict=True):
            image = panel(axis, data)
        for axis in axes[-1]:
            axis.set_xlabel("vertices $V$")
        for axis in axes[:, 0]:
            axis.set_ylabel(r"time step $\tau$")
        drawn.colorbar(image, ax=axes, shrink=0.6, label="$t$ at which the run stopped")
    return drawn


def panel(axis: Axes, data: StudyData) -> plt.cm.ScalarMappable:
    """The map of one variant."""
    scheme = data.study.scheme
    stopped = grid(data.records, "stopped_at")
    status = grid(data.records, "status")
    colours = plt.get_cmap("cividis").with_extremes(bad="white")
    T = data.study.sweep.final_time
    image = axis.imshow(stopped.to_numpy(float), cmap=colours, vmin=0, vmax=T, aspect="auto")
    for i, j in np.argwhere(stopped.notna().to_numpy()):
        t = stopped.iloc[i, j]
        text = f"{t:.2f}".removeprefix("0") + ("f" if status.iloc[i, j] == "failed" else "")
        colour = "black" if t > 0.5 * T else "white"
        axis.text(j, i, text, ha="center", va="center", color=colour, fontsize=6.5)
    axis.set_xticks(range(stopped.shape[1]), stopped.columns)
    axis.set_yticks(range(stopped.shape[0]), [f"{tau:.4g}" for tau in stopped.index])
    words = [f"BDF{scheme.bdf}", r"$\vartheta$" if scheme.theta else r"no $\vartheta$"]
    words.append(f"projection {PROJECTIONS[scheme.project]}")
    axis.set_title(", ".join(words), fontsize=9)
    return image


def grid(records: pd.DataFrame, column: str) -> pd.DataFrame:
    """The column over time steps, largest first, and meshes."""
    table = records.pivot(index="tau", columns="vertices", values=column)
    return table.sort_index(ascending=False)
