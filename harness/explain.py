"""Findings of pydantic in one line each: the key, its value, and what is allowed."""

from collections.abc import Iterable
from typing import Any


def explain(error: dict[str, Any], names: Iterable[str], section: str = "") -> str:
    """One line for one finding.

    Parameters
    ----------
    error : of ``ValidationError.errors()``, ``loc`` counted from the section.
    names : the keys that the section takes.
    section : "[section] " or "".
    """
    where = error["loc"]
    key = "".join(f"[{part}]" if isinstance(part, int) else part for part in where)
    match error["type"]:
        case "extra_forbidden":
            line = f"{section}{key}: unknown key; must be one of {', '.join(names)}"
        case "missing":
            line = f"{section}{key}: is missing"
        case "value_error":
            return f"{section}{error['ctx']['error']}"
        case _:
            message = error["msg"][0].lower() + error["msg"][1:]
            return f"{section}{key} = {error['input']!r}: {message}"
    return line.replace(" :", ":")
