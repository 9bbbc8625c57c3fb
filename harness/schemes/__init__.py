"""Schemes by name: each file here is one, and is found by itself.

The file ``my_scheme.py`` defines ``SCHEME``, a `harness.plugin.Plugin`, and is the scheme
"my-scheme"; README tells how. Nothing is imported before a scheme is asked for.
"""

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from harness.plugin import Plugin

DEFAULT_SCHEME = "kll"


def scheme_names() -> tuple[str, ...]:
    """The names of all schemes, sorted: those of their files, with - for _."""
    return tuple(sorted(module.name.replace("_", "-") for module in iter_modules(__path__)))


@cache
def named_scheme(name: str) -> "Plugin":
    """The scheme of that name.

    Raises
    ------
    ValueError
        If there is none, or its file defines no ``SCHEME``.
    """
    if name not in scheme_names():
        raise ValueError(f"scheme = {name!r}: must be one of {', '.join(scheme_names())}")
    from harness.plugin import Plugin

    scheme = getattr(import_module(_module(name)), "SCHEME", None)
    if not isinstance(scheme, Plugin):
        raise ValueError(f"scheme {name!r}: its file must define SCHEME, a harness.plugin.Plugin")
    return scheme


def scheme_file(name: str) -> Path:
    """The file of a scheme."""
    return Path(find_spec(_module(name)).origin)


def _module(name: str) -> str:
    return f"{__name__}.{name.replace('-', '_')}"
