"""What the table shows, in three sentences made from its numbers."""

from collections.abc import Sequence

from harness.comparison.contest import ENTRANTS, GROUNDS
from harness.comparison.tables import Row, shown_step


def sentences(rows: Sequence[Row], steps: Sequence[float], cost: Sequence[Row]) -> list[str]:
    """On accuracy, on stability (the largest stable step of each row), and on cost and energy."""
    return [_accuracy(rows), _stability(rows, steps), _price(rows, cost)]


def _accuracy(rows: Sequence[Row]) -> str:
    nearest = []
    for ground in GROUNDS:
        ran = [r for r in rows if r["surface"] == ground and r["distance"] != "-"]
        best = min(ran, key=lambda r: float(r["distance"]))
        nearest.append(f"{best['scheme']} on the {ground} ({best['distance']})")
    stopped = [f"{r['scheme']} on the {r['surface']}" for r in rows if r["ended"] != "ok"]
    did_not = f"; {', '.join(stopped)} did not reach the end" if stopped else ""
    return f"Nearest to the exact surface is {', '.join(nearest)}{did_not}."


def _stability(rows: Sequence[Row], steps: Sequence[float]) -> str:
    ranges = []
    for entrant in ENTRANTS:
        own = [step for row, step in zip(rows, steps, strict=True) if row["scheme"] == entrant]
        ends = dict.fromkeys(shown_step(step) for step in (min(own), max(own)))
        ranges.append(f"{entrant} {' to '.join(ends)}")
    return f"The largest stable tau over the surfaces is for {'; '.join(ranges)}."


def _price(rows: Sequence[Row], cost: Sequence[Row]) -> str:
    base = cost[0]["CPU s a step"]
    prices = [f"{r['scheme']} {r['CPU s a step'] / base:.1f}" for r in cost]
    calm = [
        f"{entrant} on {sum(r['W rises by'] == 'never' for r in rows if r['scheme'] == entrant)}"
        for entrant in ENTRANTS
    ]
    return (
        f"A step at N = {cost[0]['N']} costs, in units of that of kll, {', '.join(prices)}, and W "
        f"never rises after the first step for {', '.join(calm)} of the {len(GROUNDS)} surfaces."
    )
