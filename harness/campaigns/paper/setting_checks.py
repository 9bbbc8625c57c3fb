"""Checks of sentences about the setting of section 7: surfaces, energies, meshes, time steps."""

import numpy as np

from esfem.campaigns.paper.sources import Finding, StudyData, held
from esfem.meshes import surface_mesh

RATIO = 2.0**-0.5  # of mesh widths whose numbers of vertices double


def printed_energy(found: StudyData, printed: str) -> Finding:
    """Whether the exact W agrees with the printed digits."""
    W = found.study.initial.willmore(0.0)
    digits = len(printed.partition(".")[2])
    return Finding(f"{W:.{digits}f}", printed, held(f"{W:.{digits}f}" == printed))


def final_energy(found: StudyData, bound: float) -> Finding:
    """Whether W_h(T) is near the exact W at the finest step on the finest mesh: relative error."""
    exact = found.study.initial.willmore(found.study.sweep.final_time)
    finest = found.records["vertices"].max()
    runs = found.finished[found.finished["vertices"] == finest].sort_values("tau")
    expected = f"{exact:.4f}, relative error {bound:g} at most"
    if runs.empty:
        return Finding(f"no run reaches T on V = {finest}", expected, "inconclusive")
    errors = (runs["willmore_T"] / exact - 1.0).abs()
    run, error, best = runs.iloc[0], errors.iloc[0], runs.loc[errors.idxmin()]
    where = f"V = {finest}, tau = {run['tau']:g}"
    measured = f"{run['willmore_T']:.4f} ({where}), relative error {error:.1e}"
    note = f"nearest there: {best['willmore_T']:.4f} at tau = {best['tau']:g}"
    return Finding(measured, expected, held(error <= bound), note)


def rests_exactly(found: StudyData, bound: float) -> Finding:
    """Whether the exact velocity V vanishes on the surface, to rounding."""
    solution = found.study.initial
    p = surface_mesh(solution.mesh_surface, max(found.study.sweep.vertices)).vertices
    p = solution.closest_point(solution.scale * p, 0.0)
    speed = float(np.abs(solution.fields(p, 0.0).V).max())
    return Finding(f"max |V| = {speed:.1e}", f"{bound:g} at most", held(speed <= bound))


def moves_discretely(found: StudyData, bound: float) -> Finding:
    """Whether the discrete surface moves, on the finest mesh that finished, by more than rounding;
    the exact v is 0, so the error of v is the discrete velocity."""
    expected = f"v_h above {bound:g} in H^1"
    if found.finished.empty:
        return Finding("no run reaches T", expected, "inconclusive")
    run = found.finished.sort_values(["vertices", "tau"], ascending=[False, True]).iloc[0]
    measured = f"{run['err_v']:.1e} (V = {run['vertices']}, tau = {run['tau']:g})"
    return Finding(measured, expected, held(run["err_v"] > bound))


def mesh_widths(*found: StudyData, tolerance: float) -> Finding:
    """Whether h falls by 2^-1/2 from mesh to mesh, in each study."""
    ratios = []
    for data in found:
        h = data.records.groupby("vertices")["h"].first().to_numpy()
        ratios += list(h[1:] / h[:-1])
    worst = max(ratios, key=lambda ratio: abs(ratio / RATIO - 1.0))
    measured = f"{min(ratios):.3f} to {max(ratios):.3f}"
    holds = abs(worst / RATIO - 1.0) <= tolerance
    return Finding(measured, f"{RATIO:.3f}, relative {tolerance:g}", held(holds))


def time_steps(*found: StudyData, first: float) -> Finding:
    """Whether the steps start from the first and are halved."""
    steps = [sorted(data.study.sweep.tau, reverse=True) for data in found]
    exact = [[first / 2**j for j in range(len(taus))] for taus in steps]
    ends = {f"{taus[0]:g} to {taus[-1]:g}, {len(taus)} steps" for taus in steps}
    holds = all(
        np.allclose(taus, e, rtol=1e-12, atol=0) for taus, e in zip(steps, exact, strict=True)
    )
    return Finding("; ".join(sorted(ends)), f"{first:g} 2^-j", held(holds))


def radii(found: StudyData, squared: float, bound: float) -> Finding:
    """Whether (R/r)^2 of the torus is the one that is named."""
    torus = found.study.initial.torus
    ratio = (torus.R / torus.r) ** 2
    measured = f"R = {torus.R:g}, r = {torus.r:.6f}, (R/r)^2 = {ratio:.12g}"
    return Finding(measured, f"(R/r)^2 = {squared:g}", held(abs(ratio - squared) <= bound))


def graded(found: StudyData, part: float) -> Finding:
    """Whether edges near the hole are shorter: mean length over the nearest ``part`` of all edges,
    against that over the farthest; the largest such ratio over the meshes of the study."""
    name = found.study.initial.mesh_surface
    ratios = {v: _inner_to_outer(name, v, part) for v in found.study.sweep.vertices}
    worst = max(ratios, key=ratios.__getitem__)
    measured = f"ratio {min(ratios.values()):.2f} to {ratios[worst]:.2f} (V = {worst})"
    return Finding(measured, "below 1 on each mesh", held(ratios[worst] < 1.0))


def _inner_to_outer(name: str, vertices: int, part: float) -> float:
    mesh = surface_mesh(name, vertices)
    pairs = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    ends = mesh.vertices[np.unique(np.sort(pairs, axis=1), axis=0)]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    ordered = length[np.argsort(np.linalg.norm(ends.mean(axis=1)[:, :2], axis=1))]
    count = max(1, int(part * len(ordered)))
    return float(ordered[:count].mean() / ordered[-count:].mean())


CHECKS = (
    *(printed_energy, final_energy, rests_exactly, moves_discretely),
    *(mesh_widths, time_steps, radii, graded),
)
