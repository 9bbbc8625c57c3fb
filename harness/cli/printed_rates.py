"""Rates that a table prints beside its errors tell from which mesh widths they were computed."""

from collections.abc import Sequence

import numpy as np

from esfem.cli.column_names import norm
from esfem.cli.column_reader import ColumnReader
from esfem.cli.series import Array

MEANT = 0.03  # how far a printed rate may lie from that of the errors beside it


def explained(reader: ColumnReader, rates: Sequence[int], errors: Sequence[int], h: Array) -> str:
    """The error whose printed rates these mesh widths give, "" if there is none."""
    for j in rates:
        printed = reader.loose(j)[1:]
        for i in owners(reader, j, errors):
            e = reader.loose(i)
            with np.errstate(all="ignore"):
                own, reduction = np.diff(np.log(e)) / np.diff(np.log(h)), e[:-1] / e[1:]
            if agree(own, printed) and not agree(reduction, printed):
                return reader.shown(i)
    return ""


def contradicted(
    reader: ColumnReader, rates: Sequence[int], errors: Sequence[int], h: Array
) -> str:
    """The error that has a printed rate which is not its own with these mesh widths, "" if none."""
    for j in rates:
        printed = reader.loose(j)[1:]
        for i in owners(reader, j, errors):
            with np.errstate(all="ignore"):
                own = np.diff(np.log(reader.loose(i))) / np.diff(np.log(h))
            seen = np.isfinite(own) & np.isfinite(printed)
            if (np.abs(own - printed) > MEANT * (1 + np.abs(printed)))[seen].any():
                return reader.shown(i)
    return ""


def other_rates(reader: ColumnReader, errors: Sequence[int], h: Array | None) -> list[str]:
    """What there is to say of printed rates that are not at all those of h: it may be another."""
    if h is None or len(np.unique(h)) != len(h):
        return []
    found = []
    for j in reader.of_kind("rate"):
        for i in owners(reader, j, errors):
            with np.errstate(all="ignore"):
                e, printed = reader.loose(i), reader.loose(j)[1:]
                own, reduction = np.diff(np.log(e)) / np.diff(np.log(h)), e[:-1] / e[1:]
            seen = np.isfinite(own) & np.isfinite(printed)
            off = np.abs(own - printed)[seen] > 0.2 * np.abs(printed)[seen] + 0.2
            if off.sum() >= 2 and off.all() and not agree(reduction, printed):
                at = int(np.flatnonzero(seen)[-1])
                found.append(
                    f"mind: {reader.table.place(at + 1)} prints a rate of {printed[at]:.3g} for "
                    f"{reader.shown(i)}, and it is {own[at]:.3g} in this h"
                )
    return found


def owners(reader: ColumnReader, rate: int, errors: Sequence[int]) -> list[int]:
    """The errors that a column of rates belongs to: those of its norm, or else the last before."""
    own = norm(reader.shown(rate))
    found = [i for i in errors if own and norm(reader.shown(i)) == own]
    before = [i for i in errors if i < rate]
    return [i for i in found if i in before[-1:]] or found or before[-1:]


def agree(rates: Array, printed: Array) -> bool:
    """Whether two rates or more were printed, and all are these, which are not all 0."""
    seen = np.isfinite(rates) & np.isfinite(printed)
    near = np.abs(rates - printed) <= MEANT * (1 + np.abs(printed))
    return bool(seen.sum() >= 2 and near[seen].all() and np.abs(printed[seen]).max() > 0.2)
