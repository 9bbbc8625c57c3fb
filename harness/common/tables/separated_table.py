"""Tables whose fields are parted by commas, semicolons or tabs, or stand in columns of blanks.

Above them may be lines of comment (#, %, !, //) or of text; the last line before the first row of
numbers has the names, or the last comment does.
"""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass

from esfem.common.bad_input import BadInput
from esfem.common.tables.blank_table import names_above, words
from esfem.common.tables.number_text import parsed
from esfem.common.tables.text_table import Row, TextTable, numbered, regular

COMMENT = re.compile(r"\s*(?:[#%!]|//)+\s?(.*)")
RULING = set(" \t|+:=_-")  # a line of them is a rule below names or at the ends of a table
FOOTER = re.compile(r"\s*(?:\[\d+ rows x \d+ columns\]|\(\d+ rows?\))\s*")
DESCRIBED = re.compile(r"(\d+):\s*(.*)")  # a column, as deal.II describes it in a comment
# Units or types, of which a line may stand below the names.
UNIT = re.compile(r"[\[(].*[\])]|<\w+>|(?:Float|Int|UInt)\d+\??|String\d*\??|Bool\??|-|")
DIALECTS = {
    "\t": "tab-separated",
    ";": "semicolon-separated",
    ",": "comma-separated",
    " ": "in columns of blanks",
}

Line = tuple[int, str]  # its number, counted from 1, and its text


@dataclass(frozen=True)
class Parts:
    """The lines of a text: comments above the rows, text above them, the rule below the names, ""
    if there is none, and the rows."""

    comments: tuple[Line, ...]
    above: tuple[Line, ...]
    rule: str
    rows: tuple[Line, ...]


def separated_table(lines: Sequence[Line]) -> TextTable:
    """The table of a text that is nothing but one.

    Raises
    ------
    BadInput
        If it is none, naming the first row that does not fit.
    """
    declared = re.fullmatch(r"\s*sep=([,;\t])\s*", lines[0][1])
    if declared:
        lines = lines[1:]
    if any(line.endswith("\\") for _, line in lines):
        return _unbroken(lines)
    text = "\n".join(line for _, line in lines if not COMMENT.fullmatch(line))
    candidates = [mark for mark in "\t;," if mark in text] + [" "]
    if declared:
        candidates = [declared[1]]
    complaints = []
    for mark in candidates:
        try:
            table = _table(lines, mark)
        except BadInput as error:
            complaints.append(error)
            continue
        if len(table.names) > 1:
            return table
        complaints.append(BadInput(f"there is one column alone, {table.names[0]}"))
    raise complaints[0]


def _unbroken(lines: Sequence[Line]) -> TextTable:
    """The table that pandas breaks into blocks below each other, whose names end with a backslash;
    the index begins the rows of each."""
    blocks: list[list[Line]] = []
    in_rows = True
    for number, line in lines:
        is_row = has_numbers(words(line))
        if in_rows and not is_row:
            blocks.append([])
        if not blocks:
            raise BadInput(f"line {number}: a row without names above it")
        blocks[-1].append((number, line.rstrip("\\ ") if not is_row else line))
        in_rows = is_row
    first, *others = (_table(block, " ") for block in blocks)
    names, rows = list(first.names), [list(row.cells) for row in first.rows]
    for table in others:
        skip = int(table.names[0] == "")
        if len(table.rows) != len(rows):
            raise BadInput(f"blocks of {len(rows)} and {len(table.rows)} rows below each other")
        for i, (row, more) in enumerate(zip(rows, table.rows, strict=True)):
            if skip and row[0] != more.cells[0]:
                raise BadInput(
                    f"{table.place(i)}: blocks below each other have rows {row[0]} and "
                    f"{more.cells[0]} beside each other"
                )
            row += more.cells[skip:]
        names += table.names[skip:]
    found = [Row(row.line, tuple(cells)) for row, cells in zip(first.rows, rows, strict=True)]
    return regular(names, found, first.dialect)


def _table(lines: Sequence[Line], mark: str) -> TextTable:
    parts = _parts(lines if mark == " " else _whole(lines, mark), mark)
    if not parts.rows:
        return regular(_fields(parts.above[-1], mark) if parts.above else (), (), DIALECTS[mark])
    rows = _read(parts.rows, mark)
    described = _described(parts.comments)
    if described and not parts.above:
        return regular(described, rows, "deal.II's ConvergenceTable")
    names, dialect = _names(parts, mark, rows)
    if names:
        return regular(names, rows, dialect)
    return regular(numbered(len(rows[0].cells)), rows, f"{dialect}, without names", named=False)


def _parts(lines: Sequence[Line], mark: str) -> Parts:
    comments: list[Line] = []
    above: list[Line] = []
    rows: list[Line] = []
    rule = ""
    for number, line in lines:
        comment = COMMENT.fullmatch(line)
        if comment and not rows:
            comments.append((number, comment[1]))
        if _is_rule(line) and above and not rows:
            rule = line
        if comment or not line.strip() or _is_rule(line) or FOOTER.fullmatch(line):
            continue
        if rows or has_numbers(_loosely(line, mark)):
            rows.append((number, re.sub(r"\s+[#%]\s.*", "", line)))
        else:
            above.append((number, line))
    if len(above) > 1 and all(
        UNIT.fullmatch(cell.strip()) for cell in _loosely(above[-1][1], mark)
    ):
        above.pop()
    return Parts(tuple(comments), tuple(above), rule, tuple(rows))


def _whole(lines: Sequence[Line], mark: str) -> list[Line]:
    """The lines, where those that a quoted field goes on in are one; a quote that is not closed is
    left as it is."""
    found: list[Line] = []
    i = 0
    while i < len(lines):
        number, line = lines[i]
        for end in range(i, len(lines)):
            whole = " ".join(text for _, text in lines[i : end + 1])
            if COMMENT.fullmatch(line) or _closed(whole, mark):
                line, i = whole, end
                break
        found.append((number, line))
        i += 1
    return found


def _closed(line: str, mark: str) -> bool:
    """Whether each quote in a line ends in it."""
    try:
        list(csv.reader([line], delimiter=mark, strict=True, skipinitialspace=True))
    except csv.Error:
        return False
    return True


def _is_rule(line: str) -> bool:
    return set(line) <= RULING and any(twice in line for twice in ("--", "==", "__"))


def _loosely(line: str, mark: str) -> Sequence[str]:
    return words(line) if mark == " " else line.replace('"', "").split(mark)


def has_numbers(cells: Sequence[str]) -> bool:
    """Whether half of the cells, and one at least, are numbers in some dialect."""
    values = [parsed(cell) if parsed(cell) is not None else parsed(cell, "comma") for cell in cells]
    finite = [value for value in values if value is not None and value == value]
    return bool(finite) and 2 * len([v for v in values if v is not None]) >= len(cells)


def _fields(line: Line, mark: str) -> tuple[str, ...]:
    return _read([line], mark)[0].cells


def _read(lines: Sequence[Line], mark: str) -> list[Row]:
    if mark == " ":
        return [Row(number, tuple(w.strip('"') for w in words(line))) for number, line in lines]
    reader = csv.reader(
        [f"{line}\n" for _, line in lines], delimiter=mark, strict=True, skipinitialspace=True
    )
    rows, first = [], 0
    try:
        for cells in reader:
            rows.append(Row(lines[first][0], tuple(cells)))
            first = reader.line_num
    except csv.Error as error:
        raise BadInput(f"line {lines[first][0]} cannot be read: {error}") from error
    return rows


def _described(comments: Sequence[Line]) -> tuple[str, ...]:
    """The names of columns that comments describe one by one: "# 1: cells"."""
    found = [match for _, text in comments if (match := DESCRIBED.fullmatch(text))]
    counted = [int(match[1]) for match in found] == list(range(1, len(found) + 1))
    return tuple(match[2].strip() for match in found) if counted else ()


def _names(parts: Parts, mark: str, rows: Sequence[Row]) -> tuple[Sequence[str], str]:
    """The names of the columns, none if there are none, and the dialect."""
    dialect, width = DIALECTS[mark], len(rows[0].cells)
    if mark == " ":
        if parts.above:
            lines = [line for _, line in parts.rows]
            found = names_above([line for _, line in parts.above], lines, parts.rule)
            return found.names, found.dialect
        for _, comment in reversed(parts.comments):
            for names in (words(comment), re.split(r"\s{2,}", comment.strip())):
                if len(names) == width:
                    return names, dialect
        return (), dialect
    if parts.above:
        names = list(_fields(parts.above[-1], mark))
        while len(names) > width and not names[-1].strip():
            names.pop()
        # A line of comment, in a table of names: "#h,error" is no comment but its first name.
        return names, dialect
    for line in reversed(parts.comments):
        for names in (_fields(line, mark), words(line[1])):
            if len(names) == width:
                return names, dialect
    return (), dialect
