"""Errors against the finest level, for flows without exact solution.

All runs of a study at one time step are compared with the run on its finest mesh, at the times of
comparison, by `measuring.overlay`. The error of that run itself is part of the difference: with
independent meshes it adds in the square, and a level of mesh width h >= 2 h_finest has an order
that is too low by 0.06 at most for k = 2, and by less for k > 2. Finer levels are shown, but not
judged (`esfem.results.selection.APART`). The error against the interpolation is compared alike:
u - I_h u_fine, with I_h u_fine on the coarse mesh.
"""

import json
from collections.abc import Callable, Sequence
from itertools import groupby
from pathlib import Path

from esfem.common.files import write_text
from esfem.measuring.error_columns import largest, largest_idle
from esfem.measuring.lift import ByVariable, unknowns
from esfem.measuring.location import locate
from esfem.measuring.overlay import against_finest, against_interpolation, overlay
from esfem.runs.executors import LocalProcesses
from esfem.runs.problem import problem_of
from esfem.runs.run_case import Record, computational_mesh
from esfem.runs.stepping import states
from esfem.runs.store import Cell, read_snapshots


def errors_against_finest(
    cells: Sequence[Cell], records: dict[str, Record], say: Callable[[str], None], jobs: int = 1
) -> dict[str, dict[str, float]]:
    """By key of each run that ended, its errors as columns of records.csv (`run_errors`).

    A run whose finest level did not end has none. What was compared before is read again.

    Parameters
    ----------
    cells : those of one study.
    records : by key, of the cells that have one.
    say : is told of each comparison when it is made.
    jobs : number of processes.
    """
    finest = max(cell.case.vertices for cell in cells)
    ended = [c for c in cells if c.key in records and records[c.key].status == "ok"]
    reference = {c.case.tau: c for c in ended if c.case.vertices == finest}
    pairs = [
        (c, reference[c.case.tau])
        for c in ended
        if c.case.vertices < finest and c.case.tau in reference
    ]
    _compare_all([pair for pair in pairs if _stored(*pair) is None], say, jobs)
    compared = {cell.key: _stored(cell, fine) for cell, fine in pairs}
    return {key: errors for key, errors in compared.items() if errors is not None}


def _compare_all(pairs: list[tuple[Cell, Cell]], say: Callable[[str], None], jobs: int) -> None:
    """Compare and store; the runs on one mesh together, for where its points lie is dear."""
    by_mesh = [
        list(own) for _, own in groupby(pairs, lambda pair: (pair[0].surface.digest, pair[0].study))
    ]
    if by_mesh:
        for _, (cell, fine) in LocalProcesses(jobs).run(_compare, by_mesh):
            say(f"{cell.study}: compared V={cell.case.vertices} with V={fine.case.vertices}")


def _compare(pairs: list[tuple[Cell, Cell]]) -> tuple[Cell, Cell]:
    """Compare runs on one mesh with those on one finer mesh, store the largest errors."""
    cell, finest = pairs[0]
    solution, degree = cell.case.initial, cell.case.scheme.degree
    mesh, p = computational_mesh(cell.surface, solution, degree)
    fine, p_fine = computational_mesh(finest.surface, solution, degree)
    over = overlay(mesh, p, fine, p_fine, solution.fields(p_fine, 0.0).nu)
    nodes = locate(fine, p_fine, p, solution.fields(p, 0.0).nu)
    for own, reference in pairs:
        problem = problem_of(own.case, mesh, p, solution)
        start = unknowns(next(states(problem, own.case.levels)))
        plain, nodal, idle = [], [], []
        for u, u_fine in zip(
            read_snapshots(own.folder, own.key),
            read_snapshots(reference.folder, reference.key),
            strict=True,
        ):
            plain.append(against_finest(over, mesh, u, fine, u_fine))
            nodal.append(against_interpolation(nodes, mesh, u, fine, u_fine))
            idle.append(against_finest(over, mesh, start, fine, u_fine))
        times, length = own.case.compare_at, solution.length
        found = {
            **largest("err", "t", times, *_series(plain), length),
            **largest("nodal", "t_nodal", times, *_series(nodal), length),
            **largest_idle(*_series(idle), length),
        }
        write_text(_path(own, reference), json.dumps(found))
    return cell, finest


def _series(norms: Sequence[ByVariable]) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    """The norms in L^2 and the seminorms by variable, from both at each time."""
    names = norms[0]
    l2 = {name: [n[name].l2 for n in norms] for name in names}
    return l2, {name: [n[name].seminorm for n in norms] for name in names}


def _path(cell: Cell, finest: Cell) -> Path:
    return cell.folder / "records" / f"{cell.key}-against-{finest.key}.json"


def _stored(cell: Cell, finest: Cell) -> dict[str, float] | None:
    """What was compared before; None if nothing was."""
    try:
        return json.loads(_path(cell, finest).read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        return None
