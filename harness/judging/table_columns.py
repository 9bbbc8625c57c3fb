"""Anybody's table as columns of numbers: a mapping of columns, a structured array, a DataFrame."""

from collections.abc import Mapping
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from esfem.common.bad_input import BadInput

Array: TypeAlias = NDArray[np.float64]


class Frame(Protocol):
    """What is asked of a DataFrame: its columns by their names."""

    @property
    def columns(self) -> Any: ...

    def __getitem__(self, name: str, /) -> Any: ...


Table: TypeAlias = Mapping[str, ArrayLike] | Frame | NDArray[np.void]


def column_names(table: Table) -> list[str]:
    """The names of the columns of a table."""
    if isinstance(table, np.ndarray):
        return list(table.dtype.names or ())
    return [str(name) for name in (table if isinstance(table, Mapping) else table.columns)]


def column(table: Table, name: str) -> NDArray[Any]:
    """A column as it is.

    Raises
    ------
    BadInput
        If there is none of this name.
    """
    names = column_names(table)
    if name not in names:
        raise BadInput(f"column {name}: missing; there are {', '.join(names)}")
    return np.atleast_1d(np.asarray(table[name]))


def numbers(table: Table, name: str) -> Array:
    """A column of numbers, NaN where there is none.

    Raises
    ------
    BadInput
        If there is no such column, or something in it is no number.
    """
    found = column(table, name)
    if found.dtype.kind in "fiub":
        return found.astype(float)
    return np.array([_number(value, name, row) for row, value in enumerate(found.tolist(), 1)])


def _number(value: object, name: str, row: int) -> float:
    if value is None or type(value).__name__ == "NAType":  # that of pandas
        return float("nan")
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise BadInput(f"column {name}, row {row}: {value!r} is not a number") from error
