"""Records on disk: a file a run, written atomically, named by content hash, checked on reading."""

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from harness.bad_input import BadInput
from harness.case import Case
from harness.provenance import numerics_digest
from harness.runner import Record, as_json


def key(case: Case, mesh_digest: str) -> str:
    """Content hash of case, mesh and the numerics of this program: 16 hexadecimal digits."""
    return _digest(
        {"case": case.model_dump(mode="json"), "mesh": mesh_digest, "numerics": numerics_digest()}
    )[:16]


def record_path(folder: Path, record_key: str) -> Path:
    """Where the record of that key lies in the folder of a study."""
    return folder / "records" / f"{record_key}.json"


def write_record(folder: Path, record_key: str, record: Record) -> None:
    """Store a record; a reader sees it whole or not at all."""
    content = as_json(record)
    write_text(
        record_path(folder, record_key),
        json.dumps({"digest": _digest(content), "record": content}, indent=1),
    )


def read_record(folder: Path, record_key: str, complain: Callable[[str], None]) -> Record | None:
    """The stored record, or None if there is none.

    A file that is truncated or was edited by hand is reported through ``complain``, set aside as
    ``*.damaged`` and counts as absent.
    """
    path = record_path(folder, record_key)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["digest"] != _digest(content["record"]):
            raise ValueError("its content does not match its digest")
        return Record(**content["record"])
    except FileNotFoundError:
        return None
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        aside = path.with_suffix(".json.damaged")
        os.replace(path, aside)
        complain(
            f"{path}: damaged record ({error}); set aside as {aside.name}, will be computed again"
        )
        return None


def write_text(path: Path, text: str) -> None:
    """Write a whole file atomically: to a temporary neighbour, to the disk, then into place."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with open(temporary, "w", encoding="utf-8") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def writable_folder(folder: Path, *parts: str) -> Path:
    """Make the folder, with these folders in it, if need be.

    Raises
    ------
    BadInput
        If nothing can be written there.
    """
    for place in (folder, *(folder / name for name in parts)):
        probe = place / f".probe.{os.getpid()}"
        try:
            place.mkdir(parents=True, exist_ok=True)
            probe.touch()
            probe.unlink()
        except OSError as error:
            raise BadInput(f"--out {place}: cannot be written: {error.strerror}") from error
    return folder


def _digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
