"""What the table shows, in three sentences made from its numbers."""

from collections.abc import Sequence

import numpy as np

from harness.comparison.stability import shown_step
from harness.comparison.tables import ROUNDING, Entry, Row

ALIKE = 1.1  # a distance up to this times the least one counts as the same


def sentences(entries: Sequence[Entry], cost: Sequence[Row]) -> list[str]:
    """On accuracy, on stability, and on cost and energy."""
    return [_accuracy(entries), _stability(entries), _price(entries, cost)]


def _grouped(entries: Sequence[Entry], by: str) -> dict[str, list[Entry]]:
    groups: dict[str, list[Entry]] = {}
    for one in entries:
        groups.setdefault(getattr(one, by), []).append(one)
    return groups


def _accuracy(entries: Sequence[Entry]) -> str:
    said = []
    for ground, group in _grouped(entries, "ground").items():
        ran = {e.entrant: e.march.at("end", "distance") for e in group if e.march.ended == "ok"}
        if not ran:
            said.append(f"none on the {ground}, where none reached the end")
            continue
        least = min(ran.values())
        near = [name for name, distance in ran.items() if distance <= ALIKE * least]
        start = np.median([e.march.at("start", "distance") for e in group if e.entrant in ran])
        names = "all" if len(near) == len(group) else " and ".join(near)
        said.append(f"{names} on the {ground} ({least:.1e}, at the start {start:.1e})")
    stopped = [f"{e.entrant} on the {e.ground}" for e in entries if e.march.ended != "ok"]
    did_not = f"; {', '.join(stopped)} did not reach the end" if stopped else ""
    return (
        "Nearest to the exact surface at the end, where a tenth more counts as equal, are "
        f"{', '.join(said)}{did_not}."
    )


def _stability(entries: Sequence[Entry]) -> str:
    ranges = []
    for entrant, group in _grouped(entries, "entrant").items():
        own = [one.stable for one in group]
        ends = dict.fromkeys(shown_step(step) for step in (min(own), max(own)))
        ranges.append(f"{entrant} {' to '.join(ends)}")
    return f"The largest stable tau over the surfaces is for {'; '.join(ranges)}."


def _price(entries: Sequence[Entry], cost: Sequence[Row]) -> str:
    ran = [row for row in cost if row["ended"] == "ok"]
    base = ran[0]["CPU s a step"] if ran else np.nan
    groups = _grouped(entries, "entrant")
    prices = [f"{r['scheme']} {r['CPU s a step'] / base:.1f}" for r in ran]
    prices += [f"{r['scheme']} {r['ended']}" for r in cost if r not in ran]
    calm = [
        f"{entrant} on {sum(e.march.rise('own_energy') < ROUNDING for e in group)} of {len(group)}"
        for entrant, group in groups.items()
    ]
    return (
        f"A step at N = {cost[0]['N']} costs, in units of that of the first, "
        f"{', '.join(prices)}; and the scheme's own energy never rises after the first step for "
        f"{', '.join(calm)} surfaces."
    )
