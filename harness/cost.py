"""What a run will cost: a power law in nodes and steps, fitted on the timings of stored records.

    log seconds = a + b log(nodes + 200) + c log(steps) + d log(degree) + e [moves]

The coefficients start from those of the baseline and are drawn to what is stored, as far as that
tells: a ridge about the prior. The constant, the speed of the machine, is drawn at once, the
exponents by many different runs only.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from heapq import heapify, heapreplace
from pathlib import Path

import numpy as np

from harness.cell import Cell
from reference_solutions import STARTS
from solver.reference_element import Array

OVERHEAD_NODES = 200  # a step on no mesh costs as much as one on so many nodes
SCATTER = 0.2  # of the logarithm of seconds about the law
PRIOR = (-10.76, 1.05, 0.90, -0.68, 0.22)  # least squares on results/baseline
TRUST = (1.0, 0.1, 0.1, 0.2, 0.2)  # standard deviations of the prior
MOST_RECORDS = 300  # the newest ones are read, so that a long history costs no time


@dataclass(frozen=True)
class CostModel:
    """Coefficients a, b, c, d, e of the law."""

    coefficients: tuple[float, ...] = PRIOR

    def seconds(self, cell: Cell) -> float:
        """Expected seconds of a cell, if it runs to its end."""
        case = cell.case
        surface, degree = cell.surface, case.scheme.degree
        nodes = nodes_of(len(surface.vertices), len(surface.triangles), degree)
        moves = moving(case.solution.name)
        row = features(nodes, case.steps, degree, moves)
        return float(np.exp(row @ self.coefficients))


def features(nodes: float, steps: float, degree: int, moves: bool) -> Array:
    """The row of the law, (5,)."""
    return np.array(
        [1.0, np.log(nodes + OVERHEAD_NODES), np.log(steps), np.log(degree), float(moves)]
    )


def nodes_of(vertices: int, triangles: int, k: int) -> int:
    """Nodes of the P_k mesh: in the vertices, 3/2 edges a triangle, and the triangles."""
    return vertices + (k - 1) * 3 * triangles // 2 + (k - 1) * (k - 2) // 2 * triangles


def moving(solution: str) -> bool:
    """Whether the reference is another surface at each time, which costs in measuring errors."""
    return not STARTS[solution].stationary


def fitted(timings: Iterable[tuple[Array, float]]) -> CostModel:
    """The law from the prior and from (features, seconds) of runs."""
    timings = list(timings)
    if not timings:
        return CostModel()
    rows = np.array([row for row, _ in timings])
    logs = np.log([max(seconds, 1e-3) for _, seconds in timings])
    prior, precision = np.array(PRIOR), np.diag(np.array(TRUST) ** -2.0)
    normal = rows.T @ rows / SCATTER**2 + precision
    change = np.linalg.solve(normal, rows.T @ (logs - rows @ prior) / SCATTER**2)
    return CostModel(tuple(prior + change))


def stored_timings(out: Path) -> list[tuple[Array, float]]:
    """Features and seconds of the newest records in the folders of all studies below ``out``."""
    paths = sorted(out.glob("*/records/*.json"), key=_written, reverse=True)
    found = (_timing(path) for path in paths[:MOST_RECORDS])
    return [timing for timing in found if timing is not None]


def remaining(running: Iterable[float], waiting: Iterable[float], workers: int) -> float:
    """Seconds until all is done: each run that waits, in this order, goes to the first free worker.

    ``running`` and ``waiting`` are seconds that each run still needs.
    """
    ends = sorted(running, reverse=True)
    ends += [0.0] * (workers - len(ends))
    heapify(ends)
    for seconds in waiting:
        heapreplace(ends, ends[0] + seconds)
    return max(ends)


def _written(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def _timing(path: Path) -> tuple[Array, float] | None:
    """Features and seconds of one record; None if it did not run for a step, or is damaged."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"))["record"]
        case, steps = record["case"], len(record["t"]) - 1
        moves = moving(case["solution"]["name"])
        row = features(record["nodes"], steps, case["scheme"]["degree"], moves)
        return (row, record["seconds"]["total"]) if steps else None
    except (OSError, ValueError, KeyError, TypeError):
        return None
