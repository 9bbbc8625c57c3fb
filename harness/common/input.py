"""Files that a user writes: TOML tables, checked by models, each finding told in one line."""

import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

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
        found = (f"{path}: {explain(e, model, in_section=True)}" for e in error.errors())
        raise BadInput("; ".join(found)) from error


def read(path: Path) -> dict[str, Any]:
    """The tables of a file; BadInput if there are none."""
    with reading(path):
        text = Path(path).read_text(encoding="utf-8")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"{path}: is not valid TOML: {error}") from error


def explain(error: ErrorDetails, model: type[BaseModel], in_section: bool = False) -> str:
    """One line for one finding of pydantic.

    Parameters
    ----------
    error : of ``ValidationError.errors()``.
    model : what was checked, a table or a file.
    in_section : the file has sections, and the line begins with that of the finding.
    """
    where, section = error["loc"], ""
    if in_section and where:
        section, where = f"[{where[0]}] ", where[1:]
    key = section + "".join(f"[{part}]" if isinstance(part, int) else part for part in where)
    match error["type"]:
        case "model_type" if in_section:
            return f"{key.rstrip()}: must be a table of keys and values"
        case "extra_forbidden":
            names = ", ".join(_keys(model, error["loc"][:-1]))
            return f"{key.rstrip()}: unknown key; must be one of {names}"
        case "missing":
            return f"{key.rstrip()}: is missing"
        case "value_error":
            return f"{section}{error['ctx']['error']}"
    message = error["msg"][0].lower() + error["msg"][1:]
    return f"{key} = {error['input']!r}: {message}"


def _keys(model: type[BaseModel], where: tuple[int | str, ...]) -> list[str]:
    """The keys that the table at that place takes."""
    for part in where:
        table = model.model_fields[str(part)].annotation
        assert isinstance(table, type) and issubclass(table, BaseModel)
        model = table
    return list(model.model_fields)
