"""Names of studies and flows: they name folders and files, and stand in titles."""

import re
from typing import Annotated

from pydantic import AfterValidator

RESERVED = ("meshes", "flows")  # folders beside those of the studies


def _folder_name(name: str) -> str:
    if not re.fullmatch(r"[a-z0-9][a-z0-9-]*", name):
        raise ValueError(f"name = {name!r}: must consist of a-z, 0-9 and -, for it names a folder")
    if name in RESERVED or len(name) > 100:
        raise ValueError(
            f"name = {name!r}: must not be {' or '.join(RESERVED)}, nor longer than 100 letters"
        )
    return name


def _printable(title: str) -> str:
    if not title.isprintable():
        raise ValueError(f"title = {title!r}: must be printable characters on one line")
    return title


FolderName = Annotated[str, AfterValidator(_folder_name)]
Title = Annotated[str, AfterValidator(_printable)]
