"""Which tables a text holds, in whatever dialect."""

import re

from esfem.common.bad_input import BadInput
from esfem.common.tables.ruled_table import ruled_tables
from esfem.common.tables.separated_table import separated_table
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
    return [separated_table([line for line in lines if line[1].strip()])]


def _without_bars(lines: list[tuple[int, str]]) -> list[tuple[int, str]]:
    """The lines of a DataFrame of Julia from its names on, without rule and bars."""
    return [(number, line.replace("│", " ").rstrip()) for number, line in lines if "│" in line]
