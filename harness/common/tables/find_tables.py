"""Which tables a text holds, in whatever dialect."""

import re

from esfem.common.bad_input import BadInput
from esfem.common.tables.blank_table import words
from esfem.common.tables.ruled_table import ruled_tables
from esfem.common.tables.separated_table import Line, has_numbers, separated_table
from esfem.common.tables.tex_table import has_tex, tex_tables
from esfem.common.tables.text_table import TextTable
from esfem.common.tables.trixi_table import trixi_table

JULIA = re.compile(r"\s*Row │ ")  # a DataFrame of Julia has one bar, behind the numbers of rows
FENCE = re.compile(r"\s*(?:```|~~~|@(?:end)?code\b|</?(?:code|pre)>).*")  # around a table in a page


def table_in(text: str, which: int | None = None) -> TextTable:
    """The one table in a text, or the one of that number, counted from 1.

    Raises
    ------
    BadInput
        If there is none, or several and none is chosen.
    """
    tables = tables_in(text)
    if which is None and len(tables) > 1:
        shown = "; ".join(f"{i + 1}: {', '.join(t.names)}" for i, t in enumerate(tables))
        raise BadInput(f"holds {len(tables)} tables ({shown}): choose with --table NUMBER")
    if which is not None and not 1 <= which <= len(tables):
        raise BadInput(f"--table {which}: must be 1 to {len(tables)}")
    return tables[(which or 1) - 1]


def tables_in(text: str) -> list[TextTable]:
    """The tables of a text: LaTeX, Trixi's, those with |, or else the text as one table.

    Raises
    ------
    BadInput
        If there is none, naming the line where it fails to be one.
    """
    lines = [(i + 1, line.rstrip(" ")) for i, line in enumerate(re.split(r"\r\n|\r|\n", text))]
    lines = [line for line in lines if not FENCE.fullmatch(line[1])]
    if not text.strip():
        raise BadInput("is empty: there is no table")
    if has_tex(text):
        return tex_tables(text)
    if (trixi := trixi_table(lines)) is not None:
        return [trixi]
    if any(JULIA.match(line) for _, line in lines):
        return [separated_table(_without_bars(lines))]
    if ruled := ruled_tables(lines):
        return ruled
    return _plain_tables(lines)


def _plain_tables(lines: list[Line]) -> list[TextTable]:
    """The text as one table; or its blocks between empty lines, if some are tables with names, and
    all others hold no row of numbers, as in what a program prints of its run."""
    blocks: list[list[Line]] = [[]]
    broken = any(line.endswith("\\") for _, line in lines)  # by pandas, into blocks of one table
    for line in lines:
        if line[1].strip() or broken:
            blocks[-1].append(line)
        elif blocks[-1]:
            blocks.append([])
    found = [_table_or_text(block) for block in blocks if block]
    tables = [table for table in found if isinstance(table, TextTable)]
    apart = bool(tables) and "rows" not in found
    if apart and len(tables) > 1:
        return tables
    try:
        return [separated_table([line for line in lines if line[1].strip()])]
    except BadInput:
        if apart:
            return tables
        raise


def _table_or_text(block: list[Line]) -> TextTable | str:
    """The table in a block; "text" if it has no row of numbers, "rows" if it has, and is none."""
    if not any(has_numbers(words(line)) for _, line in block):
        rows = [line for _, line in block if any(mark in line for mark in ",;\t")]
        if not any(has_numbers(re.split("[,;\t]", line)) for line in rows):
            return "text"
    try:
        table = separated_table(block)
    except BadInput:
        return "rows"
    return table if table.named and len(table.rows) > 1 else "rows"


def _without_bars(lines: list[Line]) -> list[Line]:
    """The lines of a DataFrame of Julia from its names on, without rule and bars."""
    return [(number, line.replace("│", " ").rstrip()) for number, line in lines if "│" in line]
