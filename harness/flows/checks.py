"""What a flow was expected to do, and whether it did: one line each."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.flows.evolution import Outcome
from harness.flows.flow_file import ENDS, FlowFile
from harness.flows.frames import read_frame
from harness.flows.history import History
from reference_solutions import SurfaceFlow

LEVEL = {"sphere": 8.0 * np.pi, "clifford_torus": 4.0 * np.pi**2}
# The Krylov iteration of a step stops at 1e-10 of w; an increase of W below this is no increase.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Check:
    """``verdict`` is pass or fail, ``measured`` the number that must be at most ``bound``."""

    name: str
    verdict: str
    measured: float
    bound: float
    text: str


def checked(flow: FlowFile, outcome: Outcome, history: History, folder: Path) -> list[Check]:
    """All checks that the flow file names; first of all, that the flow ran to its end."""
    asked = flow.checks
    found = [_ran(flow, outcome, history)]
    if asked.energy_decreases:
        found.append(energy_decreases(history))
    if asked.ends_at is not None:
        found.append(_ends(flow, history))
    if asked.stationary_from is not None and outcome.status == "ok":
        found += _stationary(flow, history, folder)
    if asked.reference is not None:
        found += _against_reference(flow, history)
    return found


def _check(name: str, measured: float, bound: float, text: str) -> Check:
    return Check(name, "pass" if measured <= bound else "fail", measured, bound, text)


def _ran(flow: FlowFile, outcome: Outcome, history: History) -> Check:
    missing = flow.time.final_time - history.column("t")[-1]
    text = outcome.reason or f"reached t = {flow.time.final_time:g}"
    verdict = "pass" if outcome.status == "ok" else "fail"
    return Check("runs to the end", verdict, float(missing), 0.0, text)


def energy_decreases(history: History) -> Check:
    """The largest increase of W in a step, relative to W."""
    W, t = history.column("energy"), history.column("t")
    rise = np.diff(W) / W[:-1] if len(W) > 1 else np.zeros(1)
    worst = int(np.argmax(rise))
    measured = max(0.0, float(rise[worst]))
    where = f", at t = {t[worst + 1]:g}" if measured > 0.0 else ""
    text = f"largest relative increase of W in a step: {measured:.1e}{where}"
    return _check("energy decreases", measured, ROUNDING, text)


def _ends(flow: FlowFile, history: History) -> Check:
    end = flow.checks.ends_at
    W = history.column("energy")[-1]
    measured = abs(W - LEVEL[end])
    text = f"W = {W:.6f} at the end, {ENDS[end]} = {LEVEL[end]:.6f}, off by {measured:.1e}"
    return _check(f"ends at the energy of a {end}", measured, flow.checks.ends_within, text)


def _stationary(flow: FlowFile, history: History, folder: Path) -> Iterator[Check]:
    """W, and the nodes relative to the radius of the sphere of the same area, have come to rest."""
    since, bound = flow.checks.stationary_from, flow.checks.stationary_within
    W, t = history.column("energy"), history.column("t")
    change = float(np.ptp(W[t >= since * (1.0 - 1e-9)]))
    span = f"from t = {since:g} to {flow.time.final_time:g}"
    yield _check("energy at rest", change, bound, f"W changes by {change:.1e} {span}")
    before, after = (read_frame(folder, n).x for n in (flow.levels.at(since), flow.levels.steps))
    radius = np.sqrt(history.column("area")[-1] / (4.0 * np.pi))
    moved = float(np.linalg.norm(after - before, axis=1).max() / radius)
    text = f"nodes move by at most {moved:.1e} of the radius {radius:.3f} of equal area {span}"
    yield _check("surface at rest", moved, bound, text)


def _against_reference(flow: FlowFile, history: History) -> Iterator[Check]:
    """W(t) against the axisymmetric solver, relative."""
    times = tuple(sorted(flow.checks.reference_at))
    solution = SurfaceFlow(flow.start.surface, "axisymmetric")
    reference = solution.profile_flow(flow.law.name, flow.law.parameters, (0.0, *times))
    W = history.column("energy")
    for t, exact in zip(times, reference.energies[1:], strict=True):
        n = flow.levels.at(t)
        if n < len(W):
            error = float(abs(W[n] / exact - 1.0))
            text = f"W = {W[n]:.6f}, reference {exact:.6f}, relative error {error:.1e}"
            yield _check(f"W at t = {t:g}", error, flow.checks.reference_within, text)
