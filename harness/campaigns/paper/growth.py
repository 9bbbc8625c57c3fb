"""How fast the discrete Clifford torus leaves the torus at small time steps.

V = 0 on the torus, so that |V_h - I_h V| = |V_h| starts from zero; after the start-up it grows by a
constant factor a step, until the surface is another one. The rate is the slope of log |V_h| in
H^1 over that phase: from `ABOVE` times its least value after `SINCE` to `UPTO`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from esfem.campaigns.paper.convergence import ON_TORUS
from esfem.campaigns.paper.stored_results import Missing, Row, stored_study
from esfem.common.drawing import PALETTE, styled, subplots
from esfem.report.extra import Extra
from esfem.results.study_result import StudyResult
from esfem.runs.store import read_record
from esfem.solver.reference_element import Array

VERTICES, TAU = 240, 0.00625  # meshes from here on, steps up to here
UNIT = 1.0  # of length in H^1, that of the paper
DRAWN = 480  # the mesh whose runs are drawn
SINCE, ABOVE, UPTO = 0.1, 3.0, 0.3
LEAST_FACTOR = exp(1.0)  # by which it must grow within the phase, to be called growth
# Of the dashed line, and in sentences.toml: measured here earlier, with BDF2 at tau = 0.003125.
SHOWN_RATE = 13.0


@dataclass(frozen=True)
class Run:
    """|V_h| in H^1 at the times t of one run, and how the run ended."""

    bdf: int
    vertices: int
    tau: float
    t: Array
    size: Array
    end: str


@dataclass(frozen=True)
class Phase:
    """The phase of growth, from level ``first`` to level ``last``, and its rate."""

    first: int
    last: int
    rate: float


def growth(runs: Path) -> Extra:
    """The table, a line a run, and log |V_h| against time on one mesh."""
    found = [run for name in ON_TORUS for run in runs_of(stored_study(runs / name, name))]
    return Extra(
        title="How the discrete Clifford torus leaves the torus at small time steps",
        text=(
            f"P2, with projection, F w extrapolated, V = {VERTICES} and more, tau = {TAU:g} and "
            f"less: |V_h| in H^1, which is 0 on the torus. The rate is the slope of its logarithm "
            f"from {ABOVE:g} times its least value after t = {SINCE:g} up to {UPTO:g}; none where "
            f"it grows by less than the factor e. The figure shows V = {DRAWN}, and the slope of "
            f"e^({SHOWN_RATE:g} t), dashed, the rate measured here earlier with BDF2 at "
            f"tau = 0.003125."
        ),
        table=[row(run) for run in found],
        figure=figure([run for run in found if run.vertices == DRAWN]),
        alt="Size of the discrete normal velocity against time, on a logarithmic scale",
    )


def runs_of(result: StudyResult) -> list[Run]:
    """The runs of a study that are looked at, coarse before fine.

    Raises
    ------
    Missing
        If the record of one is not there.
    """
    study, found = result.study, []
    for line in result.records.query("vertices >= @VERTICES and tau <= @TAU").itertuples():
        record = read_record(result.folder, line.key, lambda told: None)
        if record is None:
            raise Missing(f"study {study.name}: a record is not there; it has not been run")
        end = "reaches T" if record.status == "ok" else f"stops at t = {record.stopped_at:.3g}"
        t, size = np.array(record.t), np.array(record.nodal_h1(UNIT)["V"])
        found.append(Run(study.scheme.order, line.vertices, line.tau, t, size, end))
    return found


def phase(t: Array, size: Array) -> Phase | None:
    """The phase of growth of a size at the times t; None if there is none."""
    started = np.flatnonzero(t >= SINCE)
    if not len(started):
        return None
    least = started[np.argmin(size[started])]
    after = np.arange(len(t)) > least
    above = np.flatnonzero(after & (size >= ABOVE * size[least]) & (size <= UPTO))
    if not len(above):
        return None
    first = int(above[0])
    beyond = np.flatnonzero((size > UPTO) & (np.arange(len(t)) > first))
    last = int(beyond[0]) - 1 if len(beyond) else len(t) - 1
    if last - first < 2 or size[last] < LEAST_FACTOR * size[first]:
        return None
    there = slice(first, last + 1)
    return Phase(first, last, float(np.polyfit(t[there], np.log(size[there]), 1)[0]))


def row(run: Run) -> Row:
    """One line of the table."""
    found = phase(run.t, run.size)
    return {
        "BDF": run.bdf,
        "V": int(run.vertices),
        "tau": float(run.tau),
        "rate": None if found is None else round(found.rate, 2),
        "from t": None if found is None else round(float(run.t[found.first]), 4),
        "to t": None if found is None else round(float(run.t[found.last]), 4),
        "largest |V_h|": float(f"{run.size.max():.3g}"),
        "end": run.end,
    }


@styled()
def figure(shown: Sequence[Run]) -> Figure:
    """log |V_h| against t."""
    drawn, axis = subplots(size=(6.5, 3.8))
    for i, run in enumerate(shown):
        label = rf"BDF{run.bdf}, $\tau$ = {run.tau:g}"
        look = {"color": PALETTE[i % len(PALETTE)], "linewidth": 1.0, "label": label}
        axis.semilogy(run.t[1:], run.size[1:], **look)
    t = np.array([0.3, 0.6])
    slope = 1e-2 * np.exp(SHOWN_RATE * (t - t[0]))
    axis.semilogy(t, slope, "--", color="0.4", label=f"$e^{{{SHOWN_RATE:g} t}}$")
    axis.set(xlabel="$t$", title=f"$|V_h|$ in $H^1$, $V = {DRAWN}$")
    axis.legend(fontsize=8)
    return drawn
