"""Why a table has no better outcome, in sentences for a reader who knows the table alone: what was
seen, and what it may mean.  What to run next is said beside them, once (`advice`)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from esfem.judging.table_columns import Array


@dataclass(frozen=True)
class Seen:
    """What a sentence may tell of: the judged parameter and levels, orders, scatter."""

    name: str  # of the judged parameter
    other: str  # of the other one, "" in a table without it
    s: Array
    e: Array
    claim: float
    tolerance: float
    lower: float = float("nan")
    upper: float = float("nan")
    scatter: float = float("nan")
    fewest: int = 4
    probability: float = float("nan")  # of an order that is accepted
    share: float = 0.0  # of the part in the other parameter, on the finest levels of both

    @property
    def least(self) -> float:
        """The order that is accepted."""
        return self.claim - self.tolerance

    @property
    def near(self) -> str:
        """Where the finest error lies, if there is one."""
        return f" near {self.e[-1]:.1e}" if len(self.e) else ""

    @property
    def rates(self) -> str:
        """The rates of consecutive levels, four at most."""
        found = np.diff(np.log(self.e)) / np.diff(np.log(self.s))
        return ", ".join(f"{rate:.2f}" for rate in found[-4:])

    @property
    def chance(self) -> str:
        """The probability of an order that is accepted, and that this decides nothing."""
        return f"at least {self.least:g} with probability {self.probability:.3f}, not sure enough"

    @property
    def interval(self) -> str:
        """The interval of the order."""
        return f"from {self.lower:.2f} to {self.upper:.2f}"


def _below(seen: Seen) -> str:
    return f"orders {seen.interval} are possible, all below {seen.claim:g} - {seen.tolerance:g}"


def _suspect(seen: Seen) -> str:
    return (
        f"orders {seen.interval} are more than 1.5 above the claim, which nobody declared: the "
        "errors may not be those of the method"
    )


def _above(seen: Seen) -> str:
    return (
        f"orders {seen.interval} are possible: the claim is met, but they may be more than 1.5 "
        "above it, which nobody declared"
    )


def _few(seen: Seen) -> str:
    levels = "1 level" if len(seen.s) == 1 else f"{len(seen.s)} levels"
    return f"{levels} can be judged, and an order needs {seen.fewest}"


def _close(seen: Seen) -> str:
    return (
        f"{seen.name} falls by a factor of {seen.s[0] / seen.s[-1]:.2f} from the coarsest level to "
        "the finest one, and an order needs 2.5"
    )


def _plateau(seen: Seen) -> str:
    if seen.share > 0.5:
        part = {"tau": "time", "h": "space"}[seen.other]
        return (
            f"about {100 * min(seen.share, 0.99):.0f} % of the error is that in {part}, even at "
            f"the finest {seen.other}: too much to see how the rest falls with {seen.name}"
        )
    where = f"the errors stop falling{seen.near}: a part of them does not fall with "
    if seen.other == "tau":
        return where + f"{seen.name}; it may be the error in time"
    if seen.other == "h":
        return where + f"{seen.name}; it may be the error in space"
    return where + f"{seen.name}; it may be that of quadrature, of a solver or of the reference"


def _rounding(seen: Seen) -> str:
    return (
        f"the errors stop falling{seen.near}, where rounding or the tolerance of a "
        "solver may rule; above that there are too few levels"
    )


def _diverges(seen: Seen) -> str:
    return f"the errors grow on the finest levels, to {seen.e[-1]:.1e}: the runs may be unstable"


def _finest(seen: Seen) -> str:
    return (
        f"the error on the finest level, {seen.e[-1]:.1e}, is off the line that the others make "
        f"(rates {seen.rates}): an outlier, or the beginning of something else"
    )


def _trend(seen: Seen) -> str:
    return (
        f"the rates still change from level to level ({seen.rates}): orders {seen.interval} are "
        f"possible as {seen.name} goes to 0, {seen.chance}"
    )


def _noise(seen: Seen) -> str:
    return (
        f"the errors scatter by {100 * seen.scatter:.2g} % about a power: orders {seen.interval} "
        f"are possible, {seen.chance}"
    )


def _cancellation(seen: Seen) -> str:
    return (
        "the error is near zero on a level between others where it is not: two parts of it may "
        "cancel there, and the rates then tell of neither"
    )


def _failed(seen: Seen) -> str:
    return "a run of the ladder failed, and on its finer side there are too few levels"


def _same(seen: Seen) -> str:
    return "all errors are one and the same number: the refinement did not reach the computation"


def _zero(seen: Seen) -> str:
    return (
        "all errors are exactly 0: the solution may be compared with itself, and if it is exact, a "
        "floor of rounding has to show it"
    )


def _floor(name: str) -> Callable[[Seen], str]:
    def words(seen: Seen) -> str:
        return f"the errors are near the {FLOORS[name]} on too many levels"

    return words


FLOORS = {
    "tau": "error of the time step, as measured",
    "h": "error of the mesh, as measured",
    "solver": "tolerance of the solver",
    "quadrature": "error of quadrature",
}
SENTENCES: dict[str, Callable[[Seen], str]] = {
    "below": _below,
    "suspect": _suspect,
    "above": _above,
    "few": _few,
    "close": _close,
    "plateau": _plateau,
    "rounding": _rounding,
    "diverges": _diverges,
    "finest": _finest,
    "trend": _trend,
    "noise": _noise,
    "cancellation": _cancellation,
    "failed": _failed,
    "identical": _same,
    "zero": _zero,
    **{name: _floor(name) for name in FLOORS},
}


def sentence(code: str, seen: Seen) -> str:
    """The sentence for a code; "" for none."""
    return SENTENCES[code](seen) if code else ""
