"""The largest stable time step of a scheme, by bisection."""

from collections.abc import Callable
from typing import Any

from esfem.campaigns.contest.contest import Options, case_of
from esfem.campaigns.contest.march import march

STEPS = 20
GROWTH = 1.1  # of the own energy over these steps that still counts as stable
LARGEST, SMALLEST = 1.0, 1e-6
FACTOR = 1.1  # between the stable and the unstable end of the answer


def is_stable(options: Options, solution: dict[str, Any], V: int, tau: float) -> bool:
    """Whether `STEPS` steps with P_2 run to their end and the scheme's own energy never exceeds
    `GROWTH` times its start."""
    found = march(case_of(options, solution, V, tau, STEPS * tau), compare=False)
    own = found.levels["own_energy"]
    bounded = all(energy <= GROWTH * own[0] for energy in own)  # NaN is not
    return found.ended == "ok" and bounded


def largest_stable(stable: Callable[[float], bool]) -> float:
    """The largest step up to which halving and bisection found a scheme stable, within `FACTOR`.

    `LARGEST` if that is stable, 0.0 if not even `SMALLEST` is. Steps are tried from above, so that
    a scheme may be unstable for some smaller step.
    """
    tau = LARGEST
    if stable(tau):
        return tau
    while not stable(tau / 4):
        tau /= 4
        if tau < SMALLEST:
            return 0.0
    low, high = tau / 4, tau
    while high / low > FACTOR:
        middle = (low * high) ** 0.5
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def shown_step(tau: float) -> str:
    """A largest stable step for eyes; where no larger one was tried, ">=" it."""
    if tau == 0.0:
        return "none"
    return f">= {LARGEST:g}" if tau >= LARGEST else f"{tau:.2g}"
