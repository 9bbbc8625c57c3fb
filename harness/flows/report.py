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
from harness.words import describe_flow

NO_CLAIM = (
    "The start is a given triangulation: nu, H, V and z at t = 0 are estimates from local "
    "polynomial fits (osculating jets), not data of a known smooth surface. No order claim "
    "applies to this flow."
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
    steps = len(history.rows) - 1
    iterations = history.column("iterations")[1:].mean() if steps else 0.0
    rows = [f"| {c.verdict.upper()} | {c.name} | {c.text} | {c.bound:g} |" for c in done.checks]
    images = [f"![{path.stem}]({path.name})" for path in sorted(folder.glob("*.png"))]
    parts = [
        f"# {flow.flow.title}",
        describe_flow(flow, start.mesh.node_count) + ".",
        *([NO_CLAIM] if start.estimated else []),
        f"{steps} steps in {done.outcome.seconds:.0f} s, {iterations:.1f} GMRES iterations "
        "a step; the numbers of each level are in `history.csv`, where `energy` is that of the "
        f"law, the {history.energy}, and `willmore` is W = 1/2 int H^2.",
        "\n".join(["| verdict | check | found | bound |", "|---|---|---|---|", *rows]),
        *images,
        f"*{provenance_line()}*",
    ]
    return "\n\n".join(parts) + "\n"
