"""Checks of sentences about the evolutions, and about the effect of the projections."""

from math import isclose
from typing import Any

from esfem.campaigns.paper.sources import Finding, Table, held
from esfem.flows.flow_results import CheckedFlow
from esfem.judging.outcome import worst


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


def nodes(found: Table, count: int) -> Finding:
    """Whether the runs have so many nodes."""
    counts = {row["nodes"] for row in found.rows}
    return Finding(", ".join(map(str, sorted(counts))), str(count), held(counts == {count}))


def normals_deviate(found: Table, bound: float) -> Finding:
    """Without projections the length of nu_h leaves 1 by more than ``bound``."""
    row = _row(found, "without")
    measured = f"|nu_h| in [{row['least |nu|']:.6f}, {row['greatest |nu|']:.6f}]"
    return Finding(measured, f"off 1 by more than {bound:g}", held(_off(row, "|nu|") > bound))


def normals_kept(found: Table, bound: float) -> Finding:
    """With projections the length of nu_h stays at 1, to rounding."""
    off = _off(_row(found, "with"), "|nu|")
    return Finding(f"||nu_h| - 1| <= {off:.1e}", f"{bound:g} at most", held(off <= bound))


def stays_nearer(found: Table, quantity: str) -> Finding:
    """Whether the projections bring a quantity nearer to its exact value, at all times."""
    off, kept = (_off(_row(found, which), quantity) for which in ("without", "with"))
    measured = f"off by {kept:.1e} with, by {off:.1e} without"
    return Finding(measured, "nearer with projections", held(kept < off))


def _row(found: Table, projections: str) -> dict[str, Any]:
    (row,) = (row for row in found.rows if row["projections"] == projections)
    return row


def _off(row: dict[str, Any], quantity: str) -> float:
    exact = row[f"exact {quantity}"]
    return max(abs(row[f"{end} {quantity}"] - exact) for end in ("least", "greatest"))


CHECKS = (flow_setting, flow_checks, nodes, normals_deviate, normals_kept, stays_nearer)
