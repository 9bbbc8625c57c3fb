"""The checks of sentences: each is a pure function of stored results.

The verdicts and their intervals are those that `results.verdicts` stored with each study, or finds
on the part of its grid that a sentence is read on; what is expected comes from its claim.
"""

from collections.abc import Callable
from math import isclose

import numpy as np
import pandas as pd

from esfem.campaigns.paper.stored_results import (
    Finding,
    Part,
    Row,
    finished,
    held,
    stopped_runs,
    within,
)
from esfem.flows.flow_results import CheckedFlow
from esfem.judging.outcome import worst
from esfem.meshes import surface_mesh
from esfem.reference_solutions import SOLUTIONS, CliffordTorus, ExactSolution
from esfem.results.study_result import StudyResult, series
from esfem.results.verdicts import Verdict
from esfem.studies.study import Study

RATIO = 2.0**-0.5  # of mesh widths whose numbers of vertices double
NO_RUN = "no run reaches T"

# Orders and bounds.


def orders(*found: StudyResult, variables: list[str]) -> Finding:
    """The verdicts of the studies on the variables: the worst of them."""
    chosen = [_of(result, variables) for result in found]
    rows = [v for own in chosen for v in own]
    expected = {f"{v.expected:g}" for v in rows if np.isfinite(v.expected)}
    unusual = [f"{v.variable} {v.verdict}" for v in rows if v.verdict not in ("pass", "super")]
    return Finding(
        "; ".join(map(_orders, chosen)),
        f"order {' and '.join(sorted(expected))} in h" if expected else "no order is claimed",
        worst(rows),
        f"not PASS: {', '.join(unusual)}" if unusual else "",
    )


def orders_by_step(found: StudyResult, variables: list[str]) -> Finding:
    """The verdicts on the variables on the line of each time step by itself: the worst of them."""
    lines = {
        tau: _of(within(found, Part(tau_from=tau, tau_to=tau)), variables)
        for tau in sorted(found.study.sweep.tau, reverse=True)
    }
    told = [f"tau = {t:g} {worst(own).upper()} ({_orders(own)})" for t, own in lines.items()]
    met = sum(worst(own) in ("pass", "super") for own in lines.values())
    verdict = worst(v for own in lines.values() for v in own)
    note = f"met by {met} of {len(lines)} lines"
    return Finding("; ".join(told), "the order on each line", verdict, note)


def bounded(found: StudyResult, variables: list[str]) -> Finding:
    """The verdict on errors that are to stay below a bound; which run counts the claim says."""
    chosen = _of(found, variables)
    told = [f"{v.variable}: {v.reason}" for v in chosen]
    bound = " and ".join(f"at most {limit:g}" for limit in sorted({v.limit for v in chosen}))
    return Finding("; ".join(told), bound, worst(chosen))


def exceeds(*found: StudyResult, variables: list[str]) -> Finding:
    """Whether some order lies above the claimed one, with its whole interval, tolerance added."""
    rows = [v for result in found for v in _of(result, variables)]
    known = [v for v in rows if np.isfinite(v.lower) and np.isfinite(v.expected)]
    if not known:
        return Finding("no order was observed", "an order above the claim", "inconclusive")
    above = dict.fromkeys(v.study for v in known if v.lower > v.expected + v.tolerance)
    best = max(known, key=lambda v: v.lower)
    expected = f"some order above {best.expected:g} + {best.tolerance:g}"
    note = f"exceeded in {', '.join(above)}" if above else "matched, nowhere exceeded"
    return Finding(f"{best.study}: {_order(best)}", expected, held(bool(above)), note)


def at_least(
    found: StudyResult, variables: list[str], below_degree: int, tolerance: float
) -> Finding:
    """Whether no order is below k - ``below_degree``, by its interval."""
    order = found.study.scheme.degree - below_degree
    rows = _of(found, variables)
    expected = f"order {order} at least"
    lacking = [v.variable for v in rows if not np.isfinite(v.lower)]
    if lacking:
        note = f"no order observed of {', '.join(lacking)}"
        return Finding(_orders(rows), expected, "inconclusive", note)
    return Finding(_orders(rows), expected, held(all(v.lower >= order - tolerance for v in rows)))


def observed(*found: StudyResult, variables: list[str]) -> Finding:
    """The orders where none is claimed."""
    told = "; ".join(_orders(_of(result, variables)) for result in found)
    return Finding(told, "no order is claimed", "no claim")


def _of(result: StudyResult, variables: list[str]) -> list[Verdict]:
    by_name = {v.variable: v for v in result.verdicts}
    return [by_name[name] for name in variables]


def _orders(rows: list[Verdict]) -> str:
    return ", ".join(map(_order, rows))


def _order(v: Verdict) -> str:
    """For example "x 2.12 [2.00, 2.20]"."""
    if not np.isfinite(v.observed):
        return f"{v.variable} {v.verdict}"
    return f"{v.variable} {v.observed:.2f} [{v.lower:.2f}, {v.upper:.2f}]"


# Single runs: which error they have, which of them end early, and how.


def space_dominates(found: StudyResult, variables: list[str], share: float) -> Finding:
    """What halving the finest time step changes in an error, relative: less than ``share``, where
    the error in space dominates. It has to on every mesh; the note tells of the finest one."""
    rows = _halvings(found, variables)
    expected = f"an error changes by less than {share:g} of itself when tau is halved"
    if rows.empty:
        return Finding("no mesh with two finished time steps", expected, "inconclusive")
    most = rows.loc[rows["change"].idxmax()]
    below = (rows["change"] < share).sum()
    finest = rows.loc[rows["V"] == rows["V"].iloc[-1], "change"].max()
    measured = f"{most.change:.2g} ({most.variable}, V = {most.V}, to tau = {most.tau:g})"
    note = f"{below} of {len(rows)} errors change by less; on the finest mesh {finest:.2g} at most"
    return Finding(measured, expected, held(most.change < share), note)


def _halvings(result: StudyResult, variables: list[str]) -> pd.DataFrame:
    """The relative change of each error over the two finest finished steps on each mesh."""
    rows = []
    for _, runs in series(finished(result), "tau"):
        if len(runs) < 2:
            continue
        coarse, fine = runs.iloc[-2], runs.iloc[-1]
        for name in variables:
            e, half = float(coarse[f"err_{name}"]), float(fine[f"err_{name}"])
            # An error that is zero at both steps does not change; from zero, all of it is new.
            change = abs(e - half) / half if half > 0 else 0.0 if e == half else np.inf
            where = {"V": int(fine["vertices"]), "tau": float(fine["tau"])}
            rows.append({**where, "variable": name, "change": change})
    return pd.DataFrame(rows)


def never_exceeds_space(found: StudyResult, variables: list[str]) -> Finding:
    """Whether on each mesh, at every time step, the error in time, which is what an error has above
    the least one of its mesh, is smaller than that least one. A run that stops early has none."""
    expected = "on each mesh the largest error over the time steps is below twice the least one"
    ended = finished(found)
    if ended.empty:
        return Finding(NO_RUN, expected, "inconclusive")
    stopped = len(found.records) - len(ended)
    ratios = [
        (float(runs[f"err_{name}"].max() / runs[f"err_{name}"].min()), name, int(vertices))
        for vertices, runs in ended.groupby("vertices")
        for name in variables
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


# The setting of section 7: surfaces, energies, meshes, time steps.


def _exact(study: Study) -> ExactSolution:
    return SOLUTIONS[study.solution.name](**study.solution.parameters)


def printed_energy(found: StudyResult, printed: str) -> Finding:
    """Whether the exact W agrees with the printed digits."""
    digits = len(printed.partition(".")[2])
    W = f"{_exact(found.study).willmore(0.0):.{digits}f}"
    return Finding(W, printed, held(W == printed))


def final_energy(found: StudyResult, bound: float) -> Finding:
    """Whether W_h(T) is near the exact W at the finest step on the finest mesh: relative error."""
    exact = _exact(found.study).willmore(found.study.sweep.final_time)
    finest = found.records["vertices"].max()
    runs = finished(found).query("vertices == @finest").sort_values("tau")
    expected = f"{exact:.4f}, relative error {bound:g} at most"
    if runs.empty:
        return Finding(f"{NO_RUN} on V = {finest}", expected, "inconclusive")
    errors = (runs["willmore_T"] / exact - 1.0).abs()
    run, error, best = runs.iloc[0], errors.iloc[0], runs.loc[errors.idxmin()]
    where = f"V = {finest}, tau = {run['tau']:g}"
    measured = f"{run['willmore_T']:.4f} ({where}), relative error {error:.1e}"
    note = f"nearest there: {best['willmore_T']:.4f} at tau = {best['tau']:g}"
    return Finding(measured, expected, held(error <= bound), note)


def rests_exactly(found: StudyResult, bound: float) -> Finding:
    """Whether the exact velocity V vanishes on the surface, to rounding."""
    solution = _exact(found.study)
    p = surface_mesh(solution.mesh_surface, max(found.study.sweep.vertices)).vertices
    p = solution.closest_point(solution.scale * p, 0.0)
    speed = float(np.abs(solution.fields(p, 0.0).V).max())
    return Finding(f"max |V| = {speed:.1e}", f"{bound:g} at most", held(speed <= bound))


def moves_discretely(found: StudyResult, bound: float) -> Finding:
    """Whether the discrete surface moves, on the finest mesh that finished, by more than rounding;
    the exact v is 0, so the error of v is the discrete velocity."""
    expected = f"v_h above {bound:g} in H^1"
    ended = finished(found).sort_values(["vertices", "tau"], ascending=[False, True])
    if ended.empty:
        return Finding(NO_RUN, expected, "inconclusive")
    run = ended.iloc[0]
    measured = f"{run['err_v']:.1e} (V = {run['vertices']}, tau = {run['tau']:g})"
    return Finding(measured, expected, held(run["err_v"] > bound))


def mesh_widths(*found: StudyResult, tolerance: float) -> Finding:
    """Whether h falls by 2^-1/2 from mesh to mesh, in each study."""
    widths = [result.records.groupby("vertices")["h"].first().to_numpy() for result in found]
    ratios = np.concatenate([h[1:] / h[:-1] for h in widths])
    holds = bool((np.abs(ratios / RATIO - 1.0) <= tolerance).all())
    measured = f"{ratios.min():.3f} to {ratios.max():.3f}"
    return Finding(measured, f"{RATIO:.3f}, relative {tolerance:g}", held(holds))


def time_steps(*found: StudyResult, first: float) -> Finding:
    """Whether the steps start from the first and are halved."""
    steps = [sorted(result.study.sweep.tau, reverse=True) for result in found]
    ends = {f"{taus[0]:g} to {taus[-1]:g}, {len(taus)} steps" for taus in steps}
    holds = all(
        np.allclose(taus, first / 2.0 ** np.arange(len(taus)), rtol=1e-12, atol=0) for taus in steps
    )
    return Finding("; ".join(sorted(ends)), f"{first:g} 2^-j", held(holds))


def radii(found: StudyResult, squared: float, bound: float) -> Finding:
    """Whether (R/r)^2 of the torus is the one that is named."""
    solution, expected = found.study.initial, f"(R/r)^2 = {squared:g}"
    if not isinstance(solution, CliffordTorus):
        return Finding(solution.title, expected, "fail", "no torus")
    R, r = solution.torus.R, solution.torus.r
    ratio = (R / r) ** 2
    measured = f"R = {R:g}, r = {r:.6f}, (R/r)^2 = {ratio:.12g}"
    return Finding(measured, expected, held(abs(ratio - squared) <= bound))


def graded(found: StudyResult, part: float) -> Finding:
    """Whether edges near the hole are shorter: mean length over the nearest ``part`` of all edges,
    against that over the farthest; the largest such ratio over the meshes of the study."""
    name = found.study.initial.mesh_surface
    ratios = {v: _inner_to_outer(name, v, part) for v in found.study.sweep.vertices}
    largest = max(ratios, key=ratios.__getitem__)
    measured = f"ratio {min(ratios.values()):.2f} to {ratios[largest]:.2f} (V = {largest})"
    return Finding(measured, "below 1 on each mesh", held(ratios[largest] < 1.0))


def _inner_to_outer(name: str, vertices: int, part: float) -> float:
    mesh = surface_mesh(name, vertices)
    pairs = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    ends = mesh.vertices[np.unique(np.sort(pairs, axis=1), axis=0)]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    ordered = length[np.argsort(np.linalg.norm(ends.mean(axis=1)[:, :2], axis=1))]
    count = max(1, int(part * len(ordered)))
    return float(ordered[:count].mean() / ordered[-count:].mean())


# The evolutions, and the effect of the projections.


def flow_setting(
    found: CheckedFlow, nodes: int, first: float, halvings: int, final_time: float
) -> Finding:
    """Whether the flow has so many nodes, this time step, and reached its end."""
    tau, time = first / 2**halvings, found.flow.time
    same_time = isclose(time.tau, tau) and time.final_time == final_time
    holds = same_time and (found.nodes, found.status) == (nodes, "ok")
    measured = _setting(found.nodes, time.tau, time.final_time, found.status)
    return Finding(measured, _setting(nodes, tau, final_time, "ok"), held(holds))


def _setting(nodes: int, tau: float, final_time: float, status: str) -> str:
    return f"{nodes} nodes, tau = {tau:.9g}, T = {final_time:g}, {status}"


def flow_checks(found: CheckedFlow, names: list[str]) -> Finding:
    """The checks of the flow whose names start so: all must hold."""
    chosen = [c for c in found.checks if c.name.startswith(tuple(names))]
    lacking = [name for name in names if not any(c.name.startswith(name) for c in chosen)]
    if lacking:
        note = found.reason or f"not checked: {', '.join(lacking)}"
        return Finding("nothing", ", ".join(names), "inconclusive", note)
    measured = "; ".join(c.text for c in chosen)
    expected = ", ".join(f"{c.name} within {c.bound:g}" for c in chosen)
    return Finding(measured, expected, held(worst(chosen) == "pass"))


def nodes(found: list[Row], count: int) -> Finding:
    """Whether the runs have so many nodes."""
    counts = {row["nodes"] for row in found}
    return Finding(", ".join(map(str, sorted(counts))), str(count), held(counts == {count}))


def normals_deviate(found: list[Row], bound: float) -> Finding:
    """Without projections the length of nu_h leaves 1 by more than ``bound``."""
    row = _row(found, "without")
    measured = f"|nu_h| in [{row['least |nu|']:.6f}, {row['greatest |nu|']:.6f}]"
    return Finding(measured, f"off 1 by more than {bound:g}", held(_off(row, "|nu|") > bound))


def normals_kept(found: list[Row], bound: float) -> Finding:
    """With projections the length of nu_h stays at 1, to rounding."""
    off = _off(_row(found, "with"), "|nu|")
    return Finding(f"||nu_h| - 1| <= {off:.1e}", f"{bound:g} at most", held(off <= bound))


def stays_nearer(found: list[Row], quantity: str) -> Finding:
    """Whether the projections bring a quantity nearer to its exact value, at all times."""
    off, kept = (_off(_row(found, which), quantity) for which in ("without", "with"))
    measured = f"off by {kept:.1e} with, by {off:.1e} without"
    return Finding(measured, "nearer with projections", held(kept < off))


def _row(found: list[Row], projections: str) -> Row:
    (row,) = (row for row in found if row["projections"] == projections)
    return row


def _off(row: Row, quantity: str) -> float:
    exact = row[f"exact {quantity}"]
    return max(abs(float(row[f"{end} {quantity}"] - exact)) for end in ("least", "greatest"))


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
