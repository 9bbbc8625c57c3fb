"""The paper's figures of convergence: errors of x, nu, H and W_h(T) against h, a line a step."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from esfem.campaigns.paper.sources import StudyData, study_data
from esfem.common.drawing import (
    legend_below,
    level_ticks,
    series_look,
    stopped_crosses,
    styled,
    subplots,
)
from esfem.report.extra import Extra
from esfem.results.plots import AXES, known_energies
from esfem.results.study_result import series
from esfem.results.verdicts import Verdict
from esfem.studies.quantities import QUANTITIES
from esfem.studies.words import describe

SHOWN = ("x", "nu", "H")  # the variables of the paper's figures
ROW = 0.0155  # of the height: a row of the band of stopped runs


def convergence(runs: Path, name: str) -> Extra:
    """The figure of that study, and what the judge says of its variables."""
    data = study_data(runs / name, name)
    stopped = data.records["stopped_at"].notna().sum()
    return Extra(
        title=data.study.title,
        text=(
            f"{describe(data.study)}. Errors in L-infinity(0,T; H^1) and W at the final time "
            f"against the mesh width. {stopped} of {len(data.records)} runs stopped early: "
            "crosses in the band on top, at their mesh width."
        ),
        table=[order_row(v) for v in data.verdicts if v.variable in SHOWN],
        figure=figure(data),
        alt=f"Errors and energy against the mesh width: {data.study.title}",
    )


def order_row(verdict: Verdict) -> dict[str, str | float | None]:
    """What the judge says of one variable."""
    return {
        "variable": verdict.variable,
        "order": round(verdict.observed, 3),
        "from": round(verdict.lower, 3),
        "to": round(verdict.upper, 3),
        "at tau": verdict.tau[-1] if verdict.tau else None,
        "claimed": verdict.expected,
        "verdict": verdict.verdict.upper(),
        "reason": verdict.reason,
    }


@styled()
def figure(data: StudyData) -> Figure:
    """Four panels in a row, as in the paper."""
    drawn, axes = subplots(1, len(SHOWN) + 1, (11.5, 3.6))
    lines = series(data.records, "h")
    for axis, name in zip(axes, SHOWN, strict=False):
        draw(axis.loglog, lines, f"err_{name}")
        axis.set_title(f"error of ${QUANTITIES[name].tex}$")
        reference_line(axis, data, f"err_{name}")
    draw(axes[-1].semilogx, lines, "willmore_T")
    exact = known_energies(data.study)["willmore_T"]
    axes[-1].axhline(exact, color="0.4", linestyle="--", linewidth=1)
    axes[-1].set_title(f"$W_h(T)$ (dashed: exact {exact:.4f})")
    for axis in axes:
        stopped_crosses(axis, [line.loc[line["stopped_at"].notna(), "h"] for _, line in lines], ROW)
        axis.set_xlabel(AXES["h"])
        level_ticks(axis, sorted(data.records["h"].unique())[::2])
    legend_below(drawn, axes[0], most=5)
    return drawn


def draw(plot: Callable[..., object], lines: list[tuple[str, pd.DataFrame]], column: str) -> None:
    """The column against h, a line a time step, of the runs that finished."""
    for i, (label, line) in enumerate(lines):
        finished = line[line["status"] == "ok"]
        label = label.replace("tau", r"$\tau$")
        plot(finished["h"], finished[column], label=label, **series_look(i))


def reference_line(axis: Axes, data: StudyData, column: str) -> None:
    """O(h^k), below all errors."""
    finished, k = data.finished[data.finished[column] > 0], data.study.scheme.degree
    if finished.empty:
        return
    h = np.array([data.records["h"].min(), data.records["h"].max()])
    constant = 0.5 * float((finished[column] / finished["h"] ** k).min())
    axis.loglog(h, constant * h**k, "--", color="0.4", linewidth=1, label=f"$O(h^{k})$")
