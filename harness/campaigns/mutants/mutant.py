"""The seeded bugs of `mutants.toml`, and how one is put in.

A mutant is an edit of the source of a function, compiled and put in its place at run time.

The function object stays and only its code is exchanged, so that the mutant acts wherever the
function was imported to by name.  Nothing is written to disk.
"""

import ast
import inspect
import textwrap
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

from esfem.solver.pointwise import interpreted
from esfem.solver.reference_element import reference_element


@dataclass(frozen=True)
class Edit:
    """In the source of ``where`` ("module:function" or "module:Class.method"), ``old`` -> ``new``.

    ``old`` must occur exactly once.
    """

    where: str
    old: str
    new: str


@dataclass(frozen=True)
class Mutant:
    """A seeded bug.

    Attributes
    ----------
    name, group, what : what is wrong, in a word and in a line.
    edits : of the program.
    equivalent : why the orders and bounds that are claimed hold for it too; "" if they should not.
    """

    name: str
    group: str
    what: str
    edits: tuple[Edit, ...]
    equivalent: str = ""


def _mutant(group: str, entry: dict[str, Any]) -> Mutant:
    """The mutant of one table: its edits, or the only one, which stands in the table itself."""
    rest = {key: value for key, value in entry.items() if key not in ("where", "old", "new")}
    edits = rest.pop("edits", None) or [{key: entry[key] for key in ("where", "old", "new")}]
    return Mutant(group=group, edits=tuple(Edit(**edit) for edit in edits), **rest)


_GROUPS = tomllib.loads(Path(__file__).with_name("mutants.toml").read_text(encoding="utf-8"))
MUTANTS: tuple[Mutant, ...] = tuple(
    _mutant(group, entry) for group, entries in _GROUPS.items() for entry in entries
)


@contextmanager
def applied(mutant: Mutant) -> Iterator[None]:
    """The program with this mutant, until the end of the block.

    Raises
    ------
    ValueError
        If the text of an edit does not occur exactly once in its function: the program has changed.
    """
    sources: dict[str, str] = {}
    for edit in mutant.edits:
        text = sources.get(edit.where) or source(function_at(edit.where))
        if text.count(edit.old) != 1:
            raise ValueError(
                f"mutant {mutant.name}: {edit.old!r} occurs {text.count(edit.old)} times in "
                f"{edit.where}, must occur once"
            )
        sources[edit.where] = text.replace(edit.old, edit.new)
    mutated = {where: compiled(function_at(where), text) for where, text in sources.items()}
    original = {where: function_at(where).__code__ for where in mutated}
    try:
        _exchange(mutated)
        with interpreted():  # compiled formulas would be those of the program as it was
            yield
    finally:
        _exchange(original)


def function_at(where: str) -> FunctionType:
    """The function at "module:name", without what decorates it."""
    module, _, path = where.partition(":")
    found: Any = import_module(module)
    for name in path.split("."):
        found = inspect.getattr_static(found, name)
    if isinstance(found, property):
        found = found.fget
    function: FunctionType = inspect.unwrap(getattr(found, "func", found))
    return function


def source(function: FunctionType) -> str:
    """The source of a function, as if it stood at the left margin."""
    return textwrap.dedent(inspect.getsource(function))


def compiled(function: FunctionType, text: str) -> CodeType:
    """The code of the ``text`` of a function, to be run among the globals of the original."""
    tree = ast.parse(text)
    for definition in tree.body:
        if isinstance(definition, ast.FunctionDef):
            definition.decorator_list = []
    names = dict(function.__globals__)
    exec(compile(tree, f"<mutant of {function.__qualname__}>", "exec"), names)
    edited: FunctionType = names[function.__name__]
    return edited.__code__


def _exchange(codes: dict[str, CodeType]) -> None:
    for where, code in codes.items():
        function_at(where).__code__ = code
    reference_element.cache_clear()  # made by the code that was there before
