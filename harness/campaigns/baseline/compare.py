"""Results against a baseline, as a pure function: what moved, by how much, for better or worse.

"errors" is the geometric mean, over the cells (V, tau) that the baseline was judged on, of the
factor between the errors there, and "one error" the largest factor of a cell: both are free of any
fit.  "constant" is the fitted error in the middle of the baseline's window, constant s^order with s
the geometric mean of its h (or tau): the constant at s = 1 itself is an extrapolation far beyond
the window, and moves with every change of the order.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from esfem.campaigns.baseline.change import Change, Effect, Stored, What
from esfem.campaigns.baseline.tolerances import (
    OTHER_MESHES,
    SAME_MESHES,
    Most,
    level_tolerance,
    one_tolerance,
    order_tolerance,
)
from esfem.judging.outcome import Outcome
from esfem.results.error_verdicts import ErrorVerdict
from esfem.results.verdicts import Verdict
from esfem.studies.claims import Direction
from esfem.studies.study import Study

ROUNDING = 1e-10  # errors below count as this: they are noise of the machine
PROBLEM = ("solution", "law", "scheme")  # parameters of a study that make it another problem
NOT_TOLD = "not told"
BOUNDS = ("expected", "tolerance", "limit")
MESH = "mesh_digest"
CELL = ["vertices", "tau"]
# Not exercised or claimed any more is worse than passed: the guard is gone.
RANK: dict[Outcome, int] = {
    **{"pass": 0, "super": 0},
    **{"not exercised": 1, "no claim": 1},
    **{"inconclusive": 2},
    **{"suspect": 3, "fail": 3},
}


def compare(baseline: Stored, current: Stored) -> list[Change]:
    """All comparisons of one study with its baseline, moved or not; see `Change.moved`.

    Both errors of a variable are compared, as far as the baseline has them.
    """
    odd = other_options(baseline, current)
    if odd:
        before, now = (
            ", ".join(f"{name} = {pair[i]}" for name, pair in odd.items()) for i in (0, 1)
        )
        return marked([Change("case", before, now)], baseline)
    return comparisons(baseline, current)


def marked(changes: list[Change], baseline: Stored) -> list[Change]:
    """The changes with the study and the origin of its baseline."""
    return [replace(one, study=baseline.study, since=baseline.since) for one in changes]


def other_options(baseline: Stored, current: Stored) -> dict[str, tuple[Any, Any]]:
    """What makes them different problems, with both values; empty if it is the same one.

    Those options of solution, law and scheme, final_time and first_steps that differ; `NOT_TOLD`
    stands for what one of them does not have.
    """
    before, now = (_options(stored.content.parameters) for stored in (baseline, current))
    pairs = {
        name: (before.get(name, NOT_TOLD), now.get(name, NOT_TOLD)) for name in {**before, **now}
    }
    return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}


def _options(study: Study) -> dict[str, Any]:
    """The options that make a problem, as they were told: "scheme.bdf" and so on, and of the sweep
    final_time and first_steps."""
    told = study.model_dump(mode="json", exclude_unset=True)
    named = {f"{part}.{key}": value for part in PROBLEM for key, value in told[part].items()}
    sweep = {"final_time": study.sweep.final_time, "first_steps": study.sweep.first_steps}
    return {**named, **sweep}


def comparisons(baseline: Stored, current: Stored) -> list[Change]:
    """All comparisons, whether or not it is the same problem."""
    changes = _runs(baseline.records, current.records)
    verdicts = {verdict.variable: verdict for verdict in current.content.verdicts}
    for before in baseline.content.verdicts:
        now = verdicts.get(before.variable)
        if now is None:
            lost = Change(
                "verdict", before.verdict, "not judged", "worse", variable=before.variable
            )
            changes.append(lost)
            continue
        changes += [replace(one, variable=before.variable) for one in _claims(before, now)]
        for part in before.parts:
            found = _part(baseline, current, before, now, part)
            changes += [replace(change, variable=said_of(before, part)) for change in found]
    return marked(changes, baseline)


def said_of(verdict: Verdict, part: ErrorVerdict) -> str:
    """The variable, and the error where it is not the plain one: "x", "x (interpolation)"."""
    return verdict.variable if part.name == "error" else f"{verdict.variable} ({part.name})"


def _part(
    baseline: Stored, current: Stored, before: Verdict, now: Verdict, part: ErrorVerdict
) -> list[Change]:
    """The numbers of one error of a variable, which the baseline judged."""
    other = next((p for p in now.parts if p.name == part.name), None)
    if other is None:
        return [Change("errors", "judged", "not judged any more", "worse")]
    if before.direction != now.direction:
        return [Change("case", before.direction, now.direction)]
    return _numbers(baseline, current, before, (part, other))


def _runs(before: pd.DataFrame, now: pd.DataFrame) -> list[Change]:
    """Runs that are not there any more, or end otherwise."""
    changes = []
    statuses = now.set_index(CELL)["status"].to_dict()
    for vertices, tau, ended in before[[*CELL, "status"]].itertuples(index=False):
        status = statuses.get((vertices, tau))
        if status is None:
            changes.append(Change("cell", ended, "none", place=_cell(vertices, tau)))
        elif status != ended:
            effect: Effect = "worse" if ended == "ok" else "better" if status == "ok" else "unknown"
            changes.append(Change("run", ended, status, effect, _cell(vertices, tau)))
    return changes


def _cell(vertices: float, tau: float) -> str:
    return f"V = {int(vertices)}, tau = {tau:g}"


def _claims(before: Verdict, now: Verdict) -> list[Change]:
    """The verdict on one variable, and what it is held to where that is something else."""
    rank = RANK[now.verdict] - RANK[before.verdict]
    changes = [Change("verdict", before.verdict, now.verdict, _effect(rank))]
    if before.claim and claimed(before) != claimed(now):
        weight: Effect = "unknown" if now.claim else "worse"
        changes.append(Change("claim", claimed(before), claimed(now), weight))
    return changes


def claimed(verdict: Verdict) -> str:
    """What a verdict holds a variable to, in words."""
    bounds = {name: getattr(verdict, name) for name in BOUNDS}
    told = [f"{name} {bound:g}" for name, bound in bounds.items() if np.isfinite(bound)]
    return ", ".join([verdict.claim or "no claim", *told])


def _numbers(
    baseline: Stored, current: Stored, verdict: Verdict, parts: tuple[ErrorVerdict, ErrorVerdict]
) -> list[Change]:
    """Errors, order and constant of one error of a variable, before and now."""
    before, now = parts
    cells = _cells(baseline, current, before, before.column(verdict.variable))
    if cells.empty:
        return [Change("errors", "judged", "at no common cell")] if before.vertices else []
    most = SAME_MESHES if cells["same_mesh"].all() else OTHER_MESHES
    changes = _errors(cells, before.scatter, most)
    fitted = np.isfinite([before.observed, now.observed]).all()
    if fitted and before.vertices and (cells["before"] > ROUNDING).all():
        changes += [_order(before, now), _constant(cells, most, verdict.direction, parts)]
    return changes


def _cells(baseline: Stored, current: Stored, judged: ErrorVerdict, column: str) -> pd.DataFrame:
    """Errors ``before`` and ``now`` with h and tau at the judged cells that ended in both, and
    whether they are of the ``same_mesh``.

    All common cells if the baseline judged none; an error at rounding level counts as `ROUNDING`.
    """
    tables = [
        stored.records.loc[stored.records["status"] == "ok", [*CELL, "h", MESH, column]]
        for stored in (baseline, current)
    ]
    if judged.vertices:
        on_mesh = tables[0]["vertices"].isin(judged.vertices)
        tables[0] = tables[0][on_mesh & tables[0]["tau"].isin(judged.tau)]
    cells = tables[0].merge(tables[1].drop(columns="h"), on=CELL, suffixes=("_before", "_now"))
    cells = cells.rename(columns={f"{column}_before": "before", f"{column}_now": "now"})
    cells = cells[np.isfinite(cells["before"]) & np.isfinite(cells["now"])]
    return cells.assign(
        same_mesh=cells[f"{MESH}_before"] == cells[f"{MESH}_now"],
        before=np.maximum(cells["before"], ROUNDING),
        now=np.maximum(cells["now"], ROUNDING),
    )


def _errors(cells: pd.DataFrame, scatter: float, most: Most) -> list[Change]:
    """The geometric mean and the largest of the factors between errors at the same cells."""
    n, log = len(cells), np.log(cells["now"] / cells["before"]).to_numpy()
    before, now = (float(np.exp(np.log(cells[side]).mean())) for side in ("before", "now"))
    one = int(np.argmax(np.abs(log)))
    row, level = cells.iloc[one], level_tolerance(scatter, n, most)
    of_one = _factor(
        "one error", row["before"], row["now"], log[one], one_tolerance(scatter, n, most)
    )
    return [
        _factor("errors", before, now, log.mean(), level),
        replace(of_one, place=_cell(row["vertices"], row["tau"])),
    ]


def _order(before: ErrorVerdict, now: ErrorVerdict) -> Change:
    by, tolerance = now.observed - before.observed, order_tolerance(before, now)
    effect = _effect(-by, tolerance)
    told = f"{before.observed:.3f}", f"{now.observed:.3f}"
    return Change("order", *told, effect, by=by, tolerance=tolerance)


def _constant(
    cells: pd.DataFrame,
    most: Most,
    direction: Direction,
    parts: tuple[ErrorVerdict, ErrorVerdict],
) -> Change:
    """The fitted errors in the middle of the window."""
    before, now = parts
    middle = float(np.exp(np.log(cells[direction]).mean()))
    fitted = before.error_at(middle), now.error_at(middle)
    tolerance = level_tolerance(before.scatter, len(cells), most)
    change = _factor("constant", *fitted, np.log(fitted[1] / fitted[0]), tolerance)
    return replace(change, place=f"{direction} = {middle:.3g}")


def _factor(what: What, before: float, now: float, log: float, tolerance: float) -> Change:
    """A change of errors, from the logarithms of the factor and of its tolerance."""
    told, effect = (f"{before:.3g}", f"{now:.3g}"), _effect(log, tolerance)
    return Change(what, *told, effect, by=float(np.exp(log)), tolerance=float(np.exp(tolerance)))


def _effect(by: float, tolerance: float = 0.0) -> Effect:
    """Of something that is the worse the larger it is."""
    return "same" if abs(by) <= tolerance else "worse" if by > 0 else "better"
