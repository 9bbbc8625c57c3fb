"""Smooth closed surfaces by name: each file here is one, and is found by itself.

The file ``my_surface.py`` defines ``SURFACE``, a `LevelSet` or a `Parametrised`; README tells how.
Nothing is imported before a surface is asked for.
"""

import ast
import hashlib
from functools import cache
from importlib import import_module
from inspect import getfile
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from esfem.reference_solutions.calculus import Surface


def surface_names() -> tuple[str, ...]:
    """The names of all surfaces, sorted."""
    return tuple(sorted(module.name for module in iter_modules(__path__)))


def surface_title(name: str) -> str:
    """The first line of the file of a surface, read without loading it."""
    path = Path(__file__).with_name(f"{name}.py")
    docstring = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return docstring.partition("\n")[0]


@cache
def named_surface(name: str) -> "Surface":
    """The surface of that name.

    Raises
    ------
    ValueError
        If there is none, or its file defines no ``SURFACE``.
    """
    if name not in surface_names():
        raise ValueError(f"surface = {name!r}: must be one of {', '.join(surface_names())}")
    from esfem.reference_solutions.calculus import LevelSet, Parametrised

    surface = getattr(import_module(f"{__name__}.{name}"), "SURFACE", None)
    if not isinstance(surface, LevelSet | Parametrised):
        raise ValueError(f"surface {name!r}: its file must define SURFACE, a level set or a map")
    return surface


def surfaces() -> "dict[str, Surface]":
    """All surfaces by name."""
    return {name: named_surface(name) for name in surface_names()}


def surface_digest(name: str) -> str:
    """Hash of the file of a surface; docstrings, comments and layout do not count.

    Raises
    ------
    ValueError
        If there is no such surface.
    """
    named_surface(name)
    path = Path(getfile(import_module(f"{__name__}.{name}")))
    tree = ast.parse(path.read_text(encoding="utf-8"))
    tree.body = tree.body[ast.get_docstring(tree) is not None :]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()[:16]
