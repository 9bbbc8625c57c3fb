"""Errors against the finest level, for flows without exact solution.

All runs of a study at one time step are compared with the run on its finest mesh, at the times of
comparison, by `harness.transfer`. The error of that run itself is part of the difference: with
independent meshes it adds in the square, and a level of mesh width h >= 2 h_finest has an order
that is too low by 0.06 at most for k = 2, and by less for k > 2. Finer levels are shown, but not
judged (`APART`).
"""

import json
from collections.abc import Callable, Sequence

import numpy as np

from harness.errors import VARIABLES
from harness.runner import Record, computational_mesh
from harness.store import read_snapshots, write_text
from harness.sweep import Cell
from harness.transfer import against_finest, overlay

APART = 2.0  # a judged mesh is coarser than the finest one by this factor


def errors_against_finest(
    cells: Sequence[Cell], records: dict[str, Record], say: Callable[[str], None]
) -> dict[str, dict[str, float]]:
    """By key of each run that ended, its errors as columns of records.csv (`run_errors`).

    A run whose finest level did not end has none. What was compared before is read again.

    Parameters
    ----------
    cells : those of one study.
    records : by key, of the cells that have one.
    say : is told of each comparison before it is made.
    """
    finest = max(cell.case.vertices for cell in cells)
    ended = [c for c in cells if c.key in records and records[c.key].status == "ok"]
    reference = {c.case.tau: c for c in ended if c.case.vertices == finest}
    return {
        c.key: _compared(c, reference[c.case.tau], say)
        for c in ended
        if c.case.vertices < finest and c.case.tau in reference
    }


def _compared(cell: Cell, finest: Cell, say: Callable[[str], None]) -> dict[str, float]:
    """The largest error over the times of comparison, stored beside the records."""
    path = cell.folder / "records" / f"{cell.key}-against-{finest.key}.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        say(f"{cell.study}: comparing {cell.case.label} with V={finest.case.vertices}")
    norms = _norms(cell, finest)
    found: dict[str, float] = {}
    for i, name in enumerate(VARIABLES):
        l2, h1 = norms[:, i, 0], norms[:, i, 1]
        found[f"err_{name}"], found[f"err_{name}_l2"] = float(h1.max()), float(l2.max())
        found[f"t_{name}"] = cell.case.compare_at[int(h1.argmax())]
    write_text(path, json.dumps(found))
    return found


def _norms(cell: Cell, finest: Cell) -> np.ndarray:
    """The norms (L2, H1) of the difference, (times, variables, 2)."""
    solution, degree = cell.case.solution.initial(), cell.case.scheme.degree
    mesh, p = computational_mesh(cell.surface, solution, degree)
    fine, p_fine = computational_mesh(finest.surface, solution, degree)
    over = overlay(mesh, p, fine, p_fine, solution.fields(p_fine, 0.0).nu)
    pairs = zip(
        read_snapshots(cell.folder, cell.key),
        read_snapshots(finest.folder, finest.key),
        strict=True,
    )
    return np.array([list(against_finest(over, mesh, u, fine, f).values()) for u, f in pairs])
