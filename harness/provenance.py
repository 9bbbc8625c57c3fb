"""Which program, on which machine: what every stored result says of its origin."""

import ast
import hashlib
import importlib.metadata
import platform
import re
import sys
from functools import lru_cache
from pathlib import Path

import solver
from solver.symmetric_solver import symmetric_solver_name

# What the numbers of a record depend on.  Sweeps, tables and plots may change without a run being
# repeated.
NUMERICS = (
    "solver/*.py",
    "reference_solutions/*.py",
    "reference_solutions/calculus/*.py",
    "harness/case.py",
    "harness/errors.py",
    "harness/location.py",
    "harness/recorder.py",
    "harness/reference.py",
    "harness/schemes.py",
    "harness/runner.py",
    "harness/transfer.py",
)


@lru_cache
def version() -> str:
    """Version of the package."""
    return importlib.metadata.version("esfem-willmore")


@lru_cache
def numerics_digest() -> str:
    """Hash of the code that makes the numbers: docstrings, comments and layout do not count."""
    root = Path(solver.__file__).resolve().parent.parent
    digest = hashlib.sha256()
    for pattern in NUMERICS:
        for path in sorted(root.glob(pattern)):
            digest.update(f"{path.name}\n{code(path)}\n".encode())
    return digest.hexdigest()[:16]


def code(path: Path) -> str:
    """What a source file does: its syntax tree without docstrings, comments and layout."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
            and ast.get_docstring(node) is not None
        ):
            node.body = node.body[1:]
    return ast.dump(tree)


@lru_cache
def machine() -> str:
    """Processor and system, in one line."""
    python = platform.python_version()
    return f"{_processor()}, {platform.system()} {platform.machine()}, Python {python}"


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or "unknown processor"


@lru_cache
def environment() -> dict[str, str]:
    """What a record says of where it was computed."""
    packages = ("numpy", "scipy", "fenics-basix", "mkl")
    return {
        "version": version(),
        "numerics": numerics_digest(),
        "machine": machine(),
        "direct_solver": symmetric_solver_name(),
        **{name: _installed(name) for name in packages},
    }


def dependencies() -> dict[str, str]:
    """The installed version of each package that the program needs, by name."""
    required = importlib.metadata.requires("esfem-willmore") or []
    names = [re.match(r"[\w.-]+", line).group() for line in required if "extra ==" not in line]
    return {name: _installed(name) for name in sorted(names, key=str.lower)}


def _installed(name: str) -> str:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "absent"


def command() -> str:
    """The command line of this process, without the folders of this machine."""
    words = [Path(sys.argv[0]).name if sys.argv and sys.argv[0] else "python", *sys.argv[1:]]
    return " ".join(words)


def provenance_line() -> str:
    """One line for the head of a table or the metadata of a figure."""
    program = f"esfem-willmore {version()} (numerics {numerics_digest()})"
    return f"{program}; command: {command()}; {machine()}"
