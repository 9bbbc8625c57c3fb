"""From the records of a study to records.csv, a line a run with the case and its errors, and to
floors.csv: what the measured floors are, and what share of the error each is.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from esfem.judging.floors import FloorName
from esfem.measuring.energies import balance_error, drift, largest_rise, scale_of
from esfem.measuring.lift import VARIABLES
from esfem.measuring.shape import SHAPES
from esfem.results.records_file import REFERENCE
from esfem.results.study_result import StudyResult, judged
from esfem.runs.against_finest import errors_against_finest
from esfem.runs.run_case import Record
from esfem.runs.store import Cell
from esfem.solver import Levels
from esfem.studies.case import Case, Law, Solution
from esfem.studies.quantities import (
    SIZES,
    decay_rate,
    growth_rate,
    measured,
    odd_part,
    size_errors,
)
from esfem.studies.study import Study
from esfem.studies.variations import measured_cells

# Of the scheme, empty where it has no such option.
OPTIONS = ("degree", "bdf", "project", "theta", "reaction")
LEVELS = ("energy", "willmore", "area", "volume", "least_normal", "greatest_normal")
FLOORS = ("floor", "variable", "vertices", "tau", "error", "varied", "value", "key")


def record_row(study: str, key: str, record: Record) -> dict[str, Any]:
    """The line of records.csv: the case, and its errors (`run_errors`), NaN if it stopped early."""
    case, finished = record.case, record.status == "ok"
    # A run that could not even start has no level.
    levels = {name: record.levels.get(name, [np.nan]) for name in LEVELS}
    rise = energy_rise(record) if finished else np.nan
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
        "tau": case["tau"],
        "steps": steps_of(case),
        "final_time": case["final_time"],
        "status": record.status,
        "stopped_at": np.nan if record.stopped_at is None else record.stopped_at,
        **run_errors(record),
        "energy_0": levels["energy"][0],
        "energy_T": levels["energy"][-1] if finished else np.nan,
        "energy_rise": rise,
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


def energy_rise(record: Record) -> float:
    """The largest increase of the energy of the law in a step, relative (`scale_of`)."""
    return largest_rise(record.levels["energy"], energy_scale(record))[0]


def energy_scale(record: Record) -> float:
    """What changes of the energy of the law are measured by (`scale_of`)."""
    energies, W = record.levels["energy"], record.levels["willmore"]
    return scale_of(Law(**record.case["law"]).energy, energies[0], W[0])


def run_errors(record: Record) -> dict[str, float]:
    """The errors of a run, by column, as far as it measures them; NaN if it stopped early.

    ``err_<variable>`` in L-infinity(0,T; H^1), ``err_<variable>_l2`` in L-infinity(L^2), ``t_*``
    the time at which the H^1 maximum is attained; ``nodal_<variable>`` and ``t_nodal_*`` the same
    of the error against the interpolation, u_h - I_h u in H^1(Gamma_h*); ``err_size_<variable>``
    where the size of an error is known; the measured rates with their errors; ``err_energy_law``
    and ``err_volume_drift`` of what a law alone tells; ``err_W`` and so on, the largest over the
    times of comparison, and ``err_W_at_<t>`` at each.
    """
    case = record.case
    solution: Any = Solution(**case["solution"]).initial()  # has the rates that it measures
    quantities = measured(solution, case["scheme"]["name"], Law(**case["law"]))
    if record.status != "ok":
        rates = {"decay": "decay_rate", "growth": "growth_rate"}
        columns = [f"err_{name}" for name in quantities]
        columns += [column for name, column in rates.items() if name in quantities]
        if solution.always_exact:
            columns += [f"nodal_{name}" for name in VARIABLES if name in quantities]
        return dict.fromkeys(columns, np.nan)
    found: dict[str, float] = {}
    for name in record.h1:
        found[f"err_{name}"] = max(record.h1[name])
        found[f"err_{name}_l2"] = max(record.l2[name])
        found[f"t_{name}"] = record.t[int(np.argmax(record.h1[name]))]
    for name, norms in record.nodal.items():
        found[f"nodal_{name}"] = max(norms)
        found[f"t_nodal_{name}"] = record.t[int(np.argmax(norms))]
    for name in SHAPES:
        if f"err_{name}" in record.levels:
            found[f"err_{name}"] = max(record.levels[f"err_{name}"])
    if "decay" in quantities:
        both = record.levels["amplitude"], record.levels["opposite_amplitude"]
        found["decay_rate"] = decay_rate(record.t, odd_part(*both))
        found["err_decay"] = abs(found["decay_rate"] / solution.decay_rate - 1.0)
    if "growth" in quantities:
        normals = record.levels["least_normal"], record.levels["greatest_normal"]
        free = solution.off_constraint_rate
        expected = 0.0 if case["scheme"].get("project", False) else free
        found["growth_rate"] = growth_rate(record.t, *normals)
        found["err_growth"] = abs(found["growth_rate"] - expected) / free
    if "energy_law" in quantities:
        levels = record.levels["energy"], record.levels["dissipation"]
        found["err_energy_law"] = balance_error(record.t, *levels, energy_scale(record))
    if "volume_drift" in quantities:
        found["err_volume_drift"] = drift(record.levels["volume"])
    if SIZES.keys() <= set(quantities):
        found |= size_errors(Case.model_validate(case), found)
    for name in record.compared:
        if name == "t":
            continue
        found[f"err_{name}"] = max(record.compared[name])
        for t, error in zip(record.compared["t"], record.compared[name], strict=True):
            found[f"err_{name}_at_{t:g}"] = error
    return found


ERROR_COLUMNS = (("err_", ""), ("err_", "_l2"), ("t_", ""))


def collected(
    study: Study,
    folder: Path,
    cells: Sequence[Cell],
    records: Mapping[Cell, Record],
    say: Callable[[str], None] = lambda line: None,
    jobs: int = 1,
) -> StudyResult:
    """The result of a study, judged, from the records of its cells, as far as they have been run.

    ``say`` is told of what takes a while; that is done in ``jobs`` processes.
    """
    rows = rows_of(cells, records)
    own = [cell for cell in cells if cell.floor is None]
    runs = [rows[cell] for cell in own if cell in rows]
    if study.initial.reference == "finest":
        found = {cell.key: records[cell] for cell in own if cell in records}
        errors = errors_against_finest(own, found, say, jobs)
        runs = [against_finest_row(row, errors.get(row["key"])) for row in runs]
    table = pd.DataFrame(runs)
    varied = {cell.floor: row for cell, row in rows.items() if cell.floor is not None}
    return judged(study, folder, table, floors_table(study, table, varied))


def rows_of(cells: Sequence[Cell], records: Mapping[Cell, Record]) -> dict[Cell, dict[str, Any]]:
    """The lines of records.csv, in the order of the cells; cells without a record are left out."""
    return {c: record_row(c.study, c.key, records[c]) for c in cells if c in records}


def against_finest_row(row: dict[str, Any], errors: dict[str, float] | None) -> dict[str, Any]:
    """The row with its errors; a completed run without any is a reference, and has that status."""
    lacking = {f"{e}{v}{s}": np.nan for v in VARIABLES for e, s in ERROR_COLUMNS}
    if row["status"] != "ok" or errors is not None:
        return {**row, **lacking, **(errors or {})}
    return {**row, **lacking, "status": REFERENCE}


def floors_table(
    study: Study, records: pd.DataFrame, varied: dict[FloorName, dict[str, Any]]
) -> pd.DataFrame:
    """floors.csv: a line a floor and variable.

    Parameters
    ----------
    records, varied : the rows (`record_row`) of the sweep, and by floor that of the
        variation.

    With order q, e(tau) - e(tau/2) is the part 1 - 2^-q of the error in time. Runs that stopped
    early tell nothing: NaN.
    """
    lines = []
    for name, cell in measured_cells(study).items():
        at = (records["vertices"] == cell.vertices) & (records["tau"] == cell.tau)
        if name not in varied or not at.any():
            continue
        own, row = records[at].iloc[0], varied[name]
        part = 1.0 - 2.0**-study.scheme.order if name == "tau" else 1.0
        for variable in study.variables:
            e, other = own[f"err_{variable}"], row[f"err_{variable}"]
            value = abs(other - e) / part
            line = (name, variable, cell.vertices, cell.tau, e, other, value, row["key"])
            lines.append(line)
    return pd.DataFrame(lines, columns=list(FLOORS))
