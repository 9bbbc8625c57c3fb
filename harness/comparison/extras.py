"""The comparison of the schemes, written as extras of the report."""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from rich.console import Console
from tabulate import tabulate

from harness.bad_input import BadInput
from harness.comparison.figure import GROUND, LADDER, ladders, save_cost_figure
from harness.comparison.stability import LARGEST, STEPS
from harness.comparison.tables import (
    DECAY_TAU,
    ORDER_TAU,
    ORDER_TIME,
    Row,
    comparison,
    costs,
    orders,
)
from harness.comparison.words import sentences
from harness.files import write_text
from harness.provenance import provenance_line
from harness.store import writable_folder

V, TAU, TIME = 240, 2.5e-4, 0.01  # of the comparison: one mesh and step for all
V_STABLE = 120
COST_TAU, COST_STEPS = 1e-4, 8


def compare_schemes(out: Path, console: Console, only: str | None = None) -> None:
    """Compute the comparison and write ``OUT/extra/schemes-*.json`` with its figure.

    Raises
    ------
    BadInput
        If nothing can be written there, or there is no such part.
    """
    if only not in (None, *PARTS):
        raise BadInput(f"--only {only}: must be one of {', '.join(PARTS)}")
    folder = writable_folder(out, "extra") / "extra"
    for part, write in PARTS.items():
        if only in (None, part):
            write(folder, console)


@cache
def prices() -> list[Row]:
    """Seconds a step, measured once for the table and the sentences."""
    return costs(COST_TAU, COST_STEPS)


def write_cost(folder: Path, console: Console) -> None:
    """Seconds a step."""
    text = f"P_2, {COST_STEPS} steps on the 1 + 0.2 P2 sphere, one thread; the median step."
    cost = prices()
    _write(folder, "schemes-cost", "Seconds per step of each scheme", text, cost, console)


def write_comparison(folder: Path, console: Console) -> None:
    """The large table, three sentences on it, and the figure."""
    rows, steps = comparison(V, TAU, TIME, V_STABLE)
    save_cost_figure(folder / "schemes-cost.svg", ladders(TAU, TIME))
    figure = {
        "figure": "schemes-cost.svg",
        "alt": f"Distance of surfaces and error of W of each scheme on the {GROUND} against CPU "
        f"seconds, V = {LADDER[0]} to {LADDER[-1]} at tau = {TAU:g}",
    }
    words = " ".join(sentences(rows, steps, prices()))
    text = (
        f"{words} All with P_2, V = {V}, tau = {TAU:g} to t = {TIME:g}; largest stable tau, up to "
    )
    text += f"{LARGEST:g}, over {STEPS} steps at V = {V_STABLE}. H of dziuk, nu and z of dziuk and "
    text += "bgn are recovered; W of bgn is that of its own H."
    title = "The schemes of section 2.3 on the same meshes"
    _write(folder, "schemes-comparison", title, text, rows, console, **figure)


def write_orders(folder: Path, console: Console) -> None:
    """Orders for P_1, P_2, P_3."""
    text = (
        "Fitted orders in h, without a claim for dziuk and bgn: distance to the Clifford torus "
        f"and W at t = {ORDER_TIME:g}, tau = {ORDER_TAU:g}; the rate at which P2 decays on the "
        f"sphere, by its differences from mesh to mesh, tau = {DECAY_TAU:g}."
    )
    _write(folder, "schemes-orders", "Orders of the schemes", text, orders(), console)


PARTS: dict[str, Callable[[Path, Console], None]] = {
    "cost": write_cost,
    "comparison": write_comparison,
    "orders": write_orders,
}


def _write(
    folder: Path, name: str, title: str, text: str, table: list[Row], console: Console, **more: Any
) -> None:
    """One extra, on disk and on the console."""
    content = {"title": title, "text": text, "table": table, "by": provenance_line(), **more}
    write_text(folder / f"{name}.json", json.dumps(content, indent=1) + "\n")
    console.print(f"\n{title}\n{text}")
    console.print(tabulate(table, headers="keys"), soft_wrap=True)
