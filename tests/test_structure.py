"""The shape of the house: what is installed, and what each package needs. `make lint` holds the
layers (see test_lint.py)."""

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from esfem.common.closure import FOLDERS, closure

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
ROOMS = "common measuring judging meshes schemes studies runs flows results report campaigns cli"


def imported(path: Path) -> set[str]:
    """The top names of all modules that the file imports, also inside functions."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names.add(node.module.split(".")[0])
    return names


def needed(folder: str) -> set[str]:
    """What the modules of a folder import that is neither Python's nor ours."""
    found = set().union(*(imported(path) for path in sorted((ROOT / folder).rglob("*.py"))))
    return found - set(sys.stdlib_module_names) - {"esfem"}


def test_every_package_is_installed():
    folders = {
        f"{name}.{'.'.join(path.parent.relative_to(ROOT / folder).parts)}".rstrip(".")
        for name, folder in FOLDERS.items()
        for path in (ROOT / folder).rglob("*.py")
    }
    assert sorted(PROJECT["tool"]["setuptools"]["packages"]) == sorted(folders)


def test_all_data_are_installed():
    """What lies in a package beside its modules, by the lists of package data."""
    data = PROJECT["tool"]["setuptools"]["package-data"]
    installed = {ROOT / "harness/py.typed"}
    for name, patterns in data.items():
        folder = ROOT / "harness" / Path(*name.split(".")[1:])
        for pattern in patterns:
            found = set(folder.glob(pattern))
            assert found, f"{name}: {pattern}"
            installed |= found
    files = {path for path in (ROOT / "harness").rglob("*") if path.is_file()}
    assert {p for p in files if p.suffix != ".py" and "__pycache__" not in p.parts} == installed


def test_the_root_of_the_harness_holds_the_rooms():
    files = {path.relative_to(ROOT / "harness") for path in (ROOT / "harness").rglob("*.*")}
    root = {path.parts[0] for path in files if "__pycache__" not in path.parts} - {"py.typed"}
    assert root == {*ROOMS.split(), "__init__.py", "__main__.py", "pytest_plugin.py"}


def test_nothing_is_imported_by_the_name_of_its_folder():
    """A user may have a solver.py beside his script."""
    code = "import sys, esfem.cli.run, esfem.results.run_studies, esfem.campaigns.paper.run\n"
    code += f"sys.exit(bool({set(FOLDERS.values())} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT).returncode == 0
    for folder in (*FOLDERS.values(), "tests", "benchmarks"):
        for path in (ROOT / folder).rglob("*.py"):
            assert not imported(path) & set(FOLDERS.values()), path


def test_the_solver_needs_these_packages_only():
    assert needed("solver") == {"numpy", "scipy", "numba", "basix", "threadpoolctl"}


def test_the_reference_solutions_need_these_packages_only():
    assert needed("reference_solutions") == {"numpy", "scipy", "sympy"}


def test_what_records_count_knows_little():
    """Digests are derived from imports: what others stand on must not pull in the rest."""
    inner = {
        "esfem.common.provenance": {"esfem.common.closure"},
        "esfem.common.drawing": {"esfem.common.closure", "esfem.common.provenance"},
    }
    for name, below in inner.items():
        found = set(closure(name, without=()))
        assert {n for n in found if n.startswith("esfem.common.")} == {name, *below}
        assert all(n.startswith(("esfem.common.", "esfem.solver.")) for n in found)


@pytest.mark.parametrize("room", ["meshes", "schemes", "judging", "measuring"])
def test_what_others_stand_on_knows_no_study(room):
    for path in (ROOT / "harness" / room).rglob("*.py"):
        module = ".".join(("esfem", *path.relative_to(ROOT / "harness").with_suffix("").parts))
        found = closure(module.removesuffix(".__init__"), without=())
        assert not any(n.startswith(("esfem.studies.", "esfem.runs.")) for n in found), module


def test_assembly_knows_no_equation():
    """Matrices and loads are built without a word of the paper's letters."""
    names = {
        node.id
        for node in ast.walk(ast.parse((ROOT / "solver/assembly.py").read_text()))
        if isinstance(node, ast.Name)
    }
    assert not names & {"H", "nu", "V", "z", "Q", "S", "S2", "tau", "theta"}


def test_modules_of_one_name_do_the_same_thing():
    """The command and what it calls, and the run of each campaign; any other name stands once."""
    same = {"judge", "run", "baseline"}
    names = [p.stem for p in (ROOT / "harness").rglob("*.py") if not p.stem.startswith("__")]
    assert {name for name in names if names.count(name) > 1} == same
