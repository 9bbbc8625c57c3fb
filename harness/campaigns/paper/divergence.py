"""Where the runs of the paper's grid on the Clifford torus stop early, with BDF1 and with BDF2."""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from esfem.campaigns.paper.sources import StudyData, study_data
from esfem.common.drawing import labelled_map, styled, subplots
from esfem.report.extra import Extra

STUDIES = ("paper-torus", "paper-torus-bdf2")
NAMES = {"ok": "", "diverged": "diverged", "failed": "linear algebra failed"}


def divergence(runs: Path) -> Extra:
    """The maps: which cells of the (h, tau) grids stop early, when, and what that is called."""
    found = [study_data(runs / name, name) for name in STUDIES]
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


@styled({"axes.grid": False})
def figure(found: list[StudyData]) -> Figure:
    """A map a study, side by side."""
    drawn, axes = subplots(1, len(found), (4.2 * len(found) + 0.8, 3.6))
    for axis, data in zip(axes, found, strict=True):
        image = panel(axis, data)
        axis.set_xlabel("vertices $V$")
    axes[0].set_ylabel(r"time step $\tau$")
    drawn.colorbar(image, ax=axes, shrink=0.8, label="$t$ at which the run stopped")
    return drawn


def panel(axis: Axes, data: StudyData) -> ScalarMappable:
    """The map of one study."""
    table = grid(data.records, "stopped_at")
    stopped, failed = table.to_numpy(float), (grid(data.records, "status") == "failed").to_numpy()
    T = data.study.sweep.final_time
    image = labelled_map(
        axis,
        stopped,
        np.vectorize(_told)(stopped, failed),
        "cividis",
        Normalize(0, T),
        on_dark=stopped <= 0.5 * T,
    )
    axis.set_xticks(range(table.shape[1]), table.columns)
    axis.set_yticks(range(table.shape[0]), [f"{tau:.4g}" for tau in table.index])
    axis.set_title(f"BDF{data.study.scheme.bdf}", fontsize=9)
    return image


def _told(t: float, failed: bool) -> str:
    """The time of a stop, and whether linear algebra failed; "" where a run reached T."""
    return "" if np.isnan(t) else f"{t:.2f}".removeprefix("0") + "f" * failed


def grid(records: pd.DataFrame, column: str) -> pd.DataFrame:
    """The column over time steps, largest first, and meshes."""
    table = records.pivot(index="tau", columns="vertices", values=column)
    return table.sort_index(ascending=False)
