r"""Cells of tables as numbers: decimal commas, exponents of Fortran, powers, fractions, LaTeX."""

import re
from collections.abc import Callable, Iterable
from math import pi
from typing import Literal

DecimalMark = Literal["point", "comma"]

MISSING = {
    *("", "-", "--", "---", "–", "—", "−", "nan", "na", "n/a", "#n/a", "<na>", "nat", "none"),  # noqa: RUF001
    *("null", "nil", "missing", "undef", ".", "..", "...", "…", "(nan)", "1.#qnan", "1.#ind"),
    *("-1.#ind", "-nan", "nan(ind)", "-nan(ind)", "nan.0", "missingvalue", "/"),
    *("#nv", "#div/0!", "#num!", "#zahl!", "#value!", "#wert!"),
}
INFINITE = {"inf": 1.0, "infinity": 1.0, "1.#inf": 1.0, "∞": 1.0, "\\infty": 1.0}
MINUS = str.maketrans({"−": "-", "–": "-", "‐": "-", "‑": "-"})  # noqa: RUF001
BLANKS = "\u00a0\u2007\u2009\u202f"  # which do not break, or are thin
RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")

DIGITS = r"[+-]?(?:\d+\.?\d*|\.\d+)"
EXPONENT = r"(?:[eEdDqQ][+-]?\d+)?"
THOUSANDS: dict[DecimalMark, re.Pattern[str]] = {
    "point": re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:,\d{{3}})+(?:\.\d*{EXPONENT})?"),
    "comma": re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:\.\d{{3}})+(?:,\d*{EXPONENT})?"),
}
COMMAED = re.compile(rf"[+-]?(?:\d+,\d*|,\d+){EXPONENT}")  # a decimal comma is possible
POINTED = re.compile(rf"[+-]?(?:\d+\.\d*|\.\d+){EXPONENT}")  # a decimal point is possible
STRONG = re.compile(r"\*{1,2}([^*]+)\*{1,2}")  # of Markdown
SPACED = re.compile(r"(?<=\d)[ '](?=\d{3}(?!\d))")  # between thousands


class NotANumber(ValueError):
    """A cell that is neither a number nor a sign of a missing one."""


def number(cell: str, mark: DecimalMark = "point") -> float:
    """The value of a cell; NaN if it is missing (nothing, "-", "---", NaN, n/a).

    Raises
    ------
    NotANumber
        If it is anything else.
    """
    value = parsed(cell, mark)
    if value is None:
        raise NotANumber(cell)
    return value


def parsed(cell: str, mark: DecimalMark = "point") -> float | None:
    """The value of a cell, NaN if it is missing, None if it is no number."""
    text = plain(cell)
    if text.lower() in MISSING:
        return float("nan")
    sign, rest = (-1.0, text[1:]) if text[:1] == "-" else (1.0, text.removeprefix("+"))
    if rest.lower() in INFINITE:
        return sign * float("inf")
    text = _points(text, mark)
    for form, value in FORMS:
        if found := form.fullmatch(text):
            return value(found)
    return None


def plain(cell: str) -> str:
    """The cell without what only makes it look well: LaTeX, bold, quotes, thin blanks."""
    text = STRONG.sub(r"\1", cell.strip().strip('"`')).strip().translate(MINUS)
    for blank in BLANKS:
        text = text.replace(blank, " ")
    text = re.sub(r"[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda m: "^" + m[0].translate(RAISED), text)
    if re.search(r"[\\${]", text):
        text = _without_tex(text)
    text = re.sub(r"\s*([x×*·^])\s*", r"\1", text)  # noqa: RUF001
    return SPACED.sub("", text)


def _without_tex(text: str) -> str:
    text = re.sub(r"\\[dt]?frac\s*\{?(\d+)\}?\s*\{?(\d+)\}?", r"\1/\2", text)
    text = re.sub(r"\\(?:times|cdot)(?![A-Za-z])", "x", text).replace("\\infty", "∞")
    text = re.sub(r"\\pi(?![A-Za-z])", "pi", text)
    text = re.sub(r"\\(?:[A-Za-z]+|[,;!: ])\s*", "", text)
    return text.replace("\\%", "%").translate(str.maketrans("", "", "${}~")).strip()


def _points(text: str, mark: DecimalMark) -> str:
    """The text with a decimal point, and without marks of thousands."""
    if THOUSANDS[mark].fullmatch(text):
        text = text.replace("," if mark == "point" else ".", "")
    elif mark == "comma":
        text = text.replace(".", "?")  # neither thousands nor a decimal mark: no number
    return text.replace(",", ".") if mark == "comma" else text


def _fraction(found: re.Match[str]) -> float | None:
    above, below = parsed(found[1]), parsed(found[2])
    return above / below if above is not None and below else None


def _of_pi(found: re.Match[str]) -> float:
    return float(found[1] or 1) * pi / float(found[2] or 1)


def _percent(found: re.Match[str]) -> float | None:
    value = parsed(found[1])
    return None if value is None else value / 100


# Digits with an exponent of E or of Fortran (D, Q, three digits alone), powers, fractions.
FORMS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], float | None]], ...] = (
    (re.compile(DIGITS + EXPONENT), lambda m: float(re.sub("[dDqQ]", "e", m[0]))),
    (re.compile(rf"({DIGITS})([+-]\d{{3}})"), lambda m: float(f"{m[1]}e{m[2]}")),
    (re.compile(rf"({DIGITS})[x×*·]10(?:\^|\*\*)([+-]?\d+)"), lambda m: float(f"{m[1]}e{m[2]}")),  # noqa: RUF001
    (re.compile(rf"({DIGITS})\*\^([+-]?\d+)"), lambda m: float(f"{m[1]}e{m[2]}")),
    (re.compile(r"(10)(?:\^|\*\*)([+-]?\d+)"), lambda m: float(f"1e{m[2]}")),
    (re.compile(r"([2-9])(?:\^|\*\*)([+-]?\d{1,2})"), lambda m: float(m[1]) ** int(m[2])),
    (re.compile(r"(\d*\.?\d*)\*?(?:pi|π)(?:/(\d+))?"), _of_pi),
    (re.compile(r"(\d+)(?:[x×*]\1)+"), lambda m: float(m[1])),  # cells in each direction  # noqa: RUF001
    (re.compile(r"([^/]+)/([^/]+)"), _fraction),
    (re.compile(r"(.+)%"), _percent),
)


def decimal_mark(cells: Iterable[str]) -> DecimalMark | None:
    """Whether the numbers of these cells have decimal points or commas; None if both are possible,
    as in 1,024 beside 4,096."""
    texts = [plain(cell) for cell in cells]
    marks: tuple[DecimalMark, ...] = ("comma", "point")
    for mark in marks:
        if any("," in t and "." in t and THOUSANDS[mark].fullmatch(t) for t in texts):
            return mark
    commaed = [text for text in texts if COMMAED.fullmatch(text)]
    as_thousands = [t for t in texts if THOUSANDS["point"].fullmatch(t)]
    if not commaed:
        return "point"
    if not set(commaed) <= set(as_thousands):
        return "comma"
    return "point" if any(POINTED.fullmatch(text) for text in texts) else None
