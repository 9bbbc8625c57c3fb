"""From the records of a study to records.csv, a line a run with the case and its errors."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from esfem.measuring.energies import balance_error, drift, largest_rise, scale_of
from esfem.measuring.error_columns import columns, largest, largest_idle
from esfem.measuring.lift import VARIABLES
from esfem.measuring.shape import SHAPES
from esfem.results.floors_table import floors_table
from esfem.results.records_file import REFERENCE
from esfem.results.study_result import StudyResult, judged
from esfem.runs.against_finest import errors_against_finest
from esfem.runs.run_case import Record
from esfem.runs.run_pair import PairRecord
from esfem.runs.store import AnyRecord, Cell
from esfem.solver import Levels
from esfem.solver.laws import Energy
from esfem.studies.case import Case, Law, Solution
from esfem.studies.quantities import (
    SIZES,
    asked_for,
    decay_rate,
    growth_rate,
    measured,
    odd_part,
    size_errors,
)
from esfem.studies.study import Study

# Of the scheme, empty where it has no such option.
OPTIONS = ("degree", "bdf", "project", "theta", "reaction")
LEVELS = ("energy", "willmore", "area", "volume", "least_normal", "greatest_normal")


def record_row(study: str, key: str, record: Record, length: float | None = None) -> dict[str, Any]:
    """The line of records.csv: the case, and its errors (`run_errors`), NaN if it stopped early.

    Norms in H^1, and the column length, are those of this unit of length, by default that of the
    solution.
    """
    case, finished = record.case, record.status == "ok"
    # A run that could not even start has no level.
    levels = {name: record.levels.get(name, [np.nan]) for name in LEVELS}
    return {
        "study": study,
        "solution": case["solution"]["name"],
        "law": case["law"]["name"],
        "scheme": case["scheme"]["name"],
        **{name: case["scheme"].get(name) for name in OPTIONS},
        "first_steps": case["first_steps"],
        "vertices": case["vertices"],
        "nodes": record.nodes,
        "h": record.h,
        "h_max": record.h_max,
        "length": record.length if length is None else length,
        "tau": case["tau"],
        "steps": steps_of(case),
        "final_time": case["final_time"],
        "status": record.status,
        "stopped_at": np.nan if record.stopped_at is None else record.stopped_at,
        **run_errors(record, length),
        "moved": record.moved,
        "energy_0": levels["energy"][0],
        "energy_T": levels["energy"][-1] if finished else np.nan,
        "willmore_0": levels["willmore"][0],
        "willmore_T": levels["willmore"][-1] if finished else np.nan,
        "area_0": levels["area"][0],
        "area_T": levels["area"][-1] if finished else np.nan,
        "volume_0": levels["volume"][0],
        "volume_T": levels["volume"][-1] if finished else np.nan,
        "least_normal": min(levels["least_normal"]),
        "greatest_normal": max(levels["greatest_normal"]),
        "seconds": record.seconds["total"],
        **{f"seconds_{part}": spent for part, spent in record.seconds.items() if part != "total"},
        "gmres_mean": float(np.mean(record.iterations)) if record.iterations else 0.0,
        "reason": record.reason,
        "key": key,
        "mesh_digest": record.mesh["digest"],
        **{name: record.environment[name] for name in ("version", "numerics", "machine")},
    }


def steps_of(case: dict[str, Any]) -> int:
    """Number of time steps of a case in plain data, all substeps counted."""
    whole, order = round(case["final_time"] / case["tau"]), case["scheme"].get("bdf", 1)
    return Levels.started(case["tau"], whole, order, case["first_steps"]).steps


def run_errors(record: Record, length: float | None = None) -> dict[str, float]:
    """The errors of a run, by column, as far as it measures them; NaN if it stopped early.

    ``err_<variable>`` in L-infinity(0,T; H^1), ``err_<variable>_l2`` in L-infinity(L^2), ``t_*``
    the time at which the H^1 maximum is attained; ``nodal_<variable>``, ``nodal_<variable>_l2`` and
    ``t_nodal_*`` the same of the error against the interpolation, u_h - I_h u on Gamma_h*;
    ``idle_<variable>`` the error ``err_<variable>`` that the initial State kept for ever has;
    ``energy_rise`` the largest increase of the energy of the law in a step, relative;
    ``err_size_<variable>`` where the size of an error is known; the measured rates with their
    errors; ``err_energy_law`` and ``err_volume_drift`` of what a law alone tells; ``err_W`` and so
    on, the largest over the times of comparison, and ``err_W_at_<t>`` at each; what the case asks
    for (``also``), the largest over its levels. Norms in H^1 are those with this unit of length, by
    default that of the solution.
    """
    case, L = record.case, record.length if length is None else length
    solution: Any = Solution(**case["solution"]).initial()  # has the rates that it measures
    also = asked_for(case.get("also", ()))
    law = Law(**case["law"])
    quantities, energy = (*measured(solution, case["scheme"]["name"], law), *also), law.energy
    if record.status != "ok":
        return dict.fromkeys(_lacking(quantities, solution.always_exact), np.nan)
    rates = _rates(record, solution, quantities)
    found = {
        **largest("err", "t", record.t, record.l2, record.seminorm, L),
        **largest("nodal", "t_nodal", record.t, record.nodal_l2, record.nodal_seminorm, L),
        **largest_idle(record.idle_l2, record.idle_seminorm, L),
    }
    for name in (*SHAPES, *also):
        if f"err_{name}" in record.levels:
            found[f"err_{name}"] = max(record.levels[f"err_{name}"])
        if name in record.idle_levels:
            found[f"idle_{name}"] = max(record.idle_levels[name])
    found |= rates | _balances(record, quantities, energy)
    if SIZES.keys() <= set(quantities):
        found |= size_errors(Case.model_validate(case), found, L)
    for name in record.compared:
        if name == "t":
            continue
        found[f"err_{name}"] = max(record.compared[name])
        for t, error in zip(record.compared["t"], record.compared[name], strict=True):
            found[f"err_{name}_at_{t:g}"] = error
    return found


def _lacking(quantities: Sequence[str], exact: bool) -> list[str]:
    """The columns that are empty if a run stopped early."""
    rates = {"decay": "decay_rate", "growth": "growth_rate"}
    found = ["energy_rise", *(f"err_{name}" for name in quantities)]
    found += [column for name, column in rates.items() if name in quantities]
    if exact:
        found += columns(name for name in VARIABLES if name in quantities)
        found += [f"idle_{name}" for name in SHAPES if name in quantities]
    return found


def _rates(record: Record, solution: Any, quantities: Sequence[str]) -> dict[str, float]:
    """The measured rates of decay and growth, with their errors."""
    found: dict[str, float] = {}
    if "decay" in quantities:
        both = record.levels["amplitude"], record.levels["opposite_amplitude"]
        found["decay_rate"] = decay_rate(record.t, odd_part(*both))
        found["err_decay"] = abs(found["decay_rate"] / solution.decay_rate - 1.0)
    if "growth" in quantities:
        normals = record.levels["least_normal"], record.levels["greatest_normal"]
        free = solution.off_constraint_rate
        expected = 0.0 if record.case["scheme"].get("project", False) else free
        found["growth_rate"] = growth_rate(record.t, *normals)
        found["err_growth"] = abs(found["growth_rate"] - expected) / free
    return found


def _balances(record: Record, quantities: Sequence[str], energy: Energy) -> dict[str, float]:
    """What a law alone tells: whether its energy falls, what is lost of it was dissipated, and the
    volume stays."""
    energies = record.levels["energy"]
    scale = scale_of(energy, energies[0], record.levels["willmore"][0])
    found = {"energy_rise": largest_rise(energies, scale)[0]}
    if "energy_law" in quantities:
        lost = balance_error(record.t, energies, record.levels["dissipation"], scale)
        found["err_energy_law"] = lost
    if "volume_drift" in quantities:
        found["err_volume_drift"] = drift(record.levels["volume"])
    return found


def collected(
    study: Study,
    folder: Path,
    cells: Sequence[Cell],
    records: Mapping[Cell, AnyRecord],
    say: Callable[[str], None] = lambda line: None,
    jobs: int = 1,
) -> StudyResult:
    """The result of a study, judged, from the records of its cells, as far as they have been run.

    ``say`` is told of what takes a while; that is done in ``jobs`` processes.
    """
    rows = rows_of(cells, records, study.claimed_length)
    runs = list(rows.values())
    if study.initial.reference == "finest":
        own = {cell.key: r for cell, r in records.items() if isinstance(r, Record)}
        errors = errors_against_finest([c for c in cells if c.floor is None], own, say, jobs)
        runs = [against_finest_row(row, errors.get(row["key"])) for row in runs]
    table = pd.DataFrame(runs)
    pairs = {
        cell.floor: (cell.key, record)
        for cell in cells
        if cell.floor is not None and isinstance(record := records.get(cell), PairRecord)
    }
    return judged(study, folder, table, floors_table(study, table, pairs))


def rows_of(
    cells: Sequence[Cell], records: Mapping[Cell, AnyRecord], length: float | None = None
) -> dict[Cell, dict[str, Any]]:
    """The lines of records.csv (`record_row`), in the order of the cells; cells without a record,
    and those that measure floors, are left out."""
    found = ((cell, records.get(cell)) for cell in cells)
    return {c: record_row(c.study, c.key, r, length) for c, r in found if isinstance(r, Record)}


def against_finest_row(row: dict[str, Any], errors: dict[str, float] | None) -> dict[str, Any]:
    """The row with its errors; a completed run without any is a reference, and has that status."""
    lacking = dict.fromkeys(columns(VARIABLES), np.nan)
    if row["status"] != "ok" or errors is not None:
        return {**row, **lacking, **(errors or {})}
    return {**row, **lacking, "status": REFERENCE}
