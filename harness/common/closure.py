"""What numbers are made by: the modules that a module imports, and a hash of what they do.

Which modules these are is read from the import statements, not kept by hand:

- every import counts, also one inside a function, but not below ``if TYPE_CHECKING``;
- ``from a.b import c`` is the module a.b.c if there is one, else a.b, and of a package its
  ``__init__`` with all that it imports. The packages passed on the way there (a, and a.b on the way
  to a.b.c) do not count: their ``__init__`` gathers names and computes nothing;
- what is imported by name at run time is not seen: a scheme counts for the runs that name it
  (`esfem.common.provenance.stepping_digest`), a surface likewise (`surface_digest`).

The hash is over names and code. A module that is moved or renamed changes it, and so do imports
that follow it: the results count as made by another program, and are made anew once.
"""

import ast
import hashlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path

# The folder of each package in a checkout; an installed one lies where Python finds it.
FOLDERS = {
    "esfem.solver": "solver",
    "esfem.reference_solutions": "reference_solutions",
    "esfem": "harness",
}

# Where the closure of a result ends, and why nothing behind these can change a number of it.
NO_NUMBERS = {
    "esfem.common.provenance": "says where a result is from",
    "esfem.runs.checkpoint": "an interrupted run goes on to the last bit the same",
    "esfem.meshes": "a mesh counts by its own digest, however it was made",
}


def closure(
    *modules: str,
    root: Path | None = None,
    files: Mapping[str, Path] | None = None,
    without: Collection[str] = tuple(NO_NUMBERS),
) -> dict[str, Path]:
    """The modules of this program that these import, themselves included, directly or not.

    Parameters
    ----------
    modules : dotted names.
    root : a checkout; by default the program that runs.
    files : by name, of modules that lie elsewhere.
    without : modules and packages that are left out, with what they alone import.

    Returns
    -------
    Their files by dotted name, sorted.

    Raises
    ------
    ModuleNotFoundError
        If one of ``modules`` does not exist.
    """
    files = files or {}
    found: dict[str, Path] = {}
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        if name in found or any(f"{name}.".startswith(f"{left}.") for left in without):
            continue
        path = files.get(name) or module_file(name, root)
        if path is None:
            below = f" below {root}" if root else ""
            raise ModuleNotFoundError(f"{name}: there is no such module{below}")
        found[name] = path
        waiting += imported(name, path, root)
    return dict(sorted(found.items()))


def imported(name: str, path: Path, root: Path | None = None) -> set[str]:
    """The modules of this program that the module of that name and file imports."""
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    found: set[str] = set()
    for node in _run_time(_tree(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            source = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                inner = f"{source}.{alias.name}"
                found.add(inner if module_file(inner, root) else source)
    return {name for name in found if name.split(".")[0] == "esfem"}


def module_file(name: str, root: Path | None = None) -> Path | None:
    """The file of a module, or the ``__init__`` of a package; None if there is neither."""
    package = next((p for p in FOLDERS if f"{name}.".startswith(f"{p}.")), None)
    if package is None:
        return None
    folder = _folder(package) if root is None else root / FOLDERS[package]
    place = folder.joinpath(*name.removeprefix(package).split(".")[1:])
    files = (place / "__init__.py", place.with_name(f"{place.name}.py"))
    return next((path for path in files if path.is_file()), None)


@cache
def _folder(package: str) -> Path:
    spec = find_spec(package)
    assert spec is not None and spec.origin is not None, package
    return Path(spec.origin).parent


def digest(modules: Mapping[str, Path]) -> str:
    """Hash of modules by name: docstrings, comments and layout do not count."""
    content = "\n".join(f"{name}\n{code(path)}" for name, path in sorted(modules.items()))
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def code(path: Path) -> str:
    """What a source file does: its syntax tree without docstrings, comments and layout."""
    return _dumped(path.read_text(encoding="utf-8"))


@cache
def _dumped(source: str) -> str:
    return ast.dump(_tree(source))


@cache
def _tree(source: str) -> ast.Module:
    """The syntax tree without docstrings."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
            and ast.get_docstring(node) is not None
        ):
            node.body = node.body[1:]
    return tree


TYPING = ("TYPE_CHECKING", "typing.TYPE_CHECKING")


def _run_time(node: ast.AST) -> Iterator[ast.AST]:
    """The node and all below it, without what is for type checkers."""
    yield node
    if isinstance(node, ast.If) and ast.unparse(node.test) in TYPING:
        below: Iterable[ast.AST] = node.orelse
    else:
        below = ast.iter_child_nodes(node)
    for inner in below:
        yield from _run_time(inner)
