"""Files, read and written: what goes wrong is one line for the user, and a file is whole.

A reader sees the old file or the new one, whatever happens to the writer.
"""

import glob
import json
import os
import platform
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError
from pydantic_core import to_json

from esfem.common.bad_input import BadInput

Kind = TypeVar("Kind")


@contextmanager
def reading(path: Path | str, remedy: str = "") -> Iterator[None]:
    """BadInput with file, reason and ``remedy`` for what cannot be read or decoded in the block."""
    try:
        yield
    except BadInput:
        raise
    except (OSError, ValueError, RecursionError) as error:
        raise BadInput(f"{path}: cannot be read: {reason(error)}{_also(remedy)}") from error


@contextmanager
def writing(place: Path | str) -> Iterator[None]:
    """BadInput with place and reason for what cannot be written in the block."""
    try:
        yield
    except OSError as error:
        raise BadInput(f"{place}: cannot be written: {reason(error)}") from error


def reason(error: BaseException) -> str:
    """Why a file could not be read or written, in one line."""
    if isinstance(error, UnicodeDecodeError):
        return f"is not UTF-8 text: {error.reason} at byte {error.start}"
    return " ".join(str(getattr(error, "strerror", None) or error).split())


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Where to write in the block what is to be the file, which is put into place at its end.

    It is a neighbour, on the disk before it takes the place; nothing is left of one that failed.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    owner = f"{platform.node()}-{os.getpid()}-{threading.get_ident()}"
    temporary = path.with_name(f".{path.name}.writing-{owner}")
    try:
        yield temporary
        with open(temporary, "r+b") as stream:
            os.fsync(stream.fileno())
        os.replace(temporary, path)
    finally:
        with suppress(OSError):
            temporary.unlink()


def write_bytes(path: Path, content: bytes) -> None:
    """Write a whole file."""
    with whole(path) as temporary:
        temporary.write_bytes(content)


def write_text(path: Path, text: str) -> None:
    """Write a whole file, in UTF-8."""
    write_bytes(path, text.encode("utf-8"))


def plain(content: Any) -> Any:
    """Dataclasses, models and numbers as what JSON knows: a number that is not finite is null."""
    return json.loads(to_json(content, inf_nan_mode="null"))


def write_json(path: Path, content: Any) -> None:
    """Write a whole file of JSON, `plain`."""
    write_text(path, json.dumps(plain(content), indent=1) + "\n")


def read_json(
    path: Path, kind: type[Kind], remedy: str = "", context: dict[str, str] | None = None
) -> Kind:
    """What a file of JSON holds, as that type.

    Raises
    ------
    BadInput
        Naming the file, the key, its value, what is allowed, and the remedy.
    """
    with reading(path, remedy):
        text = path.read_bytes().decode("utf-8")
        try:
            return TypeAdapter(kind).validate_json(text, context=context)
        except ValidationError as error:
            raise BadInput(f"{path}: {_finding(error)}{_also(remedy)}") from error


def _finding(error: ValidationError) -> str:
    """The first finding of pydantic in one line."""
    first = error.errors()[0]
    key, message = ".".join(map(str, first["loc"])), " ".join(first["msg"].split())
    match first["type"]:
        case "json_invalid":
            return f"cannot be read: {message}"
        case "missing":
            return f"{key}: is missing"
        case "value_error":
            return ": ".join(part for part in (key, str(first["ctx"]["error"])) if part)
    value = repr(first["input"])
    value = value if len(value) <= LONGEST else f"{value[:LONGEST]}..."
    return f"{key} = {value}: {message}" if key else f"cannot be read: {message}"


LONGEST = 60  # letters of a value that is shown


def _also(remedy: str) -> str:
    return f"; {remedy}" if remedy else ""


def writable_folder(folder: Path, *parts: str) -> Path:
    """Make the folder, with these folders in it, if need be.

    Raises
    ------
    BadInput
        If nothing can be written there.
    """
    for place in (folder, *(folder / name for name in parts)):
        probe = place / f".probe.{os.getpid()}"
        with writing(f"--out {place}"):
            place.mkdir(parents=True, exist_ok=True)
            probe.touch()
            probe.unlink()
    return folder


def remove(path: Path) -> None:
    """Remove the file, if it is there and can be, and what killed writers left of theirs."""
    for file in (path, *path.parent.glob(f".{glob.escape(path.name)}.writing-*")):
        with suppress(OSError):
            file.unlink(missing_ok=True)
