"""Checks of sentences about single runs: which error they have, which of them end early, and how.

Each is a pure function of stored results.
"""

import numpy as np
import pandas as pd

from esfem.campaigns.paper.sources import Finding, StudyData, Table, held, stopped_runs
from esfem.results.study_result import series


def space_dominates(found: StudyData, variables: list[str], share: float) -> Finding:
    """What halving the finest time step changes in an error, relative: less than ``share``, where
    the error in space dominates. It has to on every mesh; the note tells of the finest one."""
    rows = _halvings(found, variables)
    expected = f"an error changes by less than {share:g} of itself when tau is halved"
    if not rows:
        return Finding("no mesh with two finished time steps", expected, "inconclusive")
    vertices, variable, tau, change = max(rows, key=lambda row: row[-1])
    below = sum(row[-1] < share for row in rows)
    finest = max(row[-1] for row in rows if row[0] == rows[-1][0])
    measured = f"{change:.2g} ({variable}, V = {vertices}, to tau = {tau:g})"
    note = f"{below} of {len(rows)} errors change by less; on the finest mesh {finest:.2g} at most"
    return Finding(measured, expected, held(change < share), note)


def _halvings(data: StudyData, variables: list[str]) -> list[tuple[int, str, float, float]]:
    """V, variable, tau, relative change, of the two finest finished steps on each mesh."""
    rows = []
    for _, runs in series(data.finished, "tau"):
        if len(runs) < 2:
            continue
        coarse, fine = runs.iloc[-2], runs.iloc[-1]
        for name in variables:
            e, half = float(coarse[f"err_{name}"]), float(fine[f"err_{name}"])
            # An error that is zero at both steps does not change; from zero, all of it is new.
            change = abs(e - half) / half if half > 0 else 0.0 if e == half else np.inf
            rows.append((int(fine["vertices"]), name, float(fine["tau"]), change))
    return rows


def never_exceeds_space(found: StudyData, variables: list[str]) -> Finding:
    """Whether on each mesh, at every time step, the error in time, which is what an error has above
    the least one of its mesh, is smaller than that least one. A run that stops early has none."""
    expected = "on each mesh the largest error over the time steps is below twice the least one"
    if found.finished.empty:
        return Finding("no run reaches T", expected, "inconclusive")
    stopped = len(found.records) - len(found.finished)
    ratios = [
        (float(runs[f"err_{name}"].max() / runs[f"err_{name}"].min()), name, int(vertices))
        for vertices, runs in found.finished.groupby("vertices")
        for name in variables
    ]
    above = [row for row in ratios if row[0] >= 2.0]
    ratio, name, vertices = max(ratios)
    measured = f"ratio {ratio:.2f} at most ({name}, V = {vertices})"
    told = ", ".join(f"{name} on V = {vertices} ({ratio:.2f})" for ratio, name, vertices in above)
    notes = [f"above: {told}"] if above else []
    notes += [f"{stopped} of {len(found.records)} runs stop early"] if stopped else []
    return Finding(measured, expected, held(not above and not stopped), "; ".join(notes))


def all_finish(*found: StudyData) -> Finding:
    """Whether every run reaches the final time."""
    records = pd.concat([data.records for data in found])
    ended = int((records["status"] == "ok").sum())
    measured = f"{ended} of {len(records)} runs reach T"
    return Finding(measured, "all of them", held(ended == len(records)), stopped_runs(records))


def stops(found: StudyData) -> Finding:
    """Which runs stop early, and when, where the paper says nothing."""
    told = stopped_runs(found.records) or "all runs reach T"
    return Finding(told, "the paper names no run that stops", "no claim")


def growth(found: Table, rate: float) -> Finding:
    """The rate at which each run that does so leaves a surface at rest, where the paper says
    nothing; ``rate`` is one that was measured earlier."""
    rows = [row for row in found.rows if row["rate"] is not None]
    if not rows:
        return Finding("no run grows", f"e^({rate:g} t)", "no claim")
    told: dict[str, list[str]] = {}
    for row in rows:
        of_step = told.setdefault(f"BDF{row['BDF']}, tau = {row['tau']:g}", [])
        of_step.append(f"{row['rate']:.1f} on V = {row['V']}")
    measured = "; ".join(f"{step}: {', '.join(rates)}" for step, rates in told.items())
    return Finding(f"e^(rate t) with {measured}", f"e^({rate:g} t)", "no claim")


def more_runs_finish(found: StudyData, other: StudyData) -> Finding:
    """Whether more runs of the first study than of the second one reach the final time, on the
    grid that they share."""
    both = pd.merge(found.records, other.records, on=["vertices", "tau"], suffixes=("", "_other"))
    mine, theirs = (int((both[c] == "ok").sum()) for c in ("status", "status_other"))
    names = [f"BDF{data.study.scheme.bdf}" for data in (found, other)]
    measured = f"{names[0]} finishes {mine}, {names[1]} {theirs} of {len(both)} runs"
    only = both[(both["status"] != "ok") & (both["status_other"] == "ok")]
    note = f"{len(only)} of those that {names[1]} finishes {names[0]} does not"
    return Finding(measured, f"more with {names[0]}", held(mine > theirs), note)


CHECKS = (space_dominates, never_exceeds_space, more_runs_finish, all_finish, stops, growth)
