"""Checks of sentences about the setting of section 7, the evolutions and the projections."""

from math import isclose

import numpy as np

from esfem.campaigns.paper.stored_results import (
    NO_RUN,
    Finding,
    Row,
    finished,
    held,
)
from esfem.flows.flow_results import CheckedFlow
from esfem.judging.outcome import worst
from esfem.meshes import surface_mesh
from esfem.reference_solutions import SOLUTIONS, CliffordTorus, ExactSolution
from esfem.results.study_result import StudyResult
from esfem.studies.study import Study

RATIO = 2.0**-0.5  # of mesh widths whose numbers of vertices double


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
