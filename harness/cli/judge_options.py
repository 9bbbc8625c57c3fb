"""What the options of `esfem judge` say: orders, floors and levels, and whose order is which."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import get_args

from esfem.cli.columns import called, order_classes
from esfem.cli.series import Claim, Series
from esfem.common.bad_input import BadInput
from esfem.judging.floors import Floor, FloorName


def parsed_orders(options: Sequence[str]) -> dict[str, float]:
    """The orders by label, "" where none is given: "2" and "l2=3".

    Raises
    ------
    BadInput
        If one is not positive and finite, or given twice.
    """
    orders: dict[str, float] = {}
    for option in options:
        label, _, value = option.rpartition("=")
        label = label.strip()
        if label in orders:
            raise BadInput(f"--order {option}: an order{f' of {label}' if label else ''} is given")
        orders[label] = positive("--order", value, option)
    return orders


def positive(option: str, value: str, shown: str = "") -> float:
    """The value of an option, positive and finite."""
    try:
        number = float(value)
    except ValueError:
        number = float("nan")
    if not (isfinite(number) and number > 0):
        raise BadInput(f"{option} {shown or value}: must be positive and finite")
    return number


def parsed_floors(options: Sequence[str]) -> tuple[Floor, ...]:
    """Floors of options such as "rounding=1e-14"."""
    return tuple(_floor(option) for option in options)


def _floor(option: str) -> Floor:
    name, _, value = option.partition("=")
    names = get_args(FloorName)
    found = [known for known in names if known == name.strip()]
    if not found:
        raise BadInput(f"--floor {option}: must be NAME=VALUE with a name of {', '.join(names)}")
    return Floor(found[0], positive("--floor", value, option))


def parsed_levels(option: str) -> tuple[int, int | None]:
    """The levels of an option such as "3:" or "2:6", from 1, the coarsest, both ends included."""
    first, colon, last = option.partition(":")
    try:
        start, stop = int(first or 1), int(last) if last.strip() else None
    except ValueError:
        colon = ""
        start, stop = 1, None
    if not colon or start < 1 or (stop is not None and stop < start):
        raise BadInput(
            f"--levels {option}: must be FIRST:LAST, counted from 1, the coarsest; "
            "either may be left out"
        )
    return start - 1, stop


def claims(
    series: Sequence[Series], orders: Mapping[str, float], common: Claim, chosen: bool
) -> list[tuple[Series, Claim]]:
    """Which series are judged, and by which claim.

    Labels are names of error columns, or norms; h and tau are orders in them, and "" is the order
    of all that have none of their own.  With labels alone, what they name is judged, unless the
    columns were ``chosen``.

    Raises
    ------
    BadInput
        If a label names nothing, a series has no order, or one order is given for norms whose
        orders differ.
    """
    own, common = _of_parameters(dict(orders), common)
    names = [one.name for one in series]
    by_series: dict[int, float] = {}
    for label, order in own.items():
        found = called(names, label) if label else []
        if label and not found:
            known = ", ".join(name for name in names if name) or "one column"
            raise BadInput(f"--order {label}={order:g}: no errors are called so; there are {known}")
        by_series.update(dict.fromkeys(found, order))
    rest = [i for i in range(len(series)) if i not in by_series]
    if "" in own:
        _check_classes([names[i] for i in rest])
        by_series.update(dict.fromkeys(rest, own[""]))
    elif rest and (chosen or not by_series):
        missing = ", ".join(names[i] or "the errors" for i in rest)
        raise BadInput(f"--order: is missing for {missing}")
    return [(series[i], replace(common, order=by_series[i])) for i in sorted(by_series)]


def _of_parameters(orders: dict[str, float], common: Claim) -> tuple[dict[str, float], Claim]:
    """Takes h= and tau= out of the orders: that of the judged parameter, and that of the other."""
    h, tau = orders.pop("h", None), orders.pop("tau", None)
    judged, other = (tau, h) if common.direction == "tau" else (h, tau)
    if judged is not None:
        if "" in orders:
            raise BadInput(f"--order: two are given in {common.direction or 'h'}")
        orders[""] = judged
    return orders, replace(common, other_order=other)


def _check_classes(names: Sequence[str]) -> None:
    classes = order_classes(names)
    if len(classes) > 1:
        first, second = (group[0] for group in list(classes.values())[:2])
        raise BadInput(
            f"--order: {first} and {second} are norms of different orders: give each its own "
            f"(--order {first}=K --order {second}=K), or choose with --error COLUMN"
        )
