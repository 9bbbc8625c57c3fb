"""The report of a flow: what was computed, what was checked, where the pictures are."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from harness.files import write_text
from harness.flows.checks import Check
from harness.flows.evolution import Outcome
from harness.flows.flow_file import FlowFile
from harness.flows.history import History
from harness.flows.start import Start
from harness.provenance import environment, provenance_line

NO_CLAIM = (
    "The start is a given triangulation: nu, H, V and z at t = 0 are estimates from local "
    "polynomial fits (osculating jets), not data of a known smooth surface. No order claim "
    "applies to this flow."
)


def describe(flow: FlowFile, start: Start) -> str:
    """One line: surface, mesh, law, scheme and time step."""
    scheme, mesh = flow.scheme, start.mesh
    surface = flow.start.surface or flow.start.mesh
    law = " ".join([flow.law.name, *(f"{k}={v:g}" for k, v in flow.law.parameters.items())])
    options = ["projection"] * scheme.project + ["theta"] * scheme.theta
    return (
        f"{flow.flow.title}: {surface}, V = {mesh.vertex_count}, {mesh.node_count} nodes; {law}; "
        f"P{scheme.degree}, BDF{scheme.bdf}, {' and '.join(options) or 'no projection'}"
        f"{flow.time.said_of_first_steps(scheme.bdf)}; "
        f"tau = {flow.time.tau:g}, T = {flow.time.final_time:g}"
    )


@dataclass(frozen=True)
class Finished:
    """An evolution that has ended, and what was checked of it."""

    flow: FlowFile
    start: Start
    outcome: Outcome
    history: History
    checks: list[Check]


def write_report(done: Finished, folder: Path) -> None:
    """Write ``checks.json`` and ``report.md`` into the folder."""
    flow, start, outcome = done.flow, done.start, done.outcome
    plain = {
        "flow": flow.model_dump(mode="json"),
        "nodes": start.mesh.node_count,
        "status": outcome.status,
        "reason": outcome.reason,
        "order_claim": "none: estimated start data" if start.estimated else "none is judged here",
        "seconds": outcome.seconds,
        "checks": [asdict(check) for check in done.checks],
        "environment": environment(),
    }
    write_text(folder / "checks.json", json.dumps(plain, indent=1) + "\n")
    write_text(folder / "report.md", _markdown(done, folder))


def _markdown(done: Finished, folder: Path) -> str:
    flow, start, history = done.flow, done.start, done.history
    steps, iterations = len(history.rows) - 1, history.column("iterations")
    rows = [f"| {c.verdict.upper()} | {c.name} | {c.text} | {c.bound:g} |" for c in done.checks]
    images = [f"![{path.stem}]({path.name})" for path in sorted(folder.glob("*.png"))]
    parts = [
        f"# {flow.flow.title}",
        describe(flow, start) + ".",
        *([NO_CLAIM] if start.estimated else []),
        f"{steps} steps in {done.outcome.seconds:.0f} s, {iterations.mean():.1f} GMRES iterations "
        "a step; the numbers of each level are in `history.csv`.",
        "\n".join(["| verdict | check | found | bound |", "|---|---|---|---|", *rows]),
        *images,
        f"*{provenance_line()}*",
    ]
    return "\n\n".join(parts) + "\n"
