"""`esfem schemes`: the comparison of the schemes, written as extras of the report."""

import json
from pathlib import Path
from typing import Any

from rich.console import Console
from tabulate import tabulate

from harness.comparison.figure import GROUND, LADDER, ladders, save_cost_figure
from harness.comparison.tables import Row, comparison, costs, orders
from harness.comparison.words import sentences
from harness.files import write_text
from harness.provenance import provenance_line
from harness.store import writable_folder

V, TAU, TIME = 240, 2.5e-4, 0.01  # of the comparison: one mesh and step for all
V_STABLE = 120
COST_TAU, COST_STEPS = 1e-4, 8


def compare_schemes(out: Path, console: Console) -> None:
    """Compute the comparison and write ``OUT/extra/schemes-*.json`` with its figure.

    Raises
    ------
    BadInput
        If nothing can be written there.
    """
    folder = writable_folder(out, "extra") / "extra"
    cost = costs(COST_TAU, COST_STEPS)
    text = f"P_2, {COST_STEPS} steps on the 1 + 0.2 P2 sphere, one thread; the median step."
    _write(folder, "schemes-cost", "Seconds per step of each scheme", text, cost, console)
    rows, steps = comparison(V, TAU, TIME, V_STABLE)
    found = ladders(TAU, TIME)
    save_cost_figure(folder / "schemes-cost.svg", found)
    figure = {
        "figure": "schemes-cost.svg",
        "alt": f"Distance of surfaces and error of W of each scheme on the {GROUND} against CPU "
        f"seconds, V = {LADDER[0]} to {LADDER[-1]} at tau = {TAU:g}",
    }
    words = " ".join(sentences(rows, steps, cost))
    text = f"{words} All with P_2, V = {V}, tau = {TAU:g} to t = {TIME:g}; largest stable tau over "
    text += f"20 steps at V = {V_STABLE}. H of dziuk, nu and z of dziuk and bgn are recovered."
    title = "The schemes of section 2.3 on the same meshes"
    _write(folder, "schemes-comparison", title, text, rows, console, **figure)
    text = "Fitted orders in h, no theorem for dziuk and bgn; decay is that of P2 on the sphere."
    _write(folder, "schemes-orders", "Orders of the schemes", text, orders(), console)


def _write(
    folder: Path, name: str, title: str, text: str, table: list[Row], console: Console, **more: Any
) -> None:
    """One extra, on disk and on the console."""
    content = {"title": title, "text": text, "table": table, "by": provenance_line(), **more}
    write_text(folder / f"{name}.json", json.dumps(content, indent=1) + "\n")
    console.print(f"\n{title}\n{text}")
    console.print(tabulate(table, headers="keys"), soft_wrap=True)
