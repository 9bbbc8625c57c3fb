"""The paper's figures of convergence: errors of x, nu, H and W_h(T) against h, a line a step."""

from functools import partial
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from harness.paper.evidence import Missing, StudyData, study_data
from harness.paper.extra import Extra, Maker, NoData
from harness.plots import AXES, MARKERS, PALETTE, STYLE, known_energies
from harness.quantities import QUANTITIES
from harness.series import series
from harness.words import describe

SHOWN = ("x", "nu", "H")  # the variables of the paper's figures
BAND, ROW = 0.86, 0.0155  # of the height: where the band of stopped runs begins, and its rows


def convergence(name: str) -> Maker:
    """What makes the figure of that study."""
    return partial(_convergence, name=name)


def _convergence(runs: Path, name: str) -> Extra | NoData:
    try:
        data = study_data(runs / name, name)
    except Missing as missing:
        return NoData(str(missing))
    stopped = data.records["stopped_at"].notna().sum()
    return Extra(
        title=data.study.title,
        text=(
            f"{describe(data.study)}. Errors in L-infinity(0,T; H^1) and W at the final time "
            f"against the mesh width. {stopped} of {len(data.records)} runs stopped early: "
            "crosses in the band on top, at their mesh width."
        ),
        table=[order_row(v) for v in data.verdicts if v["variable"] in SHOWN],
        figure=figure(data),
        alt=f"Errors and energy against the mesh width: {data.study.title}",
    )


def order_row(verdict: dict) -> dict[str, str | float | None]:
    """What the judge says of one variable."""
    rounded = {key: _rounded(verdict[key]) for key in ("observed", "lower", "upper")}
    taus = verdict["tau"]
    tau = taus[-1] if taus else None
    return {
        "variable": verdict["variable"],
        **{"order": rounded["observed"], "from": rounded["lower"], "to": rounded["upper"]},
        **{"at tau": tau, "claimed": verdict["expected"], "verdict": verdict["verdict"].upper()},
        "reason": verdict["reason"],
    }


def figure(data: StudyData) -> Figure:
    """Four panels in a row, as in the paper."""
    with plt.rc_context(STYLE):
        drawn, axes = plt.subplots(1, len(SHOWN) + 1, figsize=(11.5, 3.6), layout="constrained")
        lines = series(data.records, "h")
        for axis, name in zip(axes, SHOWN, strict=False):
            for i, (label, line) in enumerate(lines):
                finished = line[line["status"] == "ok"]
                axis.loglog(finished["h"], finished[f"err_{name}"], **look(i, label))
            axis.set_title(f"error of ${QUANTITIES[name].tex}$")
            reference_line(axis, data, f"err_{name}")
            finish(axis, data.records, lines)
        energy_panel(axes[-1], data, lines)
        handles, labels = axes[0].get_legend_handles_labels()
        drawn.legend(handles, labels, loc="outside lower center", ncols=5)
    return drawn


def look(i: int, label: str) -> dict[str, str]:
    """Colour, marker and label of the i-th line."""
    text = label.replace("tau", r"$\tau$")
    return {
        "color": PALETTE[i % len(PALETTE)],
        "marker": MARKERS[i % len(MARKERS)],
        "label": text,
    }


def reference_line(axis: Axes, data: StudyData, column: str) -> None:
    """O(h^k), below all errors."""
    finished, k = data.finished[data.finished[column] > 0], data.study.scheme.degree
    if finished.empty:
        return
    h = np.array([data.records["h"].min(), data.records["h"].max()])
    constant = 0.5 * float((finished[column] / finished["h"] ** k).min())
    axis.loglog(h, constant * h**k, "--", color="0.4", linewidth=1, label=f"$O(h^{k})$")


def energy_panel(axis: Axes, data: StudyData, lines: list[tuple[str, pd.DataFrame]]) -> None:
    """W_h(T), semi-logarithmic, with the exact value."""
    for i, (label, line) in enumerate(lines):
        finished = line[line["status"] == "ok"]
        axis.semilogx(finished["h"], finished["willmore_T"], **look(i, label))
    exact = known_energies(data.study)["willmore_T"]
    axis.axhline(exact, color="0.4", linestyle="--", linewidth=1)
    axis.set_title(f"$W_h(T)$ (dashed: exact {exact:.4f})")
    finish(axis, data.records, lines)


def finish(axis: Axes, records: pd.DataFrame, lines: list[tuple[str, pd.DataFrame]]) -> None:
    """The band of crosses on top, and ticks at mesh widths."""
    if records["stopped_at"].notna().any():
        make_room(axis)
        for i, (_, line) in enumerate(lines):
            h = line.loc[line["stopped_at"].notna(), "h"]
            height = [1.0 - ROW * (i + 0.75)] * len(h)
            crosses = {"color": look(i, "")["color"], "markersize": 3}
            axis.plot(h, height, "x", transform=axis.get_xaxis_transform(), **crosses)
        axis.plot([], [], "x", color="black", label="stopped early")
    axis.set_xlabel(AXES["h"])
    axis.xaxis.set_major_locator(FixedLocator(sorted(records["h"].unique())[::2]))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.2g}"))
    axis.xaxis.set_minor_locator(NullLocator())


def make_room(axis: Axes) -> None:
    """Stretch the axis upwards, so that its data end below the band."""
    low, high = axis.get_ylim()
    if axis.get_yscale() == "log":
        low, high = np.log(low), np.log(high)
        axis.set_ylim(np.exp(low), np.exp(low + (high - low) / BAND))
    else:
        axis.set_ylim(low, low + (high - low) / BAND)


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 3)
