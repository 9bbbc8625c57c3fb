"""TOML files that a model describes: read, checked, and each finding told in one line."""

import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from harness.bad_input import BadInput
from harness.explain import explain
from harness.files import reading

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
    with reading(path):
        text = Path(path).read_text(encoding="utf-8")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"{path}: is not valid TOML: {error}") from error


def _explain(error: dict[str, Any], model: type[BaseModel]) -> str:
    """One line for one finding of pydantic, with the section it is in."""
    where = error["loc"]
    if error["type"] == "model_type":
        return f"[{where[0]}]: must be a table of keys and values"
    names = _keys(model, where[:-1]) if error["type"] == "extra_forbidden" else ()
    return explain({**error, "loc": where[1:]}, names, f"[{where[0]}] " if where else "")


def _keys(model: type[BaseModel], where: tuple[int | str, ...]) -> list[str]:
    """The keys that the table at that place takes."""
    for part in where:
        model = model.model_fields[part].annotation
    return list(model.model_fields)
