"""What a flow was expected to do, and whether it did: one line each."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from esfem.flows.flow_file import FlowFile
from esfem.flows.flow_results import Check, Ended, read_frames
from esfem.flows.history import History
from esfem.measuring.energies import ROUNDING, largest_rise, scale_of
from esfem.measuring.shape import profile_flow
from esfem.reference_solutions.axisymmetric import ProfileFlow

AT_REST = 1e-3  # of the radius: a surface that would move no further until the end is at rest
# W of the surfaces at which a flow may end, in TeX and as a number.
ENDS = {"sphere": (r"8 \pi", 8.0 * np.pi), "clifford_torus": (r"4 \pi^2", 4.0 * np.pi**2)}


def checked(flow: FlowFile, ended: Ended, history: History, folder: Path) -> list[Check]:
    """All checks that the flow file names; first of all, that the flow ran to its end."""
    asked = flow.checks
    found = [_ran(flow, ended, history)]
    if asked.energy_decreases and len(history.rows) > 1:
        found += [energy_decreases(history), *energy_falls(history)]
    if asked.ends_at is not None:
        found.append(_ends(asked.ends_at, asked.ends_within, history))
    if asked.stationary_from is not None and ended.status == "ok":
        found += _stationary(asked.stationary_from, flow, history, folder)
    if asked.reference is not None:
        found += _against_reference(flow, history)
    return found


def _check(name: str, measured: float, bound: float, text: str) -> Check:
    return Check(name, "pass" if measured <= bound else "fail", measured, bound, text)


def _ran(flow: FlowFile, ended: Ended, history: History) -> Check:
    missing = flow.time.final_time - history.column("t")[-1]
    text = ended.reason or f"reached t = {flow.time.final_time:g}"
    holds = ended.status == "ok"
    return Check("runs to the end", "pass" if holds else "fail", float(missing), 0.0, text)


def energy_decreases(history: History) -> Check:
    """The largest increase in a step of the energy of the law, relative to the start.

    That none is beyond rounding the flow file asks; no theorem says so, which leaves rises of order
    h^k + tau^q open. What is proved of an energy is judged in studies, by its balance.
    """
    energies = history.column("energy")
    scale = scale_of(history.energy, energies[0], history.column("willmore")[0])
    measured, level = largest_rise(energies.tolist(), scale)
    where = f", at t = {history.column('t')[level]:g}" if measured > 0.0 else ""
    text = f"largest increase of the {history.energy} in a step, relative to the start: "
    open_ = "; rises of order h^k + tau^q are excluded by no theorem" if measured > ROUNDING else ""
    return _check("energy decreases", measured, ROUNDING, f"{text}{measured:.1e}{where}{open_}")


def energy_falls(history: History) -> Iterator[Check]:
    """That the energy is lower at the end than at the start, where the surface is not at rest: by
    never rising alone, a scheme that does nothing would pass."""
    energies, t = history.column("energy"), history.column("t")
    radius = np.sqrt(history.column("area")[0] / (4.0 * np.pi))
    speed = history.column("speed")[0]
    if speed * (t[-1] - t[0]) < AT_REST * radius:
        return
    scale = scale_of(history.energy, energies[0], history.column("willmore")[0])
    change = float((energies[-1] - energies[0]) / scale)
    text = (
        f"the {history.energy} changes by {change:.1e} of the start; max |V| there is {speed:.1e}"
    )
    yield _check("energy falls", change, -ROUNDING, text)


def _ends(end: str, within: float, history: History) -> Check:
    W = history.last("willmore")
    tex, expected = ENDS[end]
    measured = abs(W - expected)
    words = tex.replace("\\", "")
    text = f"W = {W:.6f} at the end, {words} = {expected:.6f}, off by {measured:.1e}"
    return _check(f"ends at the energy of a {end}", measured, within, text)


def _stationary(since: float, flow: FlowFile, history: History, folder: Path) -> Iterator[Check]:
    """The energy of the law, and the nodes relative to the radius of the sphere of the same area,
    have come to rest."""
    bound = flow.checks.stationary_within
    energies, t = history.column("energy"), history.column("t")
    change = float(np.ptp(energies[t >= since * (1.0 - 1e-9)]))
    relative = ""
    if history.energy.symbol == "A":  # an area has a unit
        change, relative = change / energies[-1], " of itself"
    span = f"from t = {since:g} to {flow.time.final_time:g}"
    text = f"{history.energy.symbol} changes by {change:.1e}{relative} {span}"
    yield _check("energy at rest", change, bound, text)
    before, after = read_frames(folder, (flow.levels.at(since), flow.levels.steps))
    radius = np.sqrt(history.column("area")[-1] / (4.0 * np.pi))
    moved = float(np.linalg.norm(after.x - before.x, axis=1).max() / radius)
    text = f"nodes move by at most {moved:.1e} of the radius {radius:.3f} of equal area {span}"
    yield _check("surface at rest", moved, bound, text)


def _against_reference(flow: FlowFile, history: History) -> Iterator[Check]:
    """W, and the energy of the law where it is another one, against the axisymmetric solver.

    The error of W is relative; that of an energy, which may tend to zero, relative to the start.
    """
    reference, symbol = reference_flow(flow), history.energy.symbol
    bound, times = flow.checks.reference_within, reference.times
    levels = [(flow.levels.at(t), i) for i, t in enumerate(times) if i > 0]
    reached = [(n, i) for n, i in levels if n < len(history.rows)]
    W, E = history.column("willmore"), history.column("energy")
    for n, i in reached:
        error = float(abs(W[n] / reference.willmore[i] - 1.0))
        values = f"W = {W[n]:.6f}, reference {reference.willmore[i]:.6f}"
        text = f"{values}, relative error {error:.1e}"
        yield _check(f"W at t = {times[i]:g}", error, bound, text)
    for n, i in reached if symbol != "W" else ():
        scale = scale_of(history.energy, reference.energies[0], reference.willmore[0])
        error = float(abs(E[n] - reference.energies[i]) / scale)
        values = f"{symbol} = {E[n]:.6f}, reference {reference.energies[i]:.6f}"
        text = f"{values}, error {error:.1e} of {scale:.4g}"
        yield _check(f"{symbol} at t = {times[i]:g}", error, bound, text)


def reference_flow(flow: FlowFile) -> ProfileFlow:
    """The axisymmetric flow at 0 and the times of comparison.

    Raises
    ------
    BadInput
        If the axisymmetric solver does not get there.
    """
    times = (0.0, *sorted(flow.checks.reference_at))
    return profile_flow(flow.solution, flow.law, times, "[checks] reference_at")
