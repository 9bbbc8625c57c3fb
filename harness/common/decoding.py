"""Bytes of a text file as text: UTF-8, or UTF-16 and UTF-32 by their marks or their zeros."""

import codecs

from esfem.common.bad_input import BadInput

MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


def decoded(content: bytes, encoding: str | None = None) -> str:
    """The text of these bytes.

    Raises
    ------
    BadInput
        If they are no text in the encoding that was given or found, naming line and byte.
    """
    name = encoding or _encoding(content)
    try:
        text = content.decode(name)
    except LookupError:
        raise BadInput(f"--encoding {name}: is unknown; such as latin-1, cp1252, utf-16") from None
    except UnicodeError as error:
        raise BadInput(f"cannot be read: {_finding(content, name, error)}") from error
    if "\0" in text:
        raise BadInput("cannot be read: is no text: it holds bytes of zero")
    return text


def _encoding(content: bytes) -> str:
    for mark, name in MARKS:
        if content.startswith(mark):
            return name
    # Text of few letters beyond ASCII has a zero in every second byte of UTF-16.
    if len(content) >= 4 and b"\0" in content:
        even, odd = content[::2].count(0), content[1::2].count(0)
        if max(even, odd) > 0.9 * (len(content) // 2) and min(even, odd) == 0:
            return "utf-16-be" if even > odd else "utf-16-le"
    return "utf-8"


def _finding(content: bytes, name: str, error: UnicodeError) -> str:
    if not isinstance(error, UnicodeDecodeError):
        return f"is not {name.upper()} text: {error}"
    line = content[: error.start].count(b"\n") + 1
    byte = content[error.start]
    return (
        f"is not {name.upper()} text: byte 0x{byte:02x} in line {line}; say what it is, "
        "such as --encoding cp1252 or latin-1"
    )
