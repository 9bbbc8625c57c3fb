"""Tables as Trixi.jl's `convergence_test` prints them: a block a norm, pairs of error and EOC.

Each run has twice as many cells in each direction as the one above it; h is not printed.
"""

import re
from collections.abc import Sequence

from esfem.common.bad_input import BadInput
from esfem.common.tables.text_table import Row, TextTable, regular

PAIRS = re.compile(r"\s*(?:error\s+EOC\s*)+")

Line = tuple[int, str]


def trixi_table(lines: Sequence[Line]) -> TextTable | None:
    """One table of all blocks side by side, an error and an EOC a norm and variable; None if there
    are none."""
    heads = [i for i, (_, line) in enumerate(lines) if PAIRS.fullmatch(line)]
    names: list[str] = []
    rows: dict[int, tuple[int, list[str]]] = {}
    for head in heads:
        own = _names(lines, head)
        names += [f"{name}{part}" for name in own for part in ("", " EOC")]
        for i, (number, line) in enumerate(_rows(lines, head)):
            rows.setdefault(i, (number, []))[1].extend(line.split())
    if not heads:
        return None
    found = [Row(number, tuple(cells)) for number, cells in rows.values()]
    table = regular(names, found, "Trixi's convergence_test")
    return TextTable(table.names, table.rows, table.dialect, halves=True)


def _names(lines: Sequence[Line], head: int) -> list[str]:
    """The norm, and a variable for each pair, from the two lines above."""
    above = [line.strip() for _, line in lines[:head] if line.strip()][-2:]
    pairs = len(lines[head][1].split()) // 2
    variables = above[-1].split() if above else []
    if len(variables) != pairs and len(above[-1:]) and len(re.split(r"\s{2,}", above[-1])) == pairs:
        variables = re.split(r"\s{2,}", above[-1])
    if len(variables) != pairs:
        variables = [str(i + 1) for i in range(pairs)]
    norm = above[0] if len(above) > 1 and len(above[0].split()) == 1 else "error"
    return [f"{norm} {variable}" for variable in variables]


def _rows(lines: Sequence[Line], head: int) -> list[Line]:
    """The rows of a block, to their means.

    Raises
    ------
    BadInput
        Naming the first line that has not a pair for each of the names.
    """
    width = len(lines[head][1].split())
    found: list[Line] = []
    for number, line in lines[head + 1 :]:
        if line.lstrip().startswith(("mean", "-----", "#####", "```")):
            break
        if not line.strip():
            continue
        if len(line.split()) != width:
            raise BadInput(
                f"line {number}: has {len(line.split())} fields, and there are {width} names in "
                f"line {lines[head][0]}"
            )
        found.append((number, line))
    return found
