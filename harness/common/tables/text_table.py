"""A table of text: a name a column, rows of cells, and the line of the file where each row is."""

from collections.abc import Sequence
from dataclasses import dataclass

from esfem.common.bad_input import BadInput


@dataclass(frozen=True)
class Row:
    """The cells of a row, and the line of the text, counted from 1, where it stands."""

    line: int
    cells: tuple[str, ...]


@dataclass(frozen=True)
class TextTable:
    """A table as it was printed.

    ``names`` has one entry a column; a name may be empty. ``named`` says that the text has a line
    of names: without one they are the numbers of the columns, from 1. ``dialect`` is how it was
    printed, in words. ``halves`` says that the program which prints such tables halves the mesh
    width from row to row, and prints none.
    """

    names: tuple[str, ...]
    rows: tuple[Row, ...]
    dialect: str
    named: bool = True
    halves: bool = False

    def column(self, index: int) -> tuple[str, ...]:
        """The cells of a column."""
        return tuple(row.cells[index] for row in self.rows)

    def place(self, index: int) -> str:
        """Where a row is, for a message: rows and lines are counted from 1."""
        return f"row {index + 1} (line {self.rows[index].line})"


def numbered(count: int) -> tuple[str, ...]:
    """The names of columns that have none."""
    return tuple(str(i + 1) for i in range(count))


def regular(
    names: Sequence[str], rows: Sequence[Row], dialect: str, named: bool = True
) -> TextTable:
    """A table whose rows all have a cell a name; what is empty beyond the last name is dropped.

    Raises
    ------
    BadInput
        Naming the first row that has another number of cells.
    """
    if not rows:
        known = ", ".join(_printable(name) for name in names)
        raise BadInput(f"the table has no rows below its names {known}")
    kept = []
    for i, row in enumerate(rows):
        cells = list(row.cells)
        while len(cells) > len(names) and not cells[-1].strip():
            cells.pop()
        if len(cells) != len(names):
            shown = ", ".join(_printable(cell) or "nothing" for cell in cells)
            raise BadInput(
                f"row {i + 1} (line {row.line}): has {_counted(len(cells), 'field')} ({shown}), "
                f"and there {_named(names, named)}; no column is guessed"
            )
        kept.append(Row(row.line, tuple(_printable(cell) for cell in cells)))
    return TextTable(tuple(_printable(name) for name in names), tuple(kept), dialect, named)


def _printable(text: str) -> str:
    """The text on one line, without letters that steer a terminal: names and cells are shown."""
    return "".join(c if c.isprintable() else " " for c in text).strip()


def _named(names: Sequence[str], named: bool) -> str:
    if not named:
        return f"are {len(names)} in row 1"
    verb = "is" if len(names) == 1 else "are"
    return f"{verb} {_counted(len(names), 'name')} ({', '.join(map(_printable, names))})"


def _counted(number: int, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"
