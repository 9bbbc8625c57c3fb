"""The columns of a table by the names that a user or all use, and as numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from esfem.cli.column_names import compact, kind
from esfem.cli.series import Array
from esfem.common.bad_input import BadInput
from esfem.common.tables import DecimalMark, TextTable, parsed

DONE = ("ok", "converged", "done", "finished", "success", "successful", "true", "yes", "completed")
FAILED = ("failed", "failure", "diverged", "error", "crashed", "timeout", "killed", "false", "no")


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


class ColumnReader:
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

    def listed(self) -> str:
        """The names there are, for a message."""
        if not self.table.named:
            return f"{len(self.table.names)} columns without names (they are 1, 2, ...)"
        return ", ".join(name for name in self.table.names if name)

    def those(self, columns: Sequence[int]) -> str:
        """Some columns by their names, for a message."""
        return f"columns {' and '.join(self.shown(i) for i in columns)}"
