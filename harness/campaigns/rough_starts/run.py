"""Orders in time at a rough start, measured and written.

Writes orders.csv with a line a run, table.md, the figure orders.svg and .pdf, and origin.json.
"""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, NullLocator
from rich.console import Console
from tabulate import tabulate

from esfem.campaigns.contest.extras import computed
from esfem.campaigns.rough_starts import methods as runs
from esfem.campaigns.rough_starts.methods import FASTEST, METHODS, RATES, measured
from esfem.common.drawing import LINES, legend_below, save_figure, series_look, styled, subplots
from esfem.common.files import writable_folder, write_json, write_text
from esfem.common.provenance import environment, provenance_line

# Differences of H below this are those of the layer of the mesh itself, at its own rates.
FLOOR = 2e-6


def run_rough_starts(out: Path, jobs: int, console: Console) -> None:
    """Compute all runs and write what is made from them."""
    began = perf_counter()
    writable_folder(out)
    items = [(method,) for method in METHODS]
    found = pd.concat(computed(measured, items, jobs, console, "runs"), ignore_index=True)
    write(found, out, perf_counter() - began)
    cpu = found["cpu_seconds"].sum()
    console.print(f"{len(found)} runs, {cpu:.0f} CPU seconds; written to {out}")


def write(found: pd.DataFrame, out: Path, seconds: float) -> None:
    """All files from the rows of `esfem.campaigns.rough_starts.methods.measured`."""
    write_text(out / "orders.csv", found.to_csv(index=False, float_format="%.8g"))
    write_text(out / "table.md", table(found))
    save_figure(figure(found), out / "orders.svg", "rough starts")
    origin = {
        "title": "Order in tau at a rough start, with and without divided first steps",
        "by": provenance_line(),
        "parameters": {
            "law": runs.LAW.model_dump(),
            "solution": runs.SURFACE.model_dump(),
            "degree": runs.DEGREE,
            "vertices": runs.VERTICES,
            "reaction": runs.REACTION,
            "final_time": runs.T,
            "energy": runs.ENERGY,
            "rates": RATES,
            "methods": [asdict(method) for method in METHODS],
        },
        "environment": environment(),
        "seconds": round(seconds, 1),
        "cpu_seconds": round(float(found["cpu_seconds"].sum()), 1),
    }
    write_json(out / "origin.json", origin)


def table(found: pd.DataFrame) -> str:
    """Markdown: a line a method; errors of the energy, and orders in tau of H."""
    rows = []
    for (q, m, stretch, theta), own in lines(found):
        taus = [f"{tau:.3g}" for tau in own["tau"]]
        error = dict(zip(taus, own["error_E"], strict=True))
        order = dict(zip(taus, trusted(own), strict=True))
        name = f"BDF{q}, m = {m}" + (f", first {stretch} q steps" if stretch > 1 else "")
        row = {"method": name + ("" if theta else ", theta off")}
        row |= {f"error of E, tau = {tau}": f"{error[tau]:+.1e}" for tau in taus[:7:2]}
        row |= {f"order, {tau}": number(order[tau]) for tau in taus[1:-2]}
        rows.append(row)
    return tabulate(rows, headers="keys", tablefmt="pipe", disable_numparse=True) + "\n"


def trusted(own: pd.DataFrame) -> pd.Series:
    """The orders of H of a method, NaN where a difference that they come from is at the floor."""
    return own["order_H"].where(own["difference_H"].shift(-1) > FLOOR)


def number(order: float) -> str:
    """An order for eyes."""
    return "-" if np.isnan(order) else f"{order:.1f}"


def lines(found: pd.DataFrame) -> list[tuple[tuple[Any, ...], pd.DataFrame]]:
    """The runs of each method."""
    return list(found.groupby(["q", "first_steps", "stretch", "theta"], sort=False))


@styled()
def figure(found: pd.DataFrame) -> Figure:
    """A column a BDF: above the difference of H for tau and tau / 2, below its order in tau."""
    orders = sorted(found["q"].unique())
    drawn, axes = subplots(2, len(orders), (9.6, 5.2), sharex=True, sharey="row")
    for column, q in zip(axes.T, orders, strict=True):
        for i, ((_, m, stretch, theta), own) in enumerate(lines(found[found["q"] == q])):
            if theta:
                draw(column, own, i, label_of(m, stretch))
        column[0].set_title(f"BDF{q}")
        column[0].axhspan(1e-7, FLOOR, color="0.92")
        column[0].set_ylim(1.5e-7, 6e-2)
        column[1].axhline(q, color="black", linewidth=0.9, linestyle=":")
        column[1].set_xlabel(r"$\tau\lambda_6$")
        column[1].set_ylim(-0.6, 4.4)
        for axis in column:
            scaled(axis)
    named_rates(axes[0, 0])
    axes[0, 0].set_ylabel(r"$\|H_\tau - H_{\tau/2}\|_{L^2}$ at $t = 0.1$")
    axes[1, 0].set_ylabel(r"order in $\tau$")
    legend_below(drawn, axes[0, -1], most=8)
    return drawn


def label_of(m: int, stretch: int) -> str:
    """What a line is, in the legend."""
    return f"$m = {m}$" if stretch == 1 else f"$m = {m}$, first ${stretch}q$ steps"


def draw(column: Sequence[Axes], own: pd.DataFrame, i: int, label: str) -> None:
    """One method: differences above, orders below, these where they are above the floor."""
    look = {**series_look(i), "linestyle": LINES[i % len(LINES)]}
    column[0].loglog(own["tau_rate"], own["difference_H"], label=label, **look)
    column[1].semilogx(own["tau_rate"], trusted(own), **look)


def scaled(axis: Axes) -> None:
    """Ticks at powers of ten, and lines where tau is the time of the modes 4 and 6."""
    for rate in RATES.values():
        axis.axvline(FASTEST / rate, color="0.6", linewidth=0.8)
    axis.set_xticks([1, 10], ["1", "10"])
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.xaxis.set_minor_locator(NullLocator())
    axis.set_xlim(0.2, 50)


def named_rates(axis: Axes) -> None:
    """What the lines of `scaled` are."""
    across = axis.get_xaxis_transform()
    look: dict[str, Any] = {"fontsize": 7, "color": "0.35", "rotation": 90, "ha": "right"}
    for l, rate in RATES.items():
        name = rf"$\tau\lambda_{l} = 1$"
        axis.text(0.94 * FASTEST / rate, 0.03, name, transform=across, **look)
