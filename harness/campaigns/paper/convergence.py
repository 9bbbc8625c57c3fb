"""The paper's figures of convergence: errors of x, nu, H and W_h(T) against h, a line a step, both
u_h - u and u_h - I_h u, as the paper does not say which it shows; and where the runs of its grid on
the Clifford torus stop early, with BDF1 and with BDF2."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from esfem.campaigns.paper.stored_results import Row, finished, stored_study
from esfem.common.drawing import (
    labelled_map,
    legend_below,
    level_ticks,
    series_look,
    stopped_crosses,
    styled,
    subplots,
)
from esfem.report.extra import Extra
from esfem.results.error_verdicts import PREFIXES, ErrorName, ErrorVerdict
from esfem.results.plots import AXES, known_energies
from esfem.results.study_result import StudyResult, series
from esfem.results.tables import SYMBOLS
from esfem.results.verdicts import Verdict
from esfem.studies.quantities import QUANTITIES
from esfem.studies.words import describe

SHOWN = ("x", "nu", "H")  # the variables of the paper's figures
TEX: dict[ErrorName, str] = {"error": "u_h - u", "interpolation": "u_h - I_h u"}
ROW = 0.0155  # of the height: a row of the band of stopped runs
ON_TORUS = ("paper-torus", "paper-torus-bdf2")
STOPS = {"diverged": "diverged", "failed": "linear algebra failed"}


def convergence(runs: Path, name: str) -> Extra:
    """The figure of that study, and what the judge says of its variables."""
    result = stored_study(runs / name, name)
    stopped = result.records["stopped_at"].notna().sum()
    return Extra(
        title=result.study.title,
        text=(
            f"{describe(result.study)}. Errors u_h - u, below them u_h - I_h u, in "
            f"L-infinity(0,T; H^1){_unit(result)}, and W at the final time against the mesh width. "
            f"{stopped} of {len(result.records)} runs stopped early: "
            "crosses in the band on top, at their mesh width."
        ),
        table=[order_row(v, p) for v in result.verdicts if v.variable in SHOWN for p in v.parts],
        figure=error_figure(result),
        alt=f"Errors and energy against the mesh width: {result.study.title}",
    )


def _unit(result: StudyResult) -> str:
    """The unit of length of the norms, where the claim has one."""
    length = result.study.claimed_length
    return "" if length is None else f" with unit of length {length:g}"


def order_row(verdict: Verdict, part: ErrorVerdict) -> Row:
    """What the judge says of one error of a variable."""
    return {
        "variable": verdict.variable,
        "error": SYMBOLS[part.name],
        "order": round(part.observed, 3),
        "from": round(part.lower, 3),
        "to": round(part.upper, 3),
        "at tau": part.tau[-1] if part.tau else None,
        "claimed": verdict.expected,
        "verdict": part.outcome.upper(),
        "reason": part.reason,
    }


@styled()
def error_figure(result: StudyResult) -> Figure:
    """Four panels in a row, as in the paper; below them the errors against the interpolation, if
    they were measured."""
    measured = [e for e in PREFIXES if f"{PREFIXES[e]}{SHOWN[0]}" in result.records]
    drawn, axes = subplots(
        len(measured), len(SHOWN) + 1, (11.5, 3.3 * len(measured)), squeeze=False
    )
    lines = [line for _, line in series(result.records, "h")]
    for row, error in zip(axes, measured, strict=True):
        for axis, name in zip(row, SHOWN, strict=False):
            column = f"{PREFIXES[error]}{name}"
            draw(axis.loglog, lines, column)
            axis.set_title(f"${QUANTITIES[name].tex}$: ${TEX[error]}$")
            reference_line(axis, result, column)
    energy = axes[0, -1]
    draw(energy.semilogx, lines, "willmore_T")
    exact = known_energies(result.study)["willmore_T"]
    energy.axhline(exact, color="0.4", linestyle="--", linewidth=1)
    energy.set_title(f"$W_h(T)$ (dashed: exact {exact:.4f})")
    for axis in axes[1:, -1]:
        axis.set_visible(False)
    for axis in [axis for axis in axes.flat if axis.get_visible()]:
        stopped_crosses(axis, [line.loc[line["stopped_at"].notna(), "h"] for line in lines], ROW)
        axis.set_xlabel(AXES["h"])
        level_ticks(axis, sorted(result.records["h"].unique())[::2])
    legend_below(drawn, axes[0, 0], most=5)
    return drawn


def draw(plot: Callable[..., object], lines: list[pd.DataFrame], column: str) -> None:
    """The column against h, a line a time step, of the runs that finished."""
    for i, line in enumerate(lines):
        ended, label = line[line["status"] == "ok"], rf"$\tau$ = {line['tau'].iloc[0]:g}"
        plot(ended["h"], ended[column], label=label, **series_look(i))


def reference_line(axis: Axes, result: StudyResult, column: str) -> None:
    """O(h^k), below all errors."""
    above, k = finished(result).query(f"{column} > 0"), result.study.scheme.degree
    if above.empty:
        return
    h = np.array([result.records["h"].min(), result.records["h"].max()])
    constant = 0.5 * float((above[column] / above["h"] ** k).min())
    axis.loglog(h, constant * h**k, "--", color="0.4", linewidth=1, label=f"$O(h^{k})$")


def stopped_early(runs: Path) -> Extra:
    """The maps: which cells of the (h, tau) grids stop early, when, and what that is called."""
    found = [stored_study(runs / name, name) for name in ON_TORUS]
    return Extra(
        title="Where runs on the Clifford torus stop early",
        text=(
            "Each cell is a run; its colour and number are the time at which it stopped, white is "
            "a run that reached T. f marks runs whose linear algebra failed, all "
            "others diverged. The table names them."
        ),
        table=[row for result in found for row in stopped_rows(result)],
        figure=stop_figure(found),
        alt="Maps of mesh sizes and time steps, with the time at which each run stopped",
    )


def stopped_rows(result: StudyResult) -> list[Row]:
    """A line a time step and name of the end: on which meshes, and when."""
    stopped = result.records[result.records["status"].isin(STOPS)]
    rows: list[dict[str, Any]] = []
    for (tau, status), runs in stopped.groupby(["tau", "status"], sort=False):
        ends = [f"{r.vertices} (t = {r.stopped_at:.3g})" for r in runs.itertuples()]
        named = {"study": result.study.name, "tau": float(tau), "end": STOPS[status]}
        rows.append({**named, "runs": len(runs), "V (stopped at)": ", ".join(ends)})
    return sorted(rows, key=lambda row: -row["tau"])


@styled({"axes.grid": False})
def stop_figure(found: list[StudyResult]) -> Figure:
    """A map a study, side by side."""
    drawn, axes = subplots(1, len(found), (4.2 * len(found) + 0.8, 3.6))
    images = [stop_map(axis, result) for axis, result in zip(axes, found, strict=True)]
    axes[0].set_ylabel(r"time step $\tau$")
    drawn.colorbar(images[-1], ax=axes, shrink=0.8, label="$t$ at which the run stopped")
    return drawn


def stop_map(axis: Axes, result: StudyResult) -> ScalarMappable:
    """The map of one study: time steps, largest first, over meshes."""
    table = result.records.pivot(
        index="tau", columns="vertices", values=["stopped_at", "status"]
    ).sort_index(ascending=False)
    stopped, T = table["stopped_at"].to_numpy(float), result.study.sweep.final_time
    texts = np.vectorize(_told)(stopped, (table["status"] == "failed").to_numpy())
    image = labelled_map(axis, stopped, texts, "cividis", Normalize(0, T), stopped <= 0.5 * T)
    axis.set_xticks(range(stopped.shape[1]), table["status"].columns)
    axis.set_yticks(range(len(table)), [f"{tau:.4g}" for tau in table.index])
    axis.set_title(f"BDF{result.study.scheme.order}", fontsize=9)
    axis.set_xlabel("vertices $V$")
    return image


def _told(t: float, failed: bool) -> str:
    """The time of a stop, and whether linear algebra failed; "" where a run reached T."""
    return "" if np.isnan(t) else f"{t:.2f}".removeprefix("0") + "f" * failed
