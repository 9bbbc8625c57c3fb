"""Files that a user writes: TOML tables, checked by models, each finding told in one line."""

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError

from esfem.common.bad_input import BadInput
from esfem.common.files import reading

RESERVED = ("meshes", "flows")  # folders beside those of the studies


class Fixed(BaseModel):
    """Values that do not change, and cached properties of them.

    A changed copy, or one in another process, derives these anew: pydantic would copy them too.
    """

    model_config = ConfigDict(frozen=True)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy with other values, without what was derived from the old ones."""
        copied = super().model_copy(update=update, deep=deep)
        for name in vars(copied).keys() - type(self).model_fields.keys():
            del vars(copied)[name]
        return copied

    def __getstate__(self) -> dict[Any, Any]:
        state = super().__getstate__()
        values = {name: state["__dict__"][name] for name in type(self).model_fields}
        return {**state, "__dict__": values}


class Section(Fixed):
    """A table of a file: unknown keys are errors, values are fixed, types are not bent."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


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


# Of studies and flows: they name folders and files, and stand in titles.
FolderName = Annotated[str, AfterValidator(_folder_name)]
Title = Annotated[str, AfterValidator(_printable)]


@contextmanager
def checking(path: Path, model: type[BaseModel]) -> Iterator[None]:
    """BadInput for what the model does not allow of a file, whose tables it checks in the block: a
    line a finding, with the file, the key, the value and what is allowed."""
    try:
        yield
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
