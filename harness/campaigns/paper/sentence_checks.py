"""The checks of sentences: each is a pure function of stored results.

The verdicts and their intervals are those that `results.verdicts` stored with each study, or finds
on the part of its grid that a sentence is read on; what is expected comes from its claim. With
``error`` a check is about that error of the variables alone, u_h - u or u_h - I_h u; without it
about what `Verdict` makes of both, as a theorem is.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from esfem.campaigns.paper.setting_checks import (
    final_energy,
    flow_checks,
    flow_setting,
    graded,
    mesh_widths,
    moves_discretely,
    nodes,
    normals_deviate,
    normals_kept,
    printed_energy,
    radii,
    rests_exactly,
    stays_nearer,
    time_steps,
)
from esfem.campaigns.paper.stored_results import (
    NO_RUN,
    Finding,
    Missing,
    Part,
    Row,
    finished,
    held,
    stopped_runs,
    within,
)
from esfem.judging.outcome import worst
from esfem.results.error_verdicts import PREFIXES, WORDS, ErrorName, ErrorVerdict
from esfem.results.study_result import StudyResult, series
from esfem.results.verdicts import Verdict

# Orders and bounds.


def orders(*found: StudyResult, variables: list[str], error: ErrorName | None = None) -> Finding:
    """The verdicts of the studies on the variables: the worst of them."""
    chosen = [_of(result, variables, error) for result in found]
    rows = [v for own in chosen for v in own]
    expected = {f"{v.expected:g}" for v in rows if np.isfinite(v.expected)}
    return Finding(
        "; ".join(map(_orders, chosen)),
        f"order {' and '.join(sorted(expected))} in h" if expected else "no order is claimed",
        worst(rows),
        "; ".join([*_not_met(rows), *_next_runs(rows)]),
    )


def orders_by_step(found: StudyResult, variables: list[str], error: ErrorName) -> Finding:
    """The verdicts on the variables on the line of each time step by itself: the worst of them."""
    lines = {
        tau: _of(within(found, Part(tau_from=tau, tau_to=tau)), variables, error)
        for tau in sorted(found.study.sweep.tau, reverse=True)
    }
    told = [f"tau = {t:g} {worst(own).upper()} ({_orders(own)})" for t, own in lines.items()]
    met = sum(worst(own) in ("pass", "super") for own in lines.values())
    rows = [v for own in lines.values() for v in own]
    notes = [f"met by {met} of {len(lines)} lines", *_next_runs(rows)]
    return Finding("; ".join(told), "the order on each line", worst(rows), "; ".join(notes))


def _not_met(rows: Sequence[Verdict]) -> list[str]:
    """What does not hold, by verdict and study."""
    named: dict[tuple[str, str], list[str]] = {}
    for v in rows:
        if v.verdict not in ("pass", "super"):
            named.setdefault((v.verdict, v.study), []).append(v.variable)
    return [
        f"{outcome.upper()}: {', '.join(names)} of {study}"
        for (outcome, study), names in named.items()
    ]


def _next_runs(rows: Sequence[Verdict]) -> list[str]:
    """The runs that would decide, with their estimated time; none unless all together is
    inconclusive."""
    wanted: dict[tuple[str, str], list[str]] = {}
    for v in rows if worst(rows) == "inconclusive" else ():
        if v.verdict == "inconclusive" and v.next_run:
            wanted.setdefault((v.study, v.next_run), []).append(v.variable)
    return [
        f"{', '.join(names)} of {study} would be decided by {run}"
        for (study, run), names in wanted.items()
    ]


def bounded(found: StudyResult, variables: list[str]) -> Finding:
    """The verdict on errors that are to stay below a bound; which run counts the claim says."""
    chosen = _of(found, variables)
    told = [f"{v.variable}: {v.reason}" for v in chosen]
    bound = " and ".join(f"at most {limit:g}" for limit in sorted({v.limit for v in chosen}))
    return Finding("; ".join(told), bound, worst(chosen), "; ".join(_next_runs(chosen)))


def exceeds(*found: StudyResult, variables: list[str], error: ErrorName) -> Finding:
    """Whether some order that was exercised lies above the claimed one, with its whole interval,
    tolerance added."""
    chosen = [_of(result, variables, error) for result in found]
    every = [v for own in chosen for v in own]
    if worst(every) == "not exercised":
        told = "; ".join(map(_orders, chosen))
        return Finding(
            told, "an order above the claim", "not exercised", "; ".join(_not_met(every))
        )
    rows = [(v, p) for v in every for p in _exercised(v) if p.outcome != "not exercised"]
    known = [(v, p) for v, p in rows if np.isfinite(p.lower) and np.isfinite(v.expected)]
    if not known:
        return Finding("no order was observed", "an order above the claim", "inconclusive")
    above = dict.fromkeys(v.study for v, p in known if p.lower > v.expected + v.tolerance)
    best, _ = max(known, key=lambda pair: pair[1].lower)
    expected = f"some order above {best.expected:g} + {best.tolerance:g}"
    note = f"exceeded in {', '.join(above)}" if above else "matched, nowhere exceeded"
    return Finding(f"{best.study}: {_order(best)}", expected, held(bool(above)), note)


def at_least(
    found: StudyResult, variables: list[str], below_degree: int, tolerance: float
) -> Finding:
    """Whether no order, of neither error, is below k - ``below_degree``, by its interval."""
    order = found.study.scheme.degree - below_degree
    rows = _of(found, variables)
    expected = f"order {order} at least"
    parts = [part for v in rows for part in _exercised(v)]
    lacking = [v.variable for v in rows if not all(np.isfinite(p.lower) for p in _exercised(v))]
    if lacking:
        note = f"no order observed of {', '.join(lacking)}"
        return Finding(_orders(rows), expected, "inconclusive", note)
    return Finding(_orders(rows), expected, held(all(p.lower >= order - tolerance for p in parts)))


def observed(*found: StudyResult, variables: list[str]) -> Finding:
    """The orders where none is claimed."""
    told = "; ".join(_orders(_of(result, variables)) for result in found)
    return Finding(told, "no order is claimed", "no claim")


def _of(result: StudyResult, variables: list[str], error: ErrorName | None = None) -> list[Verdict]:
    """The verdicts on the variables, or on that error of theirs alone."""
    by_name = {v.variable: v for v in result.verdicts}
    chosen = [by_name[name] for name in variables]
    return chosen if error is None else [_alone(v, error) for v in chosen]


def _alone(v: Verdict, error: ErrorName) -> Verdict:
    """The verdict on that error alone; `Missing` if it was not judged."""
    parts = tuple(part for part in v.parts if part.name == error)
    if not parts:
        raise Missing(f"study {v.study} has no {WORDS[error]} of {v.variable}")
    return replace(v, parts=parts)


def _columns(result: StudyResult, variables: list[str], error: ErrorName) -> dict[str, str]:
    """The column of that error by variable; `Missing` if it was not measured."""
    columns = {name: f"{PREFIXES[error]}{name}" for name in variables}
    for name, column in columns.items():
        if column not in result.records:
            raise Missing(f"study {result.study.name} has no {WORDS[error]} of {name}")
    return columns


def _orders(rows: list[Verdict]) -> str:
    return ", ".join(map(_order, rows))


def _exercised(v: Verdict) -> list[ErrorVerdict]:
    """The errors of the variable that say something; the first if none does."""
    return [part for part in v.parts if part.outcome != "not exercised"] or [v.parts[0]]


def _order(v: Verdict) -> str:
    """For example "x 2.12 [2.00, 2.20], against the interpolation 4.00 [3.90, 4.10]"."""
    told = []
    for part in _exercised(v):
        numbers = f"{part.observed:.2f} [{part.lower:.2f}, {part.upper:.2f}]"
        said = numbers if np.isfinite(part.observed) else part.outcome
        told.append(f"against the interpolation {said}" if part.name == "interpolation" else said)
    return f"{v.variable} {', '.join(told)}"


# Single runs: which error they have, which of them end early, and how.


def space_dominates(
    found: StudyResult, variables: list[str], share: float, error: ErrorName
) -> Finding:
    """What halving the finest time step changes in an error, relative: less than ``share``, where
    the error in space dominates. It has to on every mesh; the note tells of the finest one."""
    rows = _halvings(found, _columns(found, variables, error))
    expected = f"an error changes by less than {share:g} of itself when tau is halved"
    if rows.empty:
        return Finding("no mesh with two finished time steps", expected, "inconclusive")
    most = rows.loc[rows["change"].idxmax()]
    below = (rows["change"] < share).sum()
    finest = rows.loc[rows["V"] == rows["V"].iloc[-1], "change"].max()
    measured = f"{most.change:.2g} ({most.variable}, V = {most.V}, to tau = {most.tau:g})"
    note = f"{below} of {len(rows)} errors change by less; on the finest mesh {finest:.2g} at most"
    return Finding(measured, expected, held(most.change < share), note)


def _halvings(result: StudyResult, columns: dict[str, str]) -> pd.DataFrame:
    """The relative change of each error over the two finest finished steps on each mesh."""
    rows = []
    for _, runs in series(finished(result), "tau"):
        if len(runs) < 2:
            continue
        coarse, fine = runs.iloc[-2], runs.iloc[-1]
        for name, column in columns.items():
            e, half = float(coarse[column]), float(fine[column])
            change = abs(_ratio(e, half) - 1.0)
            where = {"V": int(fine["vertices"]), "tau": float(fine["tau"])}
            rows.append({**where, "variable": name, "change": change})
    return pd.DataFrame(rows)


def _ratio(e: float, other: float) -> float:
    """Of two errors: 1 of zeros, which are the same, and infinite if the other alone is zero."""
    return float(e / other) if other > 0 else 1.0 if e == other else np.inf


def never_exceeds_space(found: StudyResult, variables: list[str], error: ErrorName) -> Finding:
    """Whether on each mesh, at every time step, the error in time, which is what an error has above
    the least one of its mesh, is smaller than that least one. A run that stops early has none."""
    expected = "on each mesh the largest error over the time steps is below twice the least one"
    columns = _columns(found, variables, error)
    ended = finished(found)
    if ended.empty:
        return Finding(NO_RUN, expected, "inconclusive")
    stopped = len(found.records) - len(ended)
    ratios = [
        (_ratio(runs[column].max(), runs[column].min()), name, int(vertices))
        for vertices, runs in ended.groupby("vertices")
        for name, column in columns.items()
    ]
    above = [row for row in ratios if row[0] >= 2.0]
    ratio, name, vertices = max(ratios)
    measured = f"ratio {ratio:.2f} at most ({name}, V = {vertices})"
    told = ", ".join(f"{name} on V = {vertices} ({ratio:.2f})" for ratio, name, vertices in above)
    notes = [f"above: {told}"] if above else []
    notes += [f"{stopped} of {len(found.records)} runs stop early"] if stopped else []
    return Finding(measured, expected, held(not above and not stopped), "; ".join(notes))


def all_finish(*found: StudyResult) -> Finding:
    """Whether every run reaches the final time."""
    records = pd.concat([result.records for result in found])
    ended = int((records["status"] == "ok").sum())
    measured = f"{ended} of {len(records)} runs reach T"
    return Finding(measured, "all of them", held(ended == len(records)), stopped_runs(records))


def stops(found: StudyResult) -> Finding:
    """Which runs stop early, and when, where the paper says nothing."""
    told = stopped_runs(found.records) or "all runs reach T"
    return Finding(told, "the paper names no run that stops", "no claim")


def growth(found: list[Row], rate: float) -> Finding:
    """The rate at which each run that does so leaves a surface at rest, where the paper says
    nothing; ``rate`` is one that was measured earlier."""
    told: dict[str, list[str]] = {}
    for row in found:
        if row["rate"] is not None:
            of_step = told.setdefault(f"BDF{row['BDF']}, tau = {row['tau']:g}", [])
            of_step.append(f"{row['rate']:.1f} on V = {row['V']}")
    rates = "; ".join(f"{step}: {', '.join(of_step)}" for step, of_step in told.items())
    measured = f"e^(rate t) with {rates}" if told else "no run grows"
    return Finding(measured, f"e^({rate:g} t)", "no claim")


def more_runs_finish(found: StudyResult, other: StudyResult) -> Finding:
    """Whether more runs of the first study than of the second one reach the final time, on the
    grid that they share."""
    both = pd.merge(found.records, other.records, on=["vertices", "tau"], suffixes=("", "_other"))
    mine, theirs = both["status"] == "ok", both["status_other"] == "ok"
    names = [f"BDF{result.study.scheme.order}" for result in (found, other)]
    measured = f"{names[0]} finishes {mine.sum()}, {names[1]} {theirs.sum()} of {len(both)} runs"
    note = f"{(theirs & ~mine).sum()} of those that {names[1]} finishes {names[0]} does not"
    return Finding(measured, f"more with {names[0]}", held(mine.sum() > theirs.sum()), note)


# What a sentence may name.
CHECKS: dict[str, Callable[..., Finding]] = {
    check.__name__: check
    for check in (
        *(orders, orders_by_step, bounded, exceeds, at_least, observed),
        *(space_dominates, never_exceeds_space, more_runs_finish, all_finish, stops, growth),
        *(printed_energy, final_energy, rests_exactly, moves_discretely),
        *(mesh_widths, time_steps, radii, graded),
        *(flow_setting, flow_checks, nodes, normals_deviate, normals_kept, stays_nearer),
    )
}
