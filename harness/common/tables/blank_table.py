"""Names above columns of blanks: a word a column, or as deal.II and pandas align them.

deal.II centres a name over an error and the rates behind it, whose first entries are "-"; pandas
leaves the head of its index empty, or has the name of the index in a line of its own.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

WORD = re.compile(r'"[^"]*"|\S+')
DEALII = "deal.II's ConvergenceTable"
BLANKS = "in columns of blanks"
PANDAS = "as pandas prints it"


@dataclass(frozen=True)
class Found:
    """The names of the columns, "" where there is none, and how they are printed."""

    names: tuple[str, ...]
    dialect: str


def words(line: str) -> tuple[str, ...]:
    """The words between blanks, where quotes hold several together."""
    return tuple(WORD.findall(line))


def names_above(above: Sequence[str], rows: Sequence[str], rule: str = "") -> Found:
    """The names in the last of the lines above, for rows of as many words each.

    ``rule`` is a line of dashes below the names, a piece a column, "" without one.  If names fit in
    no way, the words as they are: the caller compares their number with the rows'.
    """
    head, width = above[-1], len(words(rows[0]))
    own, apart = words(head), tuple(re.split(r"\s{2,}|\t", head.strip()))
    if len(words(rule)) == width:
        return Found(_under_rule(head, rule), BLANKS)
    if len(apart) + 1 == width and _over_all_but_the_first(head, rows):
        return Found(("", *apart), PANDAS)
    if len(above) > 1 and (both := _with_index_name(above[-2], head, rows)):
        return Found(both, PANDAS)
    ends = _ends(rows)
    groups = _over_groups(own, head, rows, ends) if ends else ()
    if len(own) == width:
        # Names of two words, over errors and rates, may be as many words as there are columns.
        one_each = not groups or (ends is not None and bool(_in_regions(head, ends)))
        if one_each and not (ends and _centred(head, rows, ends)):
            return Found(tuple(word.strip('"') for word in own), BLANKS)
        return Found(groups, DEALII)
    if len(apart) == width:
        return Found(apart, BLANKS)
    if ends and (names := _in_regions(head, ends)):
        return Found(names, BLANKS if names[0] else PANDAS)
    return Found(groups or own, DEALII if groups else BLANKS)


def _under_rule(head: str, rule: str) -> tuple[str, ...]:
    """The text of the head above each piece of the rule."""
    starts = [match.start() for match in re.finditer(r"\S+", rule)]
    ends = [*starts[1:], max(len(head), len(rule))]
    return tuple(head[start:end].strip() for start, end in zip([0, *starts[1:]], ends, strict=True))


def _over_all_but_the_first(head: str, rows: Sequence[str]) -> bool:
    """Whether names, which two blanks part, stand over all columns but the first."""
    found = [list(WORD.finditer(row)) for row in rows]
    names = list(re.finditer(r"\S+(?: \S+)*", head))
    if len({len(row) for row in found}) != 1 or len(names) + 1 != len(found[0]):
        return False
    columns = list(zip(*found, strict=True))
    over = (
        name.end() > min(word.start() for word in column)
        and name.start() < max(word.end() for word in column)
        for name, column in zip(names, columns[1:], strict=True)
    )
    return names[0].start() >= max(word.end() for word in columns[0]) and all(over)


def _ends(rows: Sequence[str]) -> list[int] | None:
    """Where the words of each column end, if all rows have the same number of them and each column
    but the first is flush right."""
    found = [[match.end() for match in WORD.finditer(row)] for row in rows]
    if len({len(ends) for ends in found}) != 1:
        return None
    columns = list(zip(*found, strict=True))
    if any(len(set(ends)) > 1 for ends in columns[1:]):
        return None
    return [max(ends) for ends in columns]


def _in_regions(head: str, ends: Sequence[int]) -> tuple[str, ...]:
    """The text of the head above each column, "" above the first if it is blank; () if a word lies
    above two columns or another column has none."""
    names = [""] * len(ends)
    for match in WORD.finditer(head):
        column = sum(end < match.end() for end in ends)
        if column == len(ends) or (column and match.start() < ends[column - 1]):
            return ()
        names[column] = f"{names[column]} {match[0]}".strip()
    return tuple(names) if all(names[1:]) else ()


def _over_groups(
    own: Sequence[str], head: str, rows: Sequence[str], ends: Sequence[int]
) -> tuple[str, ...]:
    """Names over errors with their rates, which begin with "-"; () if they do not fit."""
    rate = _rates(rows)
    groups = _group_ends(rate, ends)
    names = tuple(own) if len(own) == len(groups) else _in_regions(head, groups)
    if not any(rate) or not names or not all(names):
        return ()
    found, group = [], -1
    for is_rate in rate:
        group += not is_rate
        found.append(f"{names[group]} (rate)" if is_rate else names[group])
    return tuple(found)


def _rates(rows: Sequence[str]) -> list[bool]:
    """Which columns begin with "-": rates, of which the first mesh has none."""
    return [i > 0 and cell == "-" for i, cell in enumerate(words(rows[0]))]


def _group_ends(rate: Sequence[bool], ends: Sequence[int]) -> list[int]:
    """Where each column and the rates behind it end."""
    closes = [not follows for follows in (*rate[1:], False)]
    return [end for end, last in zip(ends, closes, strict=True) if last]


def _centred(head: str, rows: Sequence[str], ends: Sequence[int]) -> bool:
    """Whether a name stands in the middle of each column with its rates, as deal.II puts it."""
    rate = _rates(rows)
    start = 0
    for end in _group_ends(rate, ends):
        name = head[start:end].strip()
        if not name or head[start:end].rstrip() != " " * ((end - start - len(name)) // 2) + name:
            return False
        start = end + 1
    return any(rate)


def _with_index_name(columns: str, index: str, rows: Sequence[str]) -> tuple[str, ...]:
    """Names of pandas in two lines: those of the columns, which end where the rows do, above that
    of the index, which stands over the first column alone."""
    found = [list(WORD.finditer(row)) for row in rows]
    width = len(found[0])
    if width < 2 or any(len(row) != width for row in found):
        return ()
    second = min(row[1].start() for row in found)
    flush = len(columns.rstrip()) == max(len(row.rstrip()) for row in rows)
    if not flush or columns[:1].strip() or index[:1].isspace() or len(index.rstrip()) >= second:
        return ()
    for names in (words(columns), tuple(re.split(r"\s{2,}", columns.strip()))):
        if len(names) + 1 == width:
            return (index.strip(), *names)
    return ()
