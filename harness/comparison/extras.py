"""The comparison of the schemes, written as extras of the report."""

import json
from collections.abc import Callable, Collection
from functools import cache
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import track
from tabulate import tabulate

from harness.comparison.contest import ENTRANTS, GROUNDS
from harness.comparison.figure import (
    GROUND,
    LADDER,
    LONG_TAU,
    LONG_TIME,
    LONG_V,
    courses,
    ladders,
    save_cost_figure,
    save_course_figure,
)
from harness.comparison.stability import LARGEST, STEPS
from harness.comparison.tables import (
    DECAY_TAU,
    DEGREES,
    ORDER_TAU,
    ORDER_TIME,
    Row,
    comparison,
    costs,
    course_row,
    orders,
)
from harness.comparison.words import sentences
from harness.files import write_text
from harness.provenance import provenance_line
from harness.store import writable_folder

V, TAU, TIME = 240, 2.5e-4, 0.01  # of the comparison: one mesh and step for all
V_STABLE = 120
COST_TAU, COST_STEPS = 1e-4, 8


def compare_schemes(out: Path, console: Console, parts: Collection[str]) -> None:
    """Compute these `PARTS` of the comparison; write ``OUT/extra/schemes-*.json`` with figures.

    Raises
    ------
    BadInput
        If nothing can be written there.
    """
    folder = writable_folder(out, "extra") / "extra"
    for part, write in PARTS.items():
        if part in parts:
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
    cells = comparison(V, TAU, TIME, V_STABLE)
    found = track(cells, "comparing", len(GROUNDS) * len(ENTRANTS), console=console)
    rows, steps = map(list, zip(*found, strict=True))
    marches = track(ladders(TAU, TIME), "error against seconds", len(ENTRANTS), console=console)
    save_cost_figure(folder / "schemes-cost.svg", dict(marches))
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


def write_courses(folder: Path, console: Console) -> None:
    """A long flow: quality of the mesh and energy along t."""
    found = dict(track(courses(), "long flows", len(ENTRANTS), console=console))
    save_course_figure(folder / "schemes-course.svg", found)
    rows = [course_row(entrant, m) for entrant, m in found.items()]
    figure = {
        "figure": "schemes-course.svg",
        "alt": f"Least quality of a triangle and energy on the {GROUND} against time, by scheme",
    }
    text = (
        f"The {GROUND} with P_2, V = {LONG_V}, tau = {LONG_TAU:g} to t = {LONG_TIME:g}: quality is "
        "twice the least ratio of inscribed to circumscribed circle of a triangle of vertices; no "
        "mesh is mended."
    )
    title = "Mesh and energy of each scheme along time"
    _write(folder, "schemes-course", title, text, rows, console, **figure)


def write_orders(folder: Path, console: Console) -> None:
    """Orders for P_1, P_2, P_3."""
    total = len(ENTRANTS) * len(DEGREES)
    rows = list(track(orders(), "orders", total, console=console))
    text = (
        "Fitted orders in h on the Clifford torus at rest: x in L-infinity(H^1) where nodes do not "
        "slide, with the verdict and interval of the judge where Theorem 4.1 speaks (there is no "
        f"theorem for dziuk and bgn); distance to the torus and W at t = {ORDER_TIME:g}, tau = "
        f"{ORDER_TAU:g}. And the rate at which P2 decays on the sphere, by its differences from "
        f"mesh to mesh, tau = {DECAY_TAU:g}."
    )
    _write(folder, "schemes-orders", "Orders of the schemes", text, rows, console)


PARTS: dict[str, Callable[[Path, Console], None]] = {
    "cost": write_cost,
    "comparison": write_comparison,
    "orders": write_orders,
    "course": write_courses,
}


def _write(
    folder: Path, name: str, title: str, text: str, table: list[Row], console: Console, **more: Any
) -> None:
    """One extra, on disk and on the console."""
    content = {"title": title, "text": text, "table": table, "by": provenance_line(), **more}
    write_text(folder / f"{name}.json", json.dumps(content, indent=1) + "\n")
    console.print(f"\n{title}\n{text}")
    console.print(tabulate(table, headers="keys"), soft_wrap=True)
