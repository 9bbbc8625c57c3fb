"""The shape of the house, read from the import statements: imports point one way."""

import ast
import sys
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from esfem.common.closure import closure
from esfem.common.closure import imported as module_imports

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("solver", "reference_solutions", "harness")

# A module of the solver may import modules of earlier rows only.
LAYERS = (
    ("reference_element", "threads"),
    ("mesh", "bdf", "levels", "pointwise", "krylov", "reuse"),
    ("geometry",),
    ("assembly", "functionals"),
    ("laws",),
    ("forms", "symmetric_solver"),
    ("block_system", "direct", "system"),
    ("ritz", "reaction"),
    ("scheme",),
    ("flow",),
)
LAYER = {name: depth for depth, row in enumerate(LAYERS) for name in row}
SOLVER_MODULES = sorted(
    path.stem for path in (ROOT / "solver").glob("*.py") if path.stem != "__init__"
)


def imported(path: Path) -> set[str]:
    """Absolute dotted names of all modules that the file imports, also inside functions."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names.add(node.module)
            # ``from solver import forms`` imports the module esfem.solver.forms.
            names |= {
                f"{node.module}.{alias.name}"
                for alias in node.names
                if (ROOT / node.module.replace(".", "/") / f"{alias.name}.py").exists()
            }
    return names


def imported_by_package(package: str) -> set[str]:
    return set().union(*(imported(path) for path in sorted((ROOT / package).rglob("*.py"))))


def tops(names: set[str]) -> set[str]:
    return {name.split(".")[0] for name in names}


def test_every_package_is_installed():
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders = {
        path.parent.relative_to(ROOT).as_posix().replace("/", ".")
        for package in PACKAGES
        for path in (ROOT / package).rglob("*.py")
    }
    assert sorted(table["tool"]["setuptools"]["packages"]) == sorted(folders)


class TestSolver:
    def test_every_module_has_a_layer(self):
        assert SOLVER_MODULES == sorted(LAYER)

    @pytest.mark.parametrize("module", SOLVER_MODULES)
    def test_imports_point_one_way(self, module):
        names = imported(ROOT / "solver" / f"{module}.py")
        inner = {name.split(".")[1] for name in names if name.startswith("solver.")}
        assert all(LAYER[name] < LAYER[module] for name in inner), inner

    @pytest.mark.parametrize("module", SOLVER_MODULES)
    def test_modules_import_modules_and_not_the_package(self, module):
        """``from solver import X`` inside the package would import everything and go in circles."""
        path = ROOT / "solver" / f"{module}.py"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module == "solver":
                assert all(f"solver.{alias.name}" in imported(path) for alias in node.names)

    @pytest.mark.parametrize(
        "path", sorted((ROOT / "solver/schemes").glob("*.py")), ids=lambda path: path.stem
    )
    def test_other_schemes_do_not_know_each_other(self, path):
        inner = {name.split(".")[1] for name in imported(path) if name.startswith("solver.")}
        assert inner <= LAYER.keys() - {"flow"}

    def test_knows_neither_harness_nor_reference_solutions(self):
        assert not tops(imported_by_package("solver")) & {"harness", "reference_solutions"}

    def test_needs_these_packages_only(self):
        foreign = tops(imported_by_package("solver")) - set(sys.stdlib_module_names) - {"solver"}
        assert foreign == {"numpy", "scipy", "numba", "basix", "threadpoolctl"}


class TestReferenceSolutions:
    def test_know_neither_solver_nor_harness(self):
        assert not tops(imported_by_package("reference_solutions")) & {"harness", "solver"}

    def test_need_numpy_scipy_sympy_only(self):
        foreign = tops(imported_by_package("reference_solutions")) - set(sys.stdlib_module_names)
        assert foreign <= {"reference_solutions", "numpy", "scipy", "sympy"}


class TestHarness:
    @pytest.mark.parametrize("package", ["solver", "reference_solutions"])
    def test_is_imported_by_no_package(self, package):
        assert "harness" not in tops(imported_by_package(package))

    def test_is_imported_by_harness_tests_and_benchmarks_only(self):
        others = [
            path
            for path in ROOT.rglob("*.py")
            if path.relative_to(ROOT).parts[0] not in ("harness", "tests", "benchmarks")
            and not path.relative_to(ROOT).parts[0].startswith(".")
        ]
        assert {path.relative_to(ROOT).parts[0] for path in others} >= {"solver"}
        assert not [path for path in others if "harness" in tops(imported(path))]


MODULES = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for path in (ROOT / "harness").rglob("*.py")
]
SCHEMES = [f"esfem.schemes.{path.stem}" for path in (ROOT / "harness/schemes").glob("[a-z]*.py")]
# What the modules of the harness on which others stand may know of it, directly or not.
STANDS_ON = {
    **dict.fromkeys(
        ("esfem.schemes", *sorted(SCHEMES)),
        ("esfem.schemes", "esfem.common.input", "esfem.common.files", "esfem.common.bad_input"),
    ),
    "esfem.meshes": ("esfem.meshes", "esfem.common.files", "esfem.common.bad_input"),
    "esfem.common.provenance": ("esfem.common.provenance", "esfem.common.closure"),
    "esfem.common.drawing": (
        "esfem.common.drawing",
        "esfem.common.provenance",
        "esfem.common.closure",
    ),
}


class TestRooms:
    @pytest.mark.parametrize("module", STANDS_ON)
    def test_stand_on_these_alone(self, module):
        found = {name for name in closure(module, without=()) if tops({name}) == {"harness"}}
        assert module in found
        stands_on = tuple(f"{name}." for name in STANDS_ON[module])
        assert all(f"{name}.".startswith(stands_on) for name in found), found

    def test_imports_go_in_no_circle(self):
        modules = closure(*MODULES, without=())
        graph = {name: module_imports(name, path) - {name} for name, path in modules.items()}
        assert len(graph) > 200
        TopologicalSorter(graph).prepare()  # a circle is an error that tells it


class TestForms:
    def test_assembly_knows_no_equation(self):
        """Matrices and loads are built without a word of the paper's letters."""
        names = {
            node.id
            for node in ast.walk(ast.parse((ROOT / "solver/assembly.py").read_text()))
            if isinstance(node, ast.Name)
        }
        assert not names & {"H", "nu", "V", "z", "Q", "S", "S2", "tau", "theta"}
