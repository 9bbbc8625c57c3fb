"""The figures of a report: those of a study with fits and masked runs, and those of a flow."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from esfem.common.drawing import PALETTE, styled, subplots
from esfem.flows.flow_results import FlowResult
from esfem.flows.history import History
from esfem.flows.pictures import energy_figure as flow_energy_figure
from esfem.results.plots import energy_figure, error_figure
from esfem.results.study_result import StudyResult
from esfem.results.verdicts import Verdict

MOST_LEVELS = 300  # of a history: more cannot be told apart in a figure
FIT = "0.15"


def study_figures(result: StudyResult) -> dict[str, tuple[Figure, str]]:
    """The figures of a study by name, each with what it shows in words."""
    title = result.study.title
    return {
        "errors": (
            fitted_figure(result),
            f"{title}: errors of {', '.join(result.study.variables)}, with the judged fits, "
            "their intervals, and masked runs",
        ),
        "energy": (
            energy_figure(result),
            f"{title}: {result.study.law.energy} at the final time",
        ),
    }


@styled()
def fitted_figure(result: StudyResult) -> Figure:
    """The errors of a study, with the fit, its interval and the masked runs of each variable."""
    figure = error_figure(result)
    for axis, verdict in zip(figure.axes, result.verdicts, strict=True):
        _mask(axis, verdict, result.records)
        _fit(axis, verdict, result.records)
    _explain(figure)
    figure.suptitle("")  # the section tells what it is
    return figure


def fitted_points(verdict: Verdict, records: pd.DataFrame) -> pd.DataFrame:
    """The judged runs: columns s (h or tau), error, and the fan ``low`` .. ``high`` of the interval
    about the middle of the fit; no rows where nothing was fitted."""
    runs = records[records["status"].eq("ok") & records["vertices"].isin(verdict.vertices)]
    runs = runs[runs["tau"].isin(verdict.tau)].sort_values(verdict.direction)
    s = runs[verdict.direction].to_numpy(float)
    if len(s) < 2 or not np.isfinite([verdict.observed, verdict.constant, verdict.lower]).all():
        return pd.DataFrame(columns=["s", "error", "low", "high"], dtype=float)
    middle = np.exp(np.log(s).mean())
    fitted = verdict.constant * middle**verdict.observed
    fan = [fitted * (s / middle) ** order for order in (verdict.lower, verdict.upper)]
    error = verdict.constant * s**verdict.observed
    return pd.DataFrame({"s": s, "error": error, "low": fan[0], "high": fan[1]})


def masked_points(verdict: Verdict, records: pd.DataFrame) -> pd.DataFrame:
    """The runs that ended but were not judged: columns s, error."""
    masked = pd.DataFrame([(m.h, m.tau) for m in verdict.masked], columns=["h", "tau"])
    runs = records[records["status"] == "ok"].merge(masked.drop_duplicates(), on=["h", "tau"])
    column = verdict.deciding.column(verdict.variable)
    return pd.DataFrame({"s": runs[verdict.direction], "error": runs[column]})


def _fit(axis: Axes, verdict: Verdict, records: pd.DataFrame) -> None:
    points = fitted_points(verdict, records)
    if len(points):
        axis.fill_between(points["s"], points["low"], points["high"], color=FIT, alpha=0.15, lw=0)
        axis.plot(points["s"], points["error"], ":", color=FIT, lw=1.6, label="_fit")


def _mask(axis: Axes, verdict: Verdict, records: pd.DataFrame) -> None:
    points = masked_points(verdict, records)
    if len(points):
        look: dict[str, Any] = {"mfc": "white", "mec": "0.45", "ms": 3.0, "label": "_masked"}
        axis.plot(points["s"], points["error"], "o", **look)


def _explain(figure: Figure) -> None:
    """Fit and masked runs in the legend, if any panel has them."""
    shown = {line.get_label(): line for axis in figure.axes for line in axis.get_lines()}
    (legend,) = figure.legends
    words = {"_fit": "fit, interval", "_masked": "masked"}
    extra = {text: shown[name] for name, text in words.items() if name in shown}
    handles = [*filter(None, legend.legend_handles), *extra.values()]
    labels = [*(text.get_text() for text in legend.get_texts()), *extra]
    legend.remove()
    lines = -(-len(labels) // 6)
    figure.legend(handles, labels, loc="outside lower center", ncols=-(-len(labels) // lines))


def flow_figures(result: FlowResult) -> dict[str, tuple[Figure, str]]:
    """The figures of a flow by name, each with what it shows in words."""
    history, title = thinned(result.history), result.flow.flow.title
    energy = flow_energy_figure(result.flow, history)
    energy.suptitle("")  # the section tells what it is
    return {
        "energy": (energy, f"{title}: {history.energy} along t"),
        "quality": (
            quality_figure(history),
            f"{title}: lengths of the normals, least area element and largest speed along t",
        ),
    }


def thinned(history: History) -> History:
    """At most so many levels, denser at the start where a flow is fast; first and last are kept."""
    last = len(history.rows) - 1
    kept = np.unique(np.round(last * np.linspace(0.0, 1.0, MOST_LEVELS) ** 2).astype(int))
    short = History(history.energy)
    short.rows = [history.rows[n] for n in kept]
    return short


@styled()
def quality_figure(history: History) -> Figure:
    """Lengths of the nodal normals, least area element and largest speed along t."""
    figure, axes = subplots(1, 3, (8.4, 2.5))
    t = history.column("t")
    panels: list[tuple[tuple[str, ...], str, Callable[..., Any]]] = [
        (("least_normal", "greatest_normal"), r"least and greatest $|\nu_h|$", axes[0].plot),
        (("least_area_element",), "least / mean area element", axes[1].plot),
        (("speed",), r"$\max |V_h|$", axes[2].semilogy),
    ]
    for axis, (names, heading, draw) in zip(axes, panels, strict=True):
        for name, colour, line in zip(names, PALETTE, ("-", "--"), strict=False):
            draw(t, history.column(name), line, color=colour)
        axis.set_title(heading, fontsize=9)
        axis.set_xlabel("$t$")
        axis.ticklabel_format(axis="x", useOffset=False)
    axes[1].set_ylim(0.0, None)
    return figure
