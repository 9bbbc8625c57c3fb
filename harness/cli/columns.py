"""Which columns of a table are h, tau and errors: as asked, or by names that all know; and said."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from esfem.cli.column_names import compact, derivatives, kind, norm, tokens
from esfem.cli.series import GIVEN, Array, Series
from esfem.common.bad_input import BadInput
from esfem.common.tables import DecimalMark, TextTable, decimal_mark, parsed

DONE = ("ok", "converged", "done", "finished", "success", "successful", "true", "yes", "completed")
FAILED = ("failed", "failure", "diverged", "error", "crashed", "timeout", "killed", "false", "no")
MEANT = 0.03  # how far a printed rate may lie from that of the errors beside it
DOUBLES = 3.0  # a number of cells that grows by more from level to level may be that of all cells


@dataclass(frozen=True)
class Asked:
    """The columns that a user names; None where he leaves it to their names."""

    h: str | None = None
    dofs: str | None = None
    cells: str | None = None
    dim: int | None = None
    ratio: float | None = None
    tau: str | None = None
    errors: tuple[str, ...] = ()
    variable: str | None = None
    decimal: DecimalMark | None = None


@dataclass(frozen=True)
class Chosen:
    """The series of a table, an error column each, and what was taken for what."""

    series: tuple[Series, ...]
    said: str


@dataclass(frozen=True)
class Widths:
    """Mesh widths, and where they are from; ``h`` is None in a table of time steps alone."""

    h: Array | None
    said: str
    name: str = "h"


def chosen_columns(table: TextTable, asked: Asked) -> Chosen:
    """The series in a table.

    Raises
    ------
    BadInput
        If a column is missing, unclear or holds what is no number, naming row and column.
    """
    reader = _Reader(table, _mark(table, asked.decimal))
    errors = _error_columns(reader, asked)
    tau = _tau_column(reader, asked)
    widths = _widths(reader, asked, errors, has_tau=tau is not None)
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
    taken += _other_rates(reader, errors, widths.h)
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


class _Reader:
    """The columns of a table by name and as numbers; what is no number is refused by its place."""

    def __init__(self, table: TextTable, mark: DecimalMark) -> None:
        self.table, self.mark = table, mark
        self.kinds = [kind(name) if table.named else "" for name in table.names]
        cut = [set(row.cells) <= {"..", "...", "…"} for row in table.rows]
        if any(cut):
            raise BadInput(
                f"{table.place(cut.index(True))}: rows were cut out where it was printed"
            )

    def shown(self, i: int) -> str:
        """The name of a column, for a message."""
        return self.table.names[i] or f"column {i + 1}"

    def find(self, name: str, option: str) -> int:
        """The column of that name, in whatever case, blanks and LaTeX.

        Where there are no names it is a number, counted from 1.
        """
        names = self.table.names
        ways = (lambda n: n, lambda n: n.strip().casefold(), compact)
        for way in ways:
            found = [i for i, own in enumerate(names) if own and way(own) == way(name)]
            if len(found) == 1:
                return found[0]
            if found:
                raise BadInput(f"{option} {name}: {len(found)} columns are called so")
        listed = ", ".join(own for own in names if own)
        raise BadInput(f"{option} {name}: there is no such column; there are {listed}")

    def of_kind(self, wanted: str) -> list[int]:
        return [i for i, own in enumerate(self.kinds) if own == wanted]

    def numbers(self, i: int) -> Array:
        """A column as numbers, NaN where one is missing."""
        values = []
        for j, cell in enumerate(self.table.column(i)):
            value = parsed(cell, self.mark)
            if value is None:
                raise BadInput(
                    f"{self.table.place(j)}, column {self.shown(i)}: {cell!r} is no number"
                    f"{self._hint(cell)}; a missing one is nothing, -, --- or NaN"
                )
            values.append(value)
        return np.array(values)

    def _hint(self, cell: str) -> str:
        other: DecimalMark = "comma" if self.mark == "point" else "point"
        if parsed(cell, other) is None:
            return ""
        return (
            f" with a decimal {self.mark}, which other cells have (--decimal {other} for commas)"
            if other == "comma"
            else f" with a decimal {self.mark}, which other cells have"
        )

    def loose(self, i: int) -> Array:
        """A column as numbers, NaN where there is none."""
        values = (parsed(cell, self.mark) for cell in self.table.column(i))
        return np.array([np.nan if value is None else value for value in values])

    def summaries(self) -> np.ndarray:
        """Which rows have a word where all others of a column have a number: means, slopes."""
        found = np.zeros(len(self.table.rows), dtype=bool)
        for i in range(len(self.table.names)):
            words = np.array([parsed(cell, self.mark) is None for cell in self.table.column(i)])
            if words.sum() == 1 and len(words) > 2:
                found |= words
        return found

    def status(self) -> tuple[str, ...]:
        """The status of each row, "ok" where it came to its end."""
        columns = self.of_kind("status")
        if not columns:
            return ("ok",) * len(self.table.rows)
        found = []
        for j, cell in enumerate(self.table.column(columns[0])):
            word = cell.strip().lower()
            if word not in (*DONE, *FAILED, "", "0", "1"):
                raise BadInput(
                    f"{self.table.place(j)}, column {self.shown(columns[0])}: {cell!r} is unknown; "
                    f"it must be one of {', '.join((*DONE, *FAILED))}"
                )
            found.append("ok" if word in (*DONE, "", "1") else word)
        return tuple(found)

    def extras(self) -> dict[str, Array]:
        """Columns that the judge reads under these very names."""
        names = [name.strip() for name in self.table.names]
        return {
            name: self.numbers(names.index(name))
            for name in ("seconds", "final_time")
            if names.count(name) == 1
        }

    def variables(self) -> tuple[str, ...] | None:
        """The variable of each row, in a table of several below each other."""
        for i in self.of_kind("variable"):
            cells = self.table.column(i)
            if all(parsed(cell, self.mark) is None or not cell for cell in cells):
                if "" in cells:
                    at = self.table.place(cells.index(""))
                    raise BadInput(f"{at}, column {self.shown(i)}: a row without a name")
                return cells
        return None


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


def _error_columns(reader: _Reader, asked: Asked) -> list[int]:
    if asked.errors:
        return list(dict.fromkeys(reader.find(name, "--error") for name in asked.errors))
    found = reader.of_kind("error")
    if not found:
        raise BadInput(
            f"no column of errors is known among {_listed(reader)}: give it with --error COLUMN"
        )
    shown = [reader.shown(i) for i in found]
    for name in shown:
        if shown.count(name) > 1:
            raise BadInput(f"{shown.count(name)} columns are called {name}: give them two names")
    return found


def _tau_column(reader: _Reader, asked: Asked) -> int | None:
    if asked.tau is not None:
        return reader.find(asked.tau, "--tau")
    found = reader.of_kind("tau")
    if len(found) > 1:
        raise BadInput(f"{_names(reader, found)}: choose the time step with --tau COLUMN")
    return found[0] if found else None


def _widths(reader: _Reader, asked: Asked, errors: Sequence[int], has_tau: bool) -> Widths:
    """The mesh widths: as asked; a column of them; from a number of cells; from printed rates."""
    given = {"--h": asked.h, "--dofs": asked.dofs, "--cells": asked.cells, "--ratio": asked.ratio}
    several = [option for option, value in given.items() if value is not None]
    if len(several) > 1:
        raise BadInput(f"{' and '.join(several)}: give one of them")
    if asked.h is not None:
        i = reader.find(asked.h, "--h")
        return Widths(reader.numbers(i), reader.shown(i), f"{GIVEN}{reader.shown(i)}")
    if asked.dofs is not None or asked.cells is not None:
        option = "--dofs" if asked.dofs is not None else "--cells"
        return _asked_count(reader, option, str(asked.dofs or asked.cells), asked.dim)
    if asked.ratio is not None:
        h = np.power(asked.ratio, np.arange(len(reader.table.rows), dtype=float))
        return Widths(h, f"{asked.ratio:g} times the one of the row above (--ratio)")
    if found := reader.of_kind("h"):
        i = _first_of(reader, found)
        return Widths(reader.numbers(i), reader.shown(i), reader.shown(i))
    return _counted(reader, asked.dim, errors, has_tau)


def _asked_count(reader: _Reader, option: str, name: str, dim: int | None) -> Widths:
    i = reader.find(name, option)
    if option == "--dofs" and dim is None:
        raise BadInput(f"--dofs {name}: needs --dim, for h = dofs^(-1 / dim)")
    return _of_count(reader, i, dim or 1)


def _of_count(reader: _Reader, i: int, dim: int, by: str = "") -> Widths:
    """h = N^(-1 / dim)."""
    values = reader.numbers(i)
    for j in np.flatnonzero(~(values > 0)).tolist():
        if np.isfinite(values[j]):
            place = reader.table.place(j)
            raise BadInput(f"{place}, column {reader.shown(i)}: {values[j]:g}: must be positive")
    name = reader.shown(i)
    base = f"({name})" if "/" in name else name
    power = f"1 / {base}" if dim == 1 else f"{base}^(-1/{dim})"
    return Widths(
        np.asarray(values ** (-1.0 / dim), dtype=np.float64), f"{power}{by}", f"{GIVEN}{name}"
    )


def _counted(reader: _Reader, dim: int | None, errors: Sequence[int], has_tau: bool) -> Widths:
    """Mesh widths of a table without a column of them."""
    cells = [i for i in reader.of_kind("cells") if _is_count(reader.loose(i))]
    dofs = [i for i in reader.of_kind("dofs") if _is_count(reader.loose(i))]
    if dim is not None:
        if not cells and not dofs:
            raise BadInput(f"--dim {dim}: there is no column of cells or dofs: give --dofs COLUMN")
        return _of_count(reader, (_of_all(reader, cells) or dofs or cells)[0], dim)
    if reader.table.halves:
        return _halved_by_trixi(reader, errors)
    if (meant := _by_printed_rates(reader, (*cells, *dofs), errors)) is not None:
        return meant
    if cells:
        return _per_direction(reader, cells)
    if has_tau:
        return Widths(None, "")
    if dofs:
        name = reader.shown(dofs[0])
        raise BadInput(f"there is no mesh width: give --dofs {name} --dim 1, 2 or 3")
    raise BadInput(
        f"no column of mesh widths is known among {_listed(reader)}: give --h COLUMN, "
        "--cells COLUMN, --dofs COLUMN --dim D, --tau COLUMN, or --ratio R if each row refines "
        "the one above"
    )


def _of_all(reader: _Reader, cells: Sequence[int]) -> list[int]:
    """Columns that count all cells of a mesh, not those in a direction."""
    return [i for i in cells if compact(reader.shown(i)) not in ("n", "nx", "resolution")]


def _per_direction(reader: _Reader, cells: Sequence[int]) -> Widths:
    i = cells[0]
    values, name = reader.numbers(i), reader.shown(i)
    levels = np.unique(values[np.isfinite(values)])
    if len(levels) > 1 and (levels[1:] / levels[:-1]).min() >= DOUBLES:
        raise BadInput(
            f"column {name}: grows by {levels[1] / levels[0]:.3g} a level: is it the number of "
            f"cells in each direction (--cells {name}) or of all (--cells {name} --dim 2)?"
        )
    return _of_count(reader, i, 1)


def _is_count(values: Array) -> bool:
    """Whether numbers may be of cells: whole, growing, and not the numbers of the levels."""
    finite = values[np.isfinite(values)]
    if len(finite) < 2 or finite.min() < 1 or (finite != np.rint(finite)).any():
        return False
    return len(np.unique(finite)) > 1 and not (len(finite) > 2 and (np.diff(finite) == 1).all())


def _by_printed_rates(
    reader: _Reader, counts: Iterable[int], errors: Sequence[int]
) -> Widths | None:
    """Mesh widths that give the rates which the table prints beside its errors, None without such:
    those of a number of cells or dofs in 1, 2 or 3 dimensions, or halved from row to row."""
    rates = reader.of_kind("rate")
    halved = np.exp2(-np.arange(len(reader.table.rows), dtype=float))
    for i in counts:
        for dim in (1, 2, 3):
            h = np.asarray(reader.loose(i) ** (-1.0 / dim), float)
            if beside := _explained(reader, rates, errors, h):
                by = f", as the rates beside {beside} say"
                return _of_count(reader, i, dim, by)
    if beside := _explained(reader, rates, errors, halved):
        return Widths(halved, f"halved from row to row, as the rates beside {beside} say")
    return None


def _halved_by_trixi(reader: _Reader, errors: Sequence[int]) -> Widths:
    """Halved from row to row, as Trixi does, unless its own rates say another thing."""
    halved = np.exp2(-np.arange(len(reader.table.rows), dtype=float))
    for j in reader.of_kind("rate"):
        for i in _owners(reader, j, errors):
            with np.errstate(all="ignore"):
                own = np.log2(reader.loose(i)[:-1] / reader.loose(i)[1:])
            printed = reader.loose(j)[1:]
            seen = np.isfinite(own) & np.isfinite(printed)
            if (np.abs(own - printed) > MEANT * (1 + np.abs(printed)))[seen].any():
                raise BadInput(
                    f"the rates of {reader.shown(i)} are not those of meshes that are halved from "
                    "row to row: give --ratio R"
                )
    return Widths(halved, "halved from row to row, as Trixi does")


def _explained(reader: _Reader, rates: Sequence[int], errors: Sequence[int], h: Array) -> str:
    """The error whose printed rates these mesh widths give, "" if there is none."""
    for j in rates:
        printed = reader.loose(j)[1:]
        for i in _owners(reader, j, errors):
            e = reader.loose(i)
            with np.errstate(all="ignore"):
                own, reduction = np.diff(np.log(e)) / np.diff(np.log(h)), e[:-1] / e[1:]
            if _agree(own, printed) and not _agree(reduction, printed):
                return reader.shown(i)
    return ""


def _other_rates(reader: _Reader, errors: Sequence[int], h: Array | None) -> list[str]:
    """What there is to say of printed rates that are not at all those of h: it may be another."""
    if h is None or len(np.unique(h)) != len(h):
        return []
    found = []
    for j in reader.of_kind("rate"):
        for i in _owners(reader, j, errors):
            with np.errstate(all="ignore"):
                e, printed = reader.loose(i), reader.loose(j)[1:]
                own, reduction = np.diff(np.log(e)) / np.diff(np.log(h)), e[:-1] / e[1:]
            seen = np.isfinite(own) & np.isfinite(printed)
            off = np.abs(own - printed)[seen] > 0.2 * np.abs(printed)[seen] + 0.2
            if off.sum() >= 2 and off.all() and not _agree(reduction, printed):
                at = int(np.flatnonzero(seen)[-1])
                found.append(
                    f"mind: {reader.table.place(at + 1)} prints a rate of {printed[at]:.3g} for "
                    f"{reader.shown(i)}, and it is {own[at]:.3g} in this h"
                )
    return found


def _owners(reader: _Reader, rate: int, errors: Sequence[int]) -> list[int]:
    """The errors that a column of rates belongs to: those of its norm, or else the last before."""
    own = norm(reader.shown(rate))
    found = [i for i in errors if own and norm(reader.shown(i)) == own]
    before = [i for i in errors if i < rate]
    return [i for i in found if i in before[-1:]] or found or before[-1:]


def _agree(rates: Array, printed: Array) -> bool:
    """Whether two rates or more were printed, and all are these, which are not all 0."""
    seen = np.isfinite(rates) & np.isfinite(printed)
    near = np.abs(rates - printed) <= MEANT * (1 + np.abs(printed))
    return bool(seen.sum() >= 2 and near[seen].all() and np.abs(printed[seen]).max() > 0.2)


def _by_variable(
    series: Sequence[Series], reader: _Reader, kept: np.ndarray, asked: Asked
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


def _first_of(reader: _Reader, found: Sequence[int]) -> int:
    """h itself before other mesh widths; two of one name are unclear."""
    exact = [i for i in found if reader.shown(i) == "h"] or [
        i for i in found if compact(reader.shown(i)) in ("h", "hmax", "maxh")
    ]
    best = exact or list(found)
    if len(best) > 1:
        raise BadInput(f"{_names(reader, best)}: choose the mesh width with --h COLUMN")
    return best[0]


def _names(reader: _Reader, columns: Sequence[int]) -> str:
    return f"columns {' and '.join(reader.shown(i) for i in columns)}"


def _listed(reader: _Reader) -> str:
    if not reader.table.named:
        return f"{len(reader.table.names)} columns without names (they are 1, 2, ...)"
    return ", ".join(name for name in reader.table.names if name)


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
