"""Names of flows: they name folders and files, and stand in titles."""

import re

from pydantic import AfterValidator


def _folder_name(name: str) -> str:
    if not re.fullmatch(r"[a-z0-9][a-z0-9-]{0,99}", name):
        raise ValueError(f"{name!r}: must consist of a-z, 0-9 and -, for it names a folder")
    return name


def _printable(title: str) -> str:
    if not title.isprintable():
        raise ValueError(f"{title!r}: must be printable characters on one line")
    return title


folder_name = AfterValidator(_folder_name)
printable = AfterValidator(_printable)
