"""Where the runs of the paper's grid on the Clifford torus stop early, with BDF1 and with BDF2."""

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

STUDIES = ("paper-torus", "paper-torus-bdf2")
NAMES = {"ok": "", "diverged": "diverged", "failed": "linear algebra failed"}


def divergence(runs: Path) -> Extra | NoData:
    """The maps: which cells of the (h, tau) grids stop early, when, and what that is called."""
    try:
        found = [study_data(runs / name, name) for name in STUDIES]
    except Missing as missing:
        return NoData(str(missing))
    return Extra(
        title="Where runs on the Clifford torus stop early",
        text=(
            "Each cell is a run; its colour and number are the time at which it stopped, white is "
            "a run that reached T. f marks runs whose linear algebra failed, all "
            "others diverged. The table names them."
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
    """A map a study, side by side."""
    with plt.rc_context({**STYLE, "axes.grid": False}):
        size = (4.2 * len(found) + 0.8, 3.6)
        drawn, axes = plt.subplots(1, len(found), figsize=size, layout="constrained")
        for axis, data in zip(axes, found, strict=True):
            image = panel(axis, data)
            axis.set_xlabel("vertices $V$")
        axes[0].set_ylabel(r"time step $\tau$")
        drawn.colorbar(image, ax=axes, shrink=0.8, label="$t$ at which the run stopped")
    return drawn


def panel(axis: Axes, data: StudyData) -> plt.cm.ScalarMappable:
    """The map of one study."""
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
    axis.set_title(f"BDF{data.study.scheme.bdf}", fontsize=9)
    return image


def grid(records: pd.DataFrame, column: str) -> pd.DataFrame:
    """The column over time steps, largest first, and meshes."""
    table = records.pivot(index="tau", columns="vertices", values=column)
    return table.sort_index(ascending=False)
