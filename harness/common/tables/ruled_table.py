"""Tables with | between their columns: Markdown, org-mode, grids, and as databases print them."""

import re
from collections.abc import Sequence

from esfem.common.tables.number_text import parsed
from esfem.common.tables.text_table import Row, TextTable, regular

# Boxes of Unicode, as the | - + that they draw.
BOXES = str.maketrans(
    {**dict.fromkeys("│┃║┆┊╎", "|"), **dict.fromkeys("─━═╌┄", "-"), **dict.fromkeys(
        "┌┐└┘├┤┬┴┼╞╡╪╔╗╚╝╠╣╦╩╬┏┓┗┛┣┫┳┻╋╭╮╰╯╤╧╟╢┠┨┯┷┿", "+")}
)  # fmt: skip
RULE = re.compile(r"\s*[|+:=\-][|+:=\-\s]*")
BAR = re.compile(r"(?<!\\)\|")
BARS = (BAR, re.compile(r"(?:^|(?<=\s))\|(?=\s|$)"))  # norms have bars too, not between blanks
TYPE = re.compile(r"(?:[fiu](?:8|16|32|64)|str|String|Float64|Int64|bool|Bool)\??")
TAG = re.compile(r"</?(?:b|i|em|strong|sub|sup)>")

Line = tuple[int, str]


def ruled_tables(lines: Sequence[Line]) -> list[TextTable]:
    """The tables of this kind in a text, which may hold anything around them."""
    runs: list[list[Line]] = [[]]
    for number, line in lines:
        drawn = line.translate(BOXES)
        if line.lstrip().startswith(("#", "%")):
            continue
        if BAR.search(drawn) or (RULE.fullmatch(drawn) and re.search("[-=].*[+]|[+].*[-=]", drawn)):
            runs[-1].append((number, drawn))
        elif runs[-1]:
            runs.append([])
    return [_table(run) for run in runs if len(run) > 1 and _has_bars(run)]


def _has_bars(run: Sequence[Line]) -> bool:
    return sum(bool(BAR.search(line)) for _, line in run) > 1


def _table(run: Sequence[Line]) -> TextTable:
    lines = [(n, line.strip()) for n, line in run if not RULE.fullmatch(line)]
    opened = all(line.startswith("|") for _, line in lines)
    closed = all(line.endswith("|") for _, line in lines)
    ways = ([Row(n, _cells(line, opened, closed, bar)) for n, line in lines] for bar in BARS)
    rows = min(ways, key=lambda found: len({len(row.cells) for row in found}))
    rows = [row for row in rows if not all(TYPE.fullmatch(cell) for cell in row.cells if cell)]
    rows = [row for row in rows if any(cell.strip(" -") for cell in row.cells)]
    first = next((i for i, row in enumerate(rows) if _is_data(row)), len(rows))
    head = [row.cells for row in rows[: max(first, 1)]]
    return regular(stacked(head), rows[max(first, 1) :], _dialect(run))


def _cells(line: str, opened: bool, closed: bool, bar: re.Pattern[str]) -> tuple[str, ...]:
    cells = bar.split(line)[opened:]
    if closed and len(cells) > 1:
        cells = cells[:-1]
    return tuple(TAG.sub("", cell.replace("\\|", "|")).strip() for cell in cells)


def _is_data(row: Row) -> bool:
    values = (v if (v := parsed(c)) is not None else parsed(c, "comma") for c in row.cells)
    return any(value is not None and value == value for value in values)


def stacked(head: Sequence[Sequence[str]]) -> list[str]:
    """One name a column, of one or more lines of names above each other."""
    width = max((len(cells) for cells in head), default=0)
    if any(len(cells) != width for cells in head):
        return list(head[-1])
    return [" ".join(part for part in parts if part) for parts in zip(*head, strict=True)]


def _dialect(run: Sequence[Line]) -> str:
    rules = [line.strip() for _, line in run if RULE.fullmatch(line)]
    if any(rule.startswith("|") and "+" in rule for rule in rules):
        return "org-mode table"
    if any("+" in rule for rule in rules):
        return "grid of | and +"
    return "Markdown table" if rules else "table of |"
