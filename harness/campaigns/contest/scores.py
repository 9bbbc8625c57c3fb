"""The tables of the comparison: rows of numbers, made from marches, and how they are shown."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from esfem.campaigns.contest.contest import GROUNDS, Options, Sizes, case_of
from esfem.campaigns.contest.march import March, march
from esfem.campaigns.contest.stability import is_stable, largest_stable, shown_step
from esfem.judging import Judgement, judge_table
from esfem.judging.eoc import Fit, fit_order
from esfem.reference_solutions import PerturbedSphere
from esfem.studies.case import Case
from esfem.studies.claims import covering
from esfem.studies.quantities import decay_rate

Row = dict[str, Any]  # NaN, or None, is what is not known
ROUNDING = 1e-10  # an increase of an energy below this, relative, is none
FEWEST = 3  # levels of an order
DECAY_RATE = PerturbedSphere(degree=2).decay_rate


def comparison_row(ground: str, entrant: str, options: Options, sizes: Sizes) -> Row:
    """One line of the comparison: one scheme on one surface, and the largest stable step."""
    solution = GROUNDS[ground]
    m = march(case_of(options, solution, sizes.V, sizes.tau, sizes.time))
    stable = largest_stable(lambda tau: is_stable(options, solution, sizes.V_stable, tau))
    return {
        "surface": ground,
        "scheme": entrant,
        **measured(m),
        "largest stable tau": stable,
        "CPU s a step, mean": m.cpu / len(m.seconds) if m.seconds else np.nan,
    }


def measured(m: March) -> Row:
    """What the comparison tells of a march."""
    return {
        "N": m.nodes,
        "ended": m.ended,
        "x in H^1, start": m.at("start", "x"),
        "x in H^1, end": m.at("end", "x"),
        "distance, start": m.at("start", "distance"),
        "distance, end": m.at("end", "distance"),
        "W error": m.at("end", "W"),
        "own W error": m.at("end", "own_W"),
        "area drift": m.at("end", "area_drift"),
        "volume drift": m.at("end", "volume_drift"),
        "W rises by": m.rise(),
        "own W rises by": m.rise("own_energy"),
        "quality, start": m.levels["quality"][0],
        "quality, least": min(m.levels["quality"]),
    }


def course_row(entrant: str, m: March) -> Row:
    """One line on a long flow."""
    ok, quality = m.ended == "ok", m.levels["quality"]
    ends = {name: m.levels[name][-1] / (8 * np.pi) for name in ("energy", "own_energy")}
    return {
        "scheme": entrant,
        "ended": m.ended,
        "quality, start": quality[0],
        "quality, least": min(quality),
        "quality, end": quality[-1] if ok else np.nan,
        "W / 8 pi, end": ends["energy"] if ok else np.nan,
        "own W / 8 pi, end": ends["own_energy"] if ok else np.nan,
        "W rises by": m.rise(),
        "own W rises by": m.rise("own_energy"),
    }


def order_row(entrant: str, options: Options, k: int, sizes: Sizes) -> Row:
    """Orders in h of a scheme with P_k: on the Clifford torus at rest, of the distance of x_h from
    the interpolation of x, judged where an order is claimed, of the distance of the surfaces and of
    W at the end; and of the decay rate of P2 on the sphere."""
    marches = [march(torus_case(options, v, k, sizes)) for v in sizes.order_V]
    h = [m.h for m in marches]
    return {
        "scheme": entrant,
        "k": k,
        "x_h - I_h x": order(h, [m.furthest for m in marches]),
        "order k": verdict(options, k, marches, sizes),
        "distance": order(h, [m.at("end", "distance") for m in marches]),
        "W": order(h, [m.at("end", "W") for m in marches]),
        "decay rate": order(*decays(options, k, sizes)),
        "torus ended": "; ".join(dict.fromkeys(m.ended for m in marches)),
    }


def torus_case(options: Options, v: int, k: int, sizes: Sizes) -> Case:
    """A run of the ladder of orders."""
    torus = GROUNDS["Clifford torus"]
    return case_of(options, torus, v, sizes.order_tau, sizes.order_time, k)


def decays(options: Options, k: int, sizes: Sizes) -> tuple[list[float], list[float]]:
    """Mesh widths, and errors of the decay rate of P2 on the sphere, NaN where a run broke down."""
    pairs = [rate_on_mesh(options, v, k, sizes) for v in sizes.decay_V]
    return [h for h, _ in pairs], [abs(rate - DECAY_RATE) for _, rate in pairs]


def rate_on_mesh(options: Options, v: int, k: int, sizes: Sizes) -> tuple[float, float]:
    """The mesh width, and the rate at which P2 decays on this mesh of the sphere.

    It is that of half the difference of flows that start from plus and minus the amplitude: what
    the discrete sphere does of itself drops out, and the law's terms of even order.
    """
    rates = []
    starts = [perturbed(sign * sizes.decay_amplitude) for sign in (1, -1)]
    for tau in (sizes.decay_tau / part for part in (1, 2, 4)):
        up, down = (
            march(case_of(options, start, v, tau, sizes.decay_time, k), False) for start in starts
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


def verdict(options: Options, k: int, marches: Sequence[March], sizes: Sizes) -> Judgement | None:
    """Of the judge; None where nothing is claimed.

    The theorem, and `order-k` where there are projections, bound the distance of x_h from the
    interpolation in H^1 by a power h^k; more than that is no surprise, for nothing moves.
    """
    claim = covering(("theorem", "order-k"), torus_case(options, sizes.order_V[0], k, sizes))
    if claim is None:
        return None
    return judge_table(
        pd.DataFrame({"h": [m.h for m in marches], "error": [m.furthest for m in marches]}),
        claim.expected_order(k, bdf=1),
        tolerance=claim.tolerance,
        stationary=True,
        declared_super=True,
    )


def cost_row(entrant: str, options: Options, sizes: Sizes) -> Row:
    """Seconds of the processor a step, the median, on the sphere with P_2."""
    solution = GROUNDS["1 + 0.2 P2 sphere"]
    time = sizes.cost_steps * sizes.cost_tau
    found = march(case_of(options, solution, sizes.cost_V, sizes.cost_tau, time), compare=False)
    seconds = float(np.median(found.seconds)) if found.ended == "ok" else np.nan
    return {"scheme": entrant, "N": found.nodes, "ended": found.ended, "CPU s a step": seconds}


@dataclass(frozen=True)
class Order:
    """An order fitted over the levels that ran, of so many."""

    fit: Fit
    levels: int

    def __str__(self) -> str:
        few = f" ({self.fit.levels} of {self.levels})" if self.fit.levels < self.levels else ""
        return f"{self.fit.order:.2f} ± {self.fit.uncertainty:.2f}{few}"


def order(h: Sequence[float], errors: Sequence[float]) -> Order | None:
    """The fitted order over the levels that ran; None if they are too few."""
    good = [(s, e) for s, e in zip(h, errors, strict=True) if np.isfinite(e) and e > 0]
    return Order(fit_order(*zip(*good, strict=True)), len(h)) if len(good) >= FEWEST else None


def shown(row: Row) -> Row:
    """The row for eyes."""
    return {name: SHOWN.get(name, shown_value)(value) for name, value in row.items()}


def shown_value(value: Any, form: str = ".1e") -> Any:
    """What is not known as "-", a number by its format, whole numbers and words as they are."""
    if value is None or (isinstance(value, float) and not np.isfinite(value)):
        return "-"
    if isinstance(value, float):
        return format(value, form)
    return str(value) if isinstance(value, Order) else value


def shown_rise(rise: float) -> str:
    """By how much an energy rises in a step."""
    return "never" if rise < ROUNDING else shown_value(rise)


def shown_verdict(found: Judgement | None) -> str:
    """A judgement with its interval and its cause; "none" where nothing is claimed."""
    if found is None:
        return "none"
    interval = f" [{found.lower:.2f}, {found.upper:.2f}]" if np.isfinite(found.lower) else ""
    cause = f", {found.cause}" if found.cause else ""
    return f"{found.outcome.upper()}{interval}{cause}"


def shown_seconds(seconds: float) -> float | str:
    """Three digits, and a number still, for programs that read the table."""
    return float(f"{seconds:.3g}") if np.isfinite(seconds) else "-"


SHOWN: dict[str, Callable[[Any], Any]] = {
    **dict.fromkeys(("W rises by", "own W rises by"), shown_rise),
    **dict.fromkeys(
        ("quality, start", "quality, least", "quality, end"), partial(shown_value, form=".2f")
    ),
    **dict.fromkeys(("W / 8 pi, end", "own W / 8 pi, end"), partial(shown_value, form=".5f")),
    "largest stable tau": shown_step,
    "order k": shown_verdict,
    "CPU s a step": shown_seconds,
}
