"""Which program, on which machine: what every stored result says of its origin."""

import importlib.metadata
import platform
import re
import sys
from functools import lru_cache
from pathlib import Path

from esfem.common.closure import closure, digest

# What computes the numbers of a run: the run itself, the scheme of the paper, and the comparison
# with the finest mesh. These and all that they import make a record obsolete when they change;
# sweeps, tables and plots may change without a run being repeated.
NUMERICS = ("esfem.runs.run_case", "esfem.schemes.kll", "esfem.measuring.overlay")


@lru_cache
def version() -> str:
    """Version of the package."""
    return importlib.metadata.version("esfem-willmore")


@lru_cache
def numerics_digest() -> str:
    """Hash of the code that makes the numbers: docstrings, comments and layout do not count."""
    return digest(closure(*NUMERICS))


@lru_cache
def stepping_digest(scheme: Path) -> str:
    """Hash of what the numbers of a scheme that is given by its step depend on besides: its file,
    and what that imports."""
    name = f"esfem.schemes.{scheme.stem}"
    return digest(closure(name, files={name: scheme}))


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
    from esfem.solver.symmetric_solver import symmetric_solver_name  # slow to load

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
    names = [re.split(r"[^\w.-]", line)[0] for line in required if "extra ==" not in line]
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
