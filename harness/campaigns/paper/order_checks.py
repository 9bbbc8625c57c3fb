"""Checks of sentences about orders and bounds. Each is a pure function of stored results.

The verdicts and their intervals are those that `results.verdicts` stored with each study, or finds
on the part of its grid that a sentence is read on; what is expected comes from its claim.
"""

import numpy as np

from esfem.campaigns.paper.sources import Finding, Part, StudyData, held, joined
from esfem.results.verdicts import Verdict


def orders(*found: StudyData, variables: list[str]) -> Finding:
    """The verdicts of the studies on the variables: the worst of them."""
    chosen = [_of(data, variables) for data in found]
    expected = {f"{v.expected:g}" for rows in chosen for v in rows if np.isfinite(v.expected)}
    judged = [f"{v.variable} {v.verdict}" for rows in chosen for v in rows if _unusual(v)]
    return Finding(
        "; ".join(", ".join(_order(v) for v in rows) for rows in chosen),
        f"order {' and '.join(sorted(expected))} in h" if expected else "no order is claimed",
        joined([v.verdict for rows in chosen for v in rows]),
        f"not PASS: {', '.join(judged)}" if judged else "",
    )


def orders_by_step(found: StudyData, variables: list[str]) -> Finding:
    """The verdicts on the variables on the line of each time step by itself: the worst of them."""
    told, verdicts = [], []
    for tau in sorted(found.study.sweep.tau, reverse=True):
        rows = _of(found.within(Part(tau_from=tau, tau_to=tau)), variables)
        verdicts.append(joined([v.verdict for v in rows]))
        told.append(f"tau = {tau:g} {verdicts[-1].upper()} ({_orders(rows)})")
    met = sum(verdict in ("pass", "super") for verdict in verdicts)
    note = f"met by {met} of {len(verdicts)} lines"
    return Finding("; ".join(told), "the order on each line", joined(verdicts), note)


def bounded(found: StudyData, variables: list[str]) -> Finding:
    """The verdict on errors that are to stay below a bound; which run counts the claim says."""
    chosen = _of(found, variables)
    limits = {v.limit for v in chosen}
    told = [f"{v.variable}: {v.reason}" for v in chosen]
    bound = " and ".join(f"at most {limit:g}" for limit in sorted(limits))
    return Finding("; ".join(told), bound, joined([v.verdict for v in chosen]))


def exceeds(*found: StudyData, variables: list[str]) -> Finding:
    """Whether some order lies above the claimed one, with its whole interval, tolerance added."""
    rows = [v for data in found for v in _of(data, variables)]
    known = [v for v in rows if np.isfinite(v.lower) and np.isfinite(v.expected)]
    above = [v for v in known if v.lower > v.expected + v.tolerance]
    if not known:
        return Finding("no order was observed", "an order above the claim", "inconclusive")
    best = max(known, key=lambda v: v.lower)
    expected = f"some order above {best.expected:g} + {best.tolerance:g}"
    names = dict.fromkeys(v.study for v in above)
    note = f"exceeded in {', '.join(names)}" if above else "matched, nowhere exceeded"
    return Finding(f"{best.study}: {_order(best)}", expected, held(bool(above)), note)


def at_least(
    found: StudyData, variables: list[str], below_degree: int, tolerance: float
) -> Finding:
    """Whether no order is below k - ``below_degree``, by its interval."""
    order = found.study.scheme.degree - below_degree
    rows = _of(found, variables)
    known = [v for v in rows if np.isfinite(v.lower)]
    expected = f"order {order} at least"
    if len(known) < len(rows):
        lacking = ", ".join(v.variable for v in rows if v not in known)
        return Finding(_orders(rows), expected, "inconclusive", f"no order observed of {lacking}")
    holds = all(v.lower >= order - tolerance for v in known)
    return Finding(_orders(rows), expected, held(holds))


def observed(*found: StudyData, variables: list[str]) -> Finding:
    """The orders where none is claimed."""
    told = "; ".join(_orders(_of(data, variables)) for data in found)
    return Finding(told, "no order is claimed", "no claim")


def _of(data: StudyData, variables: list[str]) -> list[Verdict]:
    by_name = {v.variable: v for v in data.verdicts}
    return [by_name[name] for name in variables]


def _orders(rows: list[Verdict]) -> str:
    return ", ".join(_order(v) for v in rows)


def _order(v: Verdict) -> str:
    """For example "x 2.12 [2.00, 2.20]"."""
    if not np.isfinite(v.observed):
        return f"{v.variable} {v.verdict}"
    return f"{v.variable} {v.observed:.2f} [{v.lower:.2f}, {v.upper:.2f}]"


def _unusual(v: Verdict) -> bool:
    return v.verdict not in ("pass", "super")


CHECKS = (orders, orders_by_step, bounded, exceeds, at_least, observed)
