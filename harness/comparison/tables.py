"""The tables of the comparison: dicts a row, made from marches."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from harness.claims import covering
from harness.comparison.contest import GROUNDS, Options, case_of
from harness.comparison.march import March, march
from harness.comparison.stability import is_stable, largest_stable, shown_step
from harness.eoc import fit_order
from harness.judging import judge_table
from harness.quantities import decay_rate
from reference_solutions import PerturbedSphere

Row = dict[str, Any]
ROUNDING = 1e-10  # an increase of an energy below this, relative, is none
V, TAU, TIME = 240, 2.5e-4, 0.05  # of the comparison: one mesh and step for all
V_STABLE = 120
DEGREES = (1, 2, 3)
ORDER_TAU, ORDER_TIME = 1.25e-4, 2.5e-3
ORDER_V = (30, 60, 120, 240, 480)
DECAY_TAU, DECAY_TIME, DECAY_AMPLITUDE = 5e-4, 0.01, 1e-3
DECAY_RATE = PerturbedSphere(degree=2).decay_rate
DECAY_V = (30, 60, 120, 240)
COST_V, COST_TAU, COST_STEPS = 960, 1e-4, 8  # a sphere whose P_2 mesh has 3834 nodes


@dataclass(frozen=True)
class Entry:
    """One scheme on one surface, and the largest stable step."""

    ground: str
    entrant: str
    march: March
    stable: float


def entry(ground: str, entrant: str, options: Options) -> Entry:
    """Compute one line of the comparison."""
    solution = GROUNDS[ground]
    found = march(case_of(options, solution, V, TAU, TIME))
    stable = largest_stable(lambda tau: is_stable(options, solution, V_STABLE, tau))
    return Entry(ground, entrant, found, stable)


def comparison_row(entry: Entry) -> Row:
    """One line of the comparison."""
    m = entry.march
    quality = m.levels["quality"]
    return {
        "surface": entry.ground,
        "scheme": entry.entrant,
        "N": m.nodes,
        "ended": m.ended,
        "x in H^1, start": _short(m.at("start", "x")),
        "x in H^1, end": _short(m.at("end", "x")),
        "distance, start": _short(m.at("start", "distance")),
        "distance, end": _short(m.at("end", "distance")),
        "W error": _short(m.at("end", "W")),
        "own W error": _short(m.at("end", "own_W")),
        "area drift": _short(m.at("end", "area_drift")),
        "volume drift": _short(m.at("end", "volume_drift")),
        "W rises by": rises(m.rise()),
        "own W rises by": rises(m.rise("own_energy")),
        "quality, start": f"{quality[0]:.2f}",
        "quality, least": f"{min(quality):.2f}",
        "largest stable tau": shown_step(entry.stable),
        "CPU s a step, mean": _short(m.cpu / len(m.seconds) if m.seconds else np.nan),
    }


def rises(rise: float) -> str:
    """By how much an energy rises in a step, for eyes."""
    return "never" if rise < ROUNDING else _short(rise)


def course_row(entrant: str, m: March) -> Row:
    """One line on a long flow."""
    ok, quality = m.ended == "ok", m.levels["quality"]
    ends = {name: m.levels[name][-1] / (8 * np.pi) for name in ("energy", "own_energy")}
    return {
        "scheme": entrant,
        "ended": m.ended,
        "quality, start": f"{quality[0]:.2f}",
        "quality, least": f"{min(quality):.2f}",
        "quality, end": f"{quality[-1]:.2f}" if ok else "-",
        "W / 8 pi, end": f"{ends['energy']:.5f}" if ok else "-",
        "own W / 8 pi, end": f"{ends['own_energy']:.5f}" if ok else "-",
        "W rises by": rises(m.rise()),
        "own W rises by": rises(m.rise("own_energy")),
    }


def order_row(entrant: str, options: Options, k: int) -> Row:
    """Orders in h of a scheme with P_k: on the Clifford torus at rest, of the distance of x_h from
    the interpolation of x, judged where an order is claimed, of the distance of the surfaces and of
    W at the end; and of the decay rate of P2 on the sphere."""
    torus = GROUNDS["Clifford torus"]
    marches = [march(case_of(options, torus, v, ORDER_TAU, ORDER_TIME, k)) for v in ORDER_V]
    h = [m.h for m in marches]
    return {
        "scheme": entrant,
        "k": k,
        "x_h - I_h x": order(h, [m.furthest for m in marches]),
        "order k": verdict(options, k, marches),
        "distance": order(h, [m.at("end", "distance") for m in marches]),
        "W": order(h, [m.at("end", "W") for m in marches]),
        "decay rate": order(*decays(options, k)),
        "torus ended": "; ".join(dict.fromkeys(m.ended for m in marches)),
    }


def decays(options: Options, k: int) -> tuple[list[float], list[float]]:
    """Mesh widths, and errors of the decay rate of P2 on the sphere, NaN where a run broke down."""
    pairs = [rate_on_mesh(options, v, k, DECAY_AMPLITUDE) for v in DECAY_V]
    return [h for h, _ in pairs], [abs(rate - DECAY_RATE) for _, rate in pairs]


def rate_on_mesh(options: Options, v: int, k: int, amplitude: float) -> tuple[float, float]:
    """The mesh width, and the rate at which P2 decays on this mesh of the sphere.

    It is that of half the difference of flows that start from plus and minus the amplitude: what
    the discrete sphere does of itself drops out, and the law's terms of even order.
    """
    rates = []
    for tau in (DECAY_TAU, DECAY_TAU / 2, DECAY_TAU / 4):
        up, down = (
            march(case_of(options, perturbed(sign * amplitude), v, tau, DECAY_TIME, k), False)
            for sign in (1, -1)
        )
        ran = up.ended == down.ended == "ok"
        odd = np.subtract(up.levels["amplitude"], down.levels["amplitude"]) / 2 if ran else None
        rates.append(decay_rate(up.levels["t"], odd) if ran else np.nan)
    return up.h, extrapolated(*rates)


def extrapolated(whole: float, half: float, quarter: float) -> float:
    """From those of tau, tau/2 and tau/4 a rate without errors of first and second order in tau;
    that of the first is rate^2 tau / 2 for the implicit Euler method."""
    return (whole - 6.0 * half + 8.0 * quarter) / 3.0


def perturbed(amplitude: float) -> dict[str, Any]:
    """A sphere with so much of P2."""
    return {"name": "perturbed_sphere", "degree": 2, "amplitude": amplitude}


def verdict(options: Options, k: int, marches: Sequence[March]) -> str:
    """Of the judge, with its interval and its cause; "none" where nothing is claimed.

    The theorem, and `order-k` where there are projections, bound the distance of x_h from the
    interpolation in H^1 by a power h^k; more than that is no surprise, for nothing moves.
    """
    case = case_of(options, GROUNDS["Clifford torus"], ORDER_V[0], ORDER_TAU, ORDER_TIME, k)
    claim = covering(("theorem", "order-k"), case)
    if claim is None:
        return "none"
    found = judge_table(
        pd.DataFrame({"h": [m.h for m in marches], "error": [m.furthest for m in marches]}),
        claim.expected_order(k, bdf=1),
        tolerance=claim.tolerance,
        stationary=True,
        declared_super=True,
    )
    interval = f" [{found.lower:.2f}, {found.upper:.2f}]" if np.isfinite(found.lower) else ""
    cause = f", {found.cause}" if found.cause else ""
    return f"{found.outcome.upper()}{interval}{cause}"


def cost_row(entrant: str, options: Options) -> Row:
    """Seconds of the processor a step, the median, on the sphere with P_2 and 3834 nodes."""
    solution = GROUNDS["1 + 0.2 P2 sphere"]
    case = case_of(options, solution, COST_V, COST_TAU, COST_STEPS * COST_TAU)
    found = march(case, compare=False)
    ran = found.ended == "ok"
    seconds = float(f"{np.median(found.seconds):.3g}") if ran else "-"
    return {"scheme": entrant, "N": found.nodes, "ended": found.ended, "CPU s a step": seconds}


def order(h: Sequence[float], errors: Sequence[float]) -> str:
    """The fitted order over the levels that ran, its standard error; how many ran if not all."""
    good = [(s, e) for s, e in zip(h, errors, strict=True) if np.isfinite(e) and e > 0]
    if len(good) < 3:
        return "-"
    fit = fit_order(*zip(*good, strict=True))
    few = f" ({fit.levels} of {len(h)})" if fit.levels < len(h) else ""
    return f"{fit.order:.2f} ± {fit.uncertainty:.2f}{few}"


def _short(value: float) -> str:
    return f"{value:.1e}" if np.isfinite(value) else "-"
