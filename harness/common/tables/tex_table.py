r"""Tables of LaTeX: tabular and its kin, array, longtable, with the commands that rule them."""

import re
from collections.abc import Sequence

from esfem.common.bad_input import BadInput
from esfem.common.tables.number_text import parsed
from esfem.common.tables.ruled_table import stacked
from esfem.common.tables.text_table import Row, TextTable, regular

KINDS = r"(?:tabular\*?|tabularx|tabulary|longtable|longtblr|tblr|array|tabu)"
BEGIN = re.compile(rf"\\begin\{{({KINDS})\}}")
COMMENT = re.compile(r"(?<!\\)%.*")
# Commands that draw, colour or space, with what they take.
GROUP = r"\s*\{(?:[^{}]|\{[^{}]*\})*\}"
RULES = re.compile(
    r"\\(?:(?:hline|toprule|midrule|bottomrule|addlinespace|endhead|endfirsthead|endfoot|endlastfoot|"
    r"hdashline|centering|noindent|small|footnotesize)\b(?:\s*\[[^\]]*\])?"
    r"|(?:cmidrule|cline|noalign|rowcolor|cellcolor|caption|label)\b(?:\s*[\[(][^\])]*[\])])*"
    + GROUP
    + r")"
)
BREAK = re.compile(r"(?:\\\\|\\tabularnewline)\*?(?:\[[^\]]*\])?")
AND = re.compile(r"(?<!\\)&")
SPAN = re.compile(r"\\multicolumn\s*\{(\d+)\}\s*\{[^{}]*(?:\{[^{}]*\}[^{}]*)*\}\s*")
MULTIROW = re.compile(r"\\multirow(?:\[[^\]]*\])?\{[^{}]*\}(?:\[[^\]]*\])?\{[^{}]*\}")


def has_tex(text: str) -> bool:
    """Whether a text has a table of LaTeX."""
    return bool(BEGIN.search(text)) or len(re.findall(r"&.*\\\\", text)) > 1


def tex_tables(text: str) -> list[TextTable]:
    """The tables in a text of LaTeX; rows without an environment around them are one, too.

    Raises
    ------
    BadInput
        If an environment does not end, or a table is none.
    """
    text = COMMENT.sub("", text)
    begins = list(BEGIN.finditer(text))
    if not begins:
        return [_table(text, 0)]
    tables = []
    for begin in begins:
        end = text.find(f"\\end{{{begin[1]}}}", begin.end())
        if end < 0:
            line = text.count("\n", 0, begin.start()) + 1
            raise BadInput(f"line {line}: \\begin{{{begin[1]}}} does not end")
        body = _past_arguments(text, begin.end())
        tables.append(_table(text[body:end], text.count("\n", 0, body)))
    return tables


def _past_arguments(text: str, position: int) -> int:
    """Where the rows begin, behind [position], {width} and {columns}."""
    while found := re.compile(r"\s*(?=[\[{])").match(text, position):
        start = found.end()
        depth, end = 0, start
        for end in range(start, len(text)):
            depth += {"{": 1, "[": 1, "}": -1, "]": -1}.get(text[end], 0)
            if depth == 0:
                break
        position = end + 1
    return position


def _table(body: str, lines_before: int) -> TextTable:
    rows, position = [], 0
    for end in [*BREAK.finditer(body), None]:
        part = body[position : end.start() if end else len(body)]
        cells = RULES.sub("", part)
        if cells.strip():
            lead = len(part) - len(part.lstrip())
            line = lines_before + body.count("\n", 0, position + lead) + 1
            rows.append(Row(line, _cells(cells)))
        position = end.end() if end else len(body)
    first = next((i for i, row in enumerate(rows) if _is_data(row)), len(rows))
    names = stacked([row.cells for row in rows[:first]])
    if first < len(rows):
        names = _with_rates(names, rows[first].cells)
    return regular(names, rows[first:], "LaTeX tabular")


def _with_rates(names: Sequence[str], cells: Sequence[str]) -> list[str]:
    """The names, where a repeated one above a column that begins with "-" is that of a rate."""
    if len(names) != len(cells):
        return list(names)
    missing = [value is not None and value != value for value in map(parsed, cells)]
    rate = [i > 0 and names[i] == names[i - 1] and missing[i] for i in range(len(names))]
    return [
        f"{name} (rate)" if is_rate else name for name, is_rate in zip(names, rate, strict=True)
    ]


def _cells(text: str) -> tuple[str, ...]:
    cells: list[str] = []
    for cell in AND.split(text):
        span = SPAN.search(cell)
        shown = MULTIROW.sub("", SPAN.sub("", cell)).strip()
        if span:
            shown = shown.removeprefix("{").removesuffix("}")
        shown = re.sub(r"\\([_#&$])", r"\1", " ".join(shown.split()))
        cells += [shown] * (int(span[1]) if span else 1)
    return tuple(cells)


def _is_data(row: Row) -> bool:
    values = [v if (v := parsed(c)) is not None else parsed(c, "comma") for c in row.cells]
    finite: Sequence[float] = [value for value in values if value is not None and value == value]
    return bool(finite) and not any("\\multicolumn" in cell for cell in row.cells)
