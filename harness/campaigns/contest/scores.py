"""The tables of the comparison: rows of numbers, made from runs, and how they are shown."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from esfem.campaigns.contest.contest import GROUNDS, Options, Sizes, case_of
from esfem.campaigns.contest.entrant_run import (
    LARGEST,
    EntrantRun,
    is_stable,
    largest_stable,
    run_entrant,
)
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
    run = run_entrant(case_of(options, solution, sizes.V, sizes.tau, sizes.time))
    stable = largest_stable(lambda tau: is_stable(options, solution, sizes.V_stable, tau))
    return {
        "surface": ground,
        "scheme": entrant,
        **measured(run),
        "largest stable tau": stable,
        "CPU s a step, mean": run.cpu / len(run.seconds) if run.seconds else np.nan,
    }


def measured(run: EntrantRun) -> Row:
    """What the comparison tells of a run."""
    return {
        "N": run.nodes,
        "ended": run.ended,
        "x in H^1, start": run.at("start", "x"),
        "x in H^1, end": run.at("end", "x"),
        "distance, start": run.at("start", "distance"),
        "distance, end": run.at("end", "distance"),
        "W error": run.at("end", "W"),
        "own W error": run.at("end", "own_W"),
        "area drift": run.at("end", "area_drift"),
        "volume drift": run.at("end", "volume_drift"),
        **rises(run),
        "quality, start": run.levels["quality"][0],
        "quality, least": min(run.levels["quality"]),
    }


def rises(run: EntrantRun) -> Row:
    """By how much the energies rise in a step."""
    return {"W rises by": run.rise(), "own W rises by": run.rise("own_energy")}


def course_row(entrant: str, run: EntrantRun) -> Row:
    """One line on a long flow."""
    ends = {name: v[-1] if run.ended == "ok" else np.nan for name, v in run.levels.items()}
    return {
        "scheme": entrant,
        "ended": run.ended,
        "quality, start": run.levels["quality"][0],
        "quality, least": min(run.levels["quality"]),
        "quality, end": ends["quality"],
        "W / 8 pi, end": ends["energy"] / (8 * np.pi),
        "own W / 8 pi, end": ends["own_energy"] / (8 * np.pi),
        **rises(run),
    }


def order_row(entrant: str, options: Options, k: int, sizes: Sizes) -> Row:
    """Orders in h of a scheme with P_k: on the Clifford torus at rest, of the distance of x_h from
    the interpolation of x, judged where an order is claimed, of the distance of the surfaces and of
    W at the end; and of the decay rate of P2 on the sphere, over meshes where no run broke down."""
    runs = [run_entrant(torus_case(options, v, k, sizes)) for v in sizes.order_V]
    h = [run.h for run in runs]
    widths, rates = zip(*(rate_on_mesh(options, v, k, sizes) for v in sizes.decay_V), strict=True)
    return {
        "scheme": entrant,
        "k": k,
        "x_h - I_h x": order(h, [run.furthest for run in runs]),
        "order k": verdict(options, k, runs, sizes),
        "distance": order(h, [run.at("end", "distance") for run in runs]),
        "W": order(h, [run.at("end", "W") for run in runs]),
        "decay rate": order(widths, [abs(rate - DECAY_RATE) for rate in rates]),
        "torus ended": "; ".join(dict.fromkeys(run.ended for run in runs)),
    }


def torus_case(options: Options, v: int, k: int, sizes: Sizes) -> Case:
    """A run of the ladder of orders."""
    torus = GROUNDS["Clifford torus"]
    return case_of(options, torus, v, sizes.order_tau, sizes.order_time, k)


def rate_on_mesh(options: Options, v: int, k: int, sizes: Sizes) -> tuple[float, float]:
    """The mesh width, and the rate at which P2 decays on this mesh of the sphere; NaN if a run
    broke down.

    It is that of half the difference of flows that start from plus and minus the amplitude: what
    the discrete sphere does of itself drops out, and the law's terms of even order.
    """
    rates = []
    for tau in (sizes.decay_tau / part for part in (1, 2, 4)):
        up, down = (
            run_entrant(case_of(options, perturbed(a), v, tau, sizes.decay_time, k), compare=False)
            for a in (sizes.decay_amplitude, -sizes.decay_amplitude)
        )
        if up.ended == down.ended == "ok":
            odd = np.subtract(up.levels["amplitude"], down.levels["amplitude"]) / 2
            rates.append(decay_rate(up.levels["t"], odd.tolist()))
        else:
            rates.append(np.nan)
    return up.h, extrapolated(*rates)


def extrapolated(whole: float, half: float, quarter: float) -> float:
    """From those of tau, tau/2 and tau/4 a rate without errors of first and second order in tau;
    that of the first is rate^2 tau / 2 for the implicit Euler method."""
    return (whole - 6.0 * half + 8.0 * quarter) / 3.0


def perturbed(amplitude: float) -> dict[str, Any]:
    """A sphere with so much of P2."""
    return {"name": "perturbed_sphere", "degree": 2, "amplitude": amplitude}


def verdict(options: Options, k: int, runs: Sequence[EntrantRun], sizes: Sizes) -> Judgement | None:
    """Of the judge; None where nothing is claimed.

    The theorem, and `order-k` where there are projections, bound the distance of x_h from the
    interpolation in H^1 by a power h^k; more than that is no surprise, for nothing moves.
    """
    claim = covering(("theorem", "order-k"), torus_case(options, sizes.order_V[0], k, sizes))
    if claim is None:
        return None
    return judge_table(
        pd.DataFrame({"h": [run.h for run in runs], "error": [run.furthest for run in runs]}),
        claim.expected_order(k, bdf=1),
        tolerance=claim.tolerance,
        stationary=True,
        declared_super=True,
    )


def cost_row(entrant: str, options: Options, sizes: Sizes) -> Row:
    """Seconds of the processor a step, the median, on the sphere with P_2."""
    solution = GROUNDS["1 + 0.2 P2 sphere"]
    time = sizes.cost_steps * sizes.cost_tau
    case = case_of(options, solution, sizes.cost_V, sizes.cost_tau, time)
    run = run_entrant(case, compare=False)
    seconds = float(np.median(run.seconds)) if run.ended == "ok" else np.nan
    return {"scheme": entrant, "N": run.nodes, "ended": run.ended, "CPU s a step": seconds}


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


def shown_step(tau: float) -> str:
    """A largest stable step for eyes; where no larger one was tried, ">=" it."""
    if tau == 0.0:
        return "none"
    return f">= {LARGEST:g}" if tau >= LARGEST else f"{tau:.2g}"


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
