"""The tables of the comparison: dicts a row, made from marches."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from harness.case import Case
from harness.claims import claims
from harness.comparison.contest import ENTRANTS, GROUNDS, March, case_of, march
from harness.comparison.stability import LARGEST, is_stable, largest_stable
from harness.eoc import fit_order
from harness.judging import judge_table
from harness.quantities import decay_rate

Row = dict[str, Any]
ROUNDING = 1e-10  # an increase of W below this, relative, is none
DEGREES = (1, 2, 3)
ORDER_TAU, ORDER_TIME = 1.25e-4, 2.5e-3
ORDER_V = (60, 120, 240, 480)
DECAY_TAU, DECAY_TIME = 5e-4, 0.02
DECAY_V = (30, 60, 120, 240)
COST_V = 960  # vertices of the sphere whose P_2 mesh has 3834 nodes


def result_row(ground: str, entrant: str, found: March, stable: float) -> Row:
    """One line of the comparison."""
    return {
        "surface": ground,
        "scheme": entrant,
        "N": found.nodes,
        "ended": found.ended,
        "x in H^1": _short(found.x_error),
        "distance": _short(found.distance),
        "W error": _short(found.W),
        "area drift": _short(found.area_drift),
        "volume drift": _short(found.volume_drift),
        "W rises by": "never" if found.rise < ROUNDING else _short(found.rise),
        "quality, start": f"{found.quality[0]:.2f}",
        "quality, least": f"{min(found.quality):.2f}",
        "largest stable tau": shown_step(stable),
        "CPU s a step": _short(found.cpu / max(len(found.seconds), 1)),
    }


def course_row(entrant: str, found: March) -> Row:
    """One line on a long flow."""
    return {
        "scheme": entrant,
        "ended": found.ended,
        "quality, start": f"{found.quality[0]:.2f}",
        "quality, least": f"{min(found.quality):.2f}",
        "quality, end": f"{found.quality[-1]:.2f}",
        "W / 8 pi, end": f"{found.energy[-1] / (8 * np.pi):.5f}",
        "W rises by": "never" if found.rise < ROUNDING else _short(found.rise),
    }


def comparison(V: int, tau: float, T: float, V_stable: int) -> Iterator[tuple[Row, float]]:
    """All entrants on all grounds: the row of the table, and the largest stable step."""
    for ground, solution in GROUNDS.items():
        for entrant in ENTRANTS:
            found = march(case_of(entrant, solution, V, tau, T))
            stable = largest_stable(lambda s, e=entrant, g=solution: is_stable(e, g, V_stable, s))
            yield result_row(ground, entrant, found, stable), stable


def orders() -> Iterator[Row]:
    """Orders in h of each scheme for P_1, P_2, P_3: x in H^1, judged where the theorem speaks,
    distance and W on the Clifford torus at rest; and the decay rate of P2 on the sphere."""
    for entrant in ENTRANTS:
        for k in DEGREES:
            cases = [
                case_of(entrant, GROUNDS["Clifford torus"], V, ORDER_TAU, ORDER_TIME, k)
                for V in ORDER_V
            ]
            torus = [march(case) for case in cases]
            yield {
                "scheme": entrant,
                "k": k,
                "x in H^1": _order(torus, [m.x_error for m in torus]),
                "theorem": verdict(cases[-1], torus),
                "distance": _order(torus, [m.distance for m in torus]),
                "W": _order(torus, [m.W for m in torus]),
                "decay rate": _order(*_decays(entrant, k)),
                "torus ended": "; ".join(dict.fromkeys(m.ended for m in torus)),
            }


def _decays(entrant: str, k: int) -> tuple[list[March], list[float]]:
    """Marches of a mode of the sphere, and by how much the next finer mesh has another decay rate.

    The error in time is the same on all meshes, so that it drops out of these differences.
    """
    solution = {"name": "perturbed_sphere", "degree": 2}
    found = [
        march(case_of(entrant, solution, V, DECAY_TAU, DECAY_TIME, k), compare=False)
        for V in DECAY_V
    ]
    rates = [decay_rate(m.t, m.amplitude) if m.ended == "ok" else np.nan for m in found]
    return found[:-1], [abs(fine - coarse) for coarse, fine in pairwise(rates)]


def costs(tau: float, steps: int) -> list[Row]:
    """Seconds of the processor a step, on the sphere with P_2 and 3834 nodes."""
    rows = []
    for entrant in ENTRANTS:
        case = case_of(entrant, GROUNDS["1 + 0.2 P2 sphere"], COST_V, tau, steps * tau)
        found = march(case, compare=False)
        rows.append(
            {"scheme": entrant, "N": found.nodes, "CPU s a step": float(np.median(found.seconds))}
        )
    return rows


def verdict(case: Case, marches: list[March]) -> str:
    """Of the judge, on x in H^1, with its interval; "none" where there is no theorem."""
    theorem = claims()["theorem"]
    if theorem.objection(case.scheme) is not None:
        return "none"
    runs = {"h": [m.h for m in marches], "error": [m.x_error for m in marches]}
    found = judge_table(
        pd.DataFrame(runs),
        theorem.expected_order(case.scheme.degree, bdf=1),
        tolerance=theorem.tolerance,
        stationary=True,
    )
    return f"{found.outcome.upper()} [{found.lower:.2f}, {found.upper:.2f}]"


def _order(marches: list[March], errors: list[float]) -> str:
    """The fitted order over the levels that ran, and how many these are."""
    good = [(m.h, e) for m, e in zip(marches, errors, strict=True) if np.isfinite(e) and e > 0]
    if len(good) < 3:
        return "-"
    h, e = zip(*good, strict=True)
    return f"{fit_order(h, e).order:.2f} ({len(good)} levels)"


def _short(value: float) -> str:
    return f"{value:.1e}" if np.isfinite(value) else "-"


def shown_step(tau: float) -> str:
    """A largest stable step for eyes; where no larger one was tried, ">=" it."""
    if tau == 0.0:
        return "none"
    return f">= {LARGEST:g}" if tau >= LARGEST else f"{tau:.2g}"
