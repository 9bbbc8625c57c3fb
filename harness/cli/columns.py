"""Which columns of a table are h, tau and errors: as asked, or by names that all know; and said."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from esfem.cli.column_names import compact, derivatives, norm, tokens
from esfem.cli.column_reader import Asked, ColumnReader
from esfem.cli.mesh_widths import mesh_widths
from esfem.cli.printed_rates import other_rates
from esfem.cli.series import Series
from esfem.common.bad_input import BadInput
from esfem.common.tables import DecimalMark, TextTable, decimal_mark


@dataclass(frozen=True)
class Chosen:
    """The series of a table, an error column each, and what was taken for what."""

    series: tuple[Series, ...]
    said: str


def chosen_columns(table: TextTable, asked: Asked) -> Chosen:
    """The series in a table.

    Raises
    ------
    BadInput
        If a column is missing, unclear or holds what is no number, naming row and column.
    """
    reader = ColumnReader(table, _mark(table, asked.decimal))
    errors = _error_columns(reader, asked)
    tau = _tau_column(reader, asked)
    widths = mesh_widths(reader, asked, errors, has_tau=tau is not None)
    values = {i: reader.numbers(i) for i in errors}
    steps = None if tau is None else reader.numbers(tau)
    empty = np.all([np.isnan(column) for column in values.values()], axis=0)
    left_out = empty & reader.summaries()
    if widths.h is not None:
        left_out |= empty & np.isnan(widths.h)
    kept = np.flatnonzero(~left_out)
    status = reader.status()
    taken = [f"h: {widths.said}"] if widths.said else []
    taken += [f"tau: {reader.shown(tau)}"] if tau is not None else []
    taken += [f"errors: {', '.join(reader.shown(i) for i in errors)}"]
    if len(kept) < len(table.rows):
        gone = ", ".join(table.place(i) for i in np.flatnonzero(left_out).tolist())
        taken += [f"left out: {gone}, without an error"]
    taken += other_rates(reader, errors, widths.h)
    series = [
        Series(
            name=reader.shown(i) if len(errors) > 1 else "",
            h=widths.h,
            tau=steps,
            error=values[i],
            status=status,
            places=tuple(table.place(j) for j in range(len(table.rows))),
            h_name=widths.name,
            more=reader.extras(),
        ).at(kept)
        for i in errors
    ]
    dialect = table.dialect + (", decimal commas" if reader.mark == "comma" else "")
    head = f"{dialect}, {len(table.rows)} row{'' if len(table.rows) == 1 else 's'}"
    return Chosen(tuple(_by_variable(series, reader, kept, asked)), "; ".join([head, *taken]))


def _mark(table: TextTable, asked: DecimalMark | None) -> DecimalMark:
    if asked is not None:
        return asked
    found = decimal_mark(cell for row in table.rows for cell in row.cells)
    if found is None:
        raise BadInput(
            "numbers such as 1,024 may have a decimal comma or one between thousands: "
            "choose with --decimal comma or --decimal point"
        )
    return found


def _error_columns(reader: ColumnReader, asked: Asked) -> list[int]:
    if asked.errors:
        return list(dict.fromkeys(reader.find(name, "--error") for name in asked.errors))
    found = reader.of_kind("error")
    if not found:
        raise BadInput(
            f"no column of errors is known among {reader.listed()}: give it with --error COLUMN"
        )
    shown = [reader.shown(i) for i in found]
    for name in shown:
        if shown.count(name) > 1:
            raise BadInput(f"{shown.count(name)} columns are called {name}: give them two names")
    return found


def _tau_column(reader: ColumnReader, asked: Asked) -> int | None:
    if asked.tau is not None:
        return reader.find(asked.tau, "--tau")
    found = reader.of_kind("tau")
    if len(found) > 1:
        raise BadInput(f"{reader.those(found)}: choose the time step with --tau COLUMN")
    return found[0] if found else None


def _by_variable(
    series: Sequence[Series], reader: ColumnReader, kept: np.ndarray, asked: Asked
) -> list[Series]:
    """The series, one for each variable of a table with several below each other."""
    names = reader.variables()
    if names is None:
        if asked.variable is not None:
            raise BadInput(f"--variable {asked.variable}: the table has no column variable")
        return list(series)
    own = np.array(names, dtype=object)[kept]
    known = list(dict.fromkeys(own))
    if asked.variable is not None and asked.variable not in known:
        raise BadInput(f"--variable {asked.variable}: the table has {', '.join(known)}")
    wanted = known if asked.variable is None else [asked.variable]
    return [
        replace(one.at(own == name), name=", ".join(part for part in (name, one.name) if part))
        for name in wanted
        for one in series
    ]


def order_classes(names: Sequence[str]) -> dict[int, list[str]]:
    """The names by the derivatives that their norms measure, as far as they tell."""
    classes: dict[int, list[str]] = {}
    for name in names:
        classes.setdefault(derivatives(name), []).append(name)
    return classes


def called(names: Sequence[str], label: str) -> list[int]:
    """Which error columns go by a label: by their name or else, if it is a norm, by their norm."""
    exact = [i for i, name in enumerate(names) if name == label]
    exact = exact or [i for i, name in enumerate(names) if compact(name) == compact(label)]
    if exact or len(tokens(label)) != 1 or not norm(label):
        return exact
    return [i for i, name in enumerate(names) if norm(name) == norm(label)]
