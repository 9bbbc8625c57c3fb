"""TOML files that a model describes: read, checked, and each finding told in one line."""

import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from harness.bad_input import BadInput

Model = TypeVar("Model", bound=BaseModel)


def load(path: Path, model: type[Model]) -> Model:
    """Read a file and check it.

    Raises
    ------
    BadInput
        Naming the file, the key, the value and what is allowed.
    """
    table = read(path)
    try:
        return model.model_validate(table)
    except ValidationError as error:
        found = (f"{path}: {_explain(e, model)}" for e in error.errors())
        raise BadInput("; ".join(found)) from error


def read(path: Path) -> dict[str, Any]:
    """The tables of a file; BadInput if there are none."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        why = f"{error.reason} at byte {error.start}"
        raise BadInput(f"{path}: is not UTF-8 text: {why}") from error
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"{path}: is not valid TOML: {error}") from error


def _explain(error: dict[str, Any], model: type[BaseModel]) -> str:
    """One line for one finding of pydantic: key, value, bound."""
    where = error["loc"]
    section = f"[{where[0]}]" if where else ""
    key = "".join(f"[{part}]" if isinstance(part, int) else part for part in where[1:])
    place = f"{section} {key}".strip()
    match error["type"]:
        case "model_type":
            return f"{section}: must be a table of keys and values"
        case "extra_forbidden":
            allowed = ", ".join(_keys(model, where[:-1]))
            return f"{place}: unknown key; must be one of {allowed}"
        case "missing":
            return f"{place}: is missing"
        case "value_error":
            return f"{section} {error['ctx']['error']}".strip()
        case _:
            return f"{place} = {error['input']!r}: {error['msg'][0].lower()}{error['msg'][1:]}"


def _keys(model: type[BaseModel], where: tuple[int | str, ...]) -> list[str]:
    """The keys that the table at that place takes."""
    for part in where:
        model = model.model_fields[part].annotation
    return list(model.model_fields)
