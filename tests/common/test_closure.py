"""What numbers depend on, by the import statements, and against what is really imported."""

import ast
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from studies import write_study

from esfem.campaigns.mutants.markdown import CAMPAIGN
from esfem.common.closure import FOLDERS, NO_NUMBERS, closure, code, digest
from esfem.common.provenance import NUMERICS
from esfem.results.result_files import code_digest
from esfem.schemes import scheme_names

SOURCE = '''
"""Module."""
def f(x):
    """Function."""
    return x + 1  # a comment
'''
ROOT = Path(__file__).resolve().parents[2]
PACKAGES = tuple(FOLDERS.values())
RESULTS = "esfem.results.result_files"
# Says what schemes are, and counts: each imports it (`test_every_scheme_has_a_closure`).
OF_SCHEMES = ROOT / "harness/schemes/__init__.py"
FILES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


@pytest.fixture
def code_of(tmp_path):
    def of(text: str) -> str:
        path = tmp_path / "module.py"
        path.write_text(text)
        return code(path)

    return of


@pytest.mark.parametrize(
    ("old", "new"),
    [("Function.", "Another text."), ("  # a comment", ""), ("x + 1", "(x\n     + 1)")],
)
def test_docstrings_comments_and_layout_do_not_count(code_of, old, new):
    assert code_of(SOURCE.replace(old, new)) == code_of(SOURCE)


@pytest.mark.parametrize(("old", "new"), [("+", "-"), ("1", "2"), ("return x", "return -x")])
def test_every_change_of_a_formula_counts(code_of, old, new):
    assert code_of(SOURCE.replace(old, new)) != code_of(SOURCE)


class TestImports:
    """Of small programs: a file solver/a.py, and some that it may import."""

    @pytest.fixture
    def found(self, tmp_path):
        def of(text: str, **others: str) -> set[str]:
            sources = {"a": text, "b": "", "c": "", "d": ""}
            sources |= {"__init__": "from esfem.solver import d"}
            sources |= {"part/__init__": "from esfem.solver.part import inner", "part/inner": ""}
            for name, source in (sources | others).items():
                path = tmp_path / "solver" / f"{name}.py"
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(source)
            return set(closure("esfem.solver.a", root=tmp_path)) - {"esfem.solver.a"}

        return of

    @pytest.mark.parametrize(
        ("text", "expected"),
        [
            ("import numpy", set()),
            ("import esfem.solver.b", {"esfem.solver.b"}),
            (
                "import esfem.solver.b as o, esfem.solver.c",
                {"esfem.solver.b", "esfem.solver.c"},
            ),
            ("from esfem.solver.b import name", {"esfem.solver.b"}),
            ("from esfem.solver import b", {"esfem.solver.b"}),
            ("from .b import name", {"esfem.solver.b"}),
            ("from . import b, c", {"esfem.solver.b", "esfem.solver.c"}),
            ("def f():\n    from esfem.solver import b", {"esfem.solver.b"}),
            ("try:\n    import esfem.solver.b\nexcept ImportError:\n    pass", {"esfem.solver.b"}),
            ("if TYPE_CHECKING:\n    import esfem.solver.b", set()),
            ("if typing.TYPE_CHECKING:\n    import esfem.solver.b", set()),
            (
                "if TYPE_CHECKING:\n    import esfem.solver.b\nelse:\n    import esfem.solver.c",
                {"esfem.solver.c"},
            ),
        ],
    )
    def test_of_each_kind(self, found, text, expected):
        assert found(text) == expected

    def test_a_name_from_a_package_needs_all_that_the_package_imports(self, found):
        assert found("from esfem.solver import name") == {"esfem.solver", "esfem.solver.d"}
        assert found("from esfem.solver.part import name") == {
            "esfem.solver.part",
            "esfem.solver.part.inner",
        }
        assert found("import esfem.solver.part") == {"esfem.solver.part", "esfem.solver.part.inner"}

    def test_a_package_that_is_passed_does_not_count(self, found):
        assert found("from esfem.solver.part.inner import name") == {"esfem.solver.part.inner"}
        assert found("from esfem.solver.part import inner") == {"esfem.solver.part.inner"}

    def test_imports_of_imports_count_and_may_go_in_circles(self, found):
        assert found(
            "import esfem.solver.b", b="import esfem.solver.c", c="import esfem.solver.a"
        ) == {
            "esfem.solver.b",
            "esfem.solver.c",
        }

    def test_a_module_that_is_not_there_is_named(self, tmp_path):
        with pytest.raises(
            ModuleNotFoundError, match=r"esfem\.solver\.nothing: there is no such module"
        ):
            closure("esfem.solver.nothing", root=tmp_path)


class TestHash:
    @pytest.fixture(scope="class")
    @staticmethod
    def place(tmp_path_factory) -> Path:
        """A copy of the program, to be edited."""
        folder = tmp_path_factory.mktemp("program")
        for package in PACKAGES:
            shutil.copytree(ROOT / package, folder / package, ignore=only_code)
        return folder

    @pytest.mark.parametrize(
        ("roots", "file", "counts"),
        [
            (NUMERICS, "solver/forms.py", True),
            (NUMERICS, "solver/symmetric_solver.py", True),
            (NUMERICS, "reference_solutions/calculus/level_set.py", True),
            (NUMERICS, "harness/measuring/lift.py", True),
            (NUMERICS, "harness/measuring/shape.py", True),
            (NUMERICS, "harness/measuring/location.py", True),  # of errors against the finest mesh
            (NUMERICS, "harness/runs/recorder.py", True),
            (NUMERICS, "harness/schemes/kll.py", True),
            (NUMERICS, "harness/schemes/dziuk.py", False),
            (NUMERICS, "harness/results/verdicts.py", False),
            (NUMERICS, "harness/results/plots.py", False),
            (NUMERICS, "harness/runs/work.py", False),
            (NUMERICS, "harness/cli/run.py", False),
            (NUMERICS, "harness/meshes/distmesh.py", False),
            ((RESULTS,), "harness/results/verdicts.py", True),
            ((RESULTS,), "harness/judging/posterior.py", True),
            ((RESULTS,), "harness/results/plots.py", True),  # imported in a function
            ((RESULTS,), "harness/studies/words.py", True),
            ((RESULTS,), "harness/cli/run.py", False),
            ((RESULTS,), "harness/runs/work.py", False),
            ((RESULTS,), "harness/runs/executors.py", False),
            ((RESULTS,), "harness/campaigns/judge/simulation.py", False),
            ((RESULTS,), "harness/flows/checks.py", False),
            ((CAMPAIGN,), "harness/results/verdicts.py", True),
            ((CAMPAIGN,), "harness/results/records.py", True),
            ((CAMPAIGN,), "reference_solutions/discrete/radial.py", True),
            ((CAMPAIGN,), "harness/campaigns/mutants/mutant.py", True),
            ((CAMPAIGN,), "harness/campaigns/mutants/markdown.py", False),
            ((CAMPAIGN,), "harness/results/plots.py", False),
        ],
    )
    def test_an_edit_changes_what_depends_on_the_module_alone(self, place, roots, file, counts):
        before = digest(closure(*roots, root=place))
        path = place / file
        text = path.read_text()
        path.write_text(f"{text}\nEDITED = True\n")
        try:
            assert (digest(closure(*roots, root=place)) != before) == counts
        finally:
            path.write_text(text)

    def test_a_new_import_counts(self, place):
        path = place / "harness/measuring/lift.py"
        text = path.read_text()
        path.write_text(f"from esfem.runs import work\n{text}")
        try:
            assert "esfem.runs.work" in closure(*NUMERICS, root=place)
        finally:
            path.write_text(text)

    def test_a_module_that_is_renamed_changes_the_hash(self):
        modules = closure("esfem.solver.laws")
        assert digest({f"{name}s": path for name, path in modules.items()}) != digest(modules)

    def test_it_does_not_depend_on_where_the_program_lies(self, place):
        assert digest(closure(RESULTS, root=place)) == code_digest()


def only_code(folder: str, names: list[str]) -> list[str]:
    """What is not copied: all but source files and folders of them."""
    return [n for n in names if not n.endswith(".py") and not is_package(Path(folder, n))]


def is_package(path: Path) -> bool:
    return path.is_dir() and any(path.glob("*.py"))


class TestAgainstTheProgram:
    @pytest.mark.slow
    def test_whatever_a_run_really_imports_is_in_the_closure(self, tmp_path):
        """In a process of its own: a study from its file to its files."""
        study = write_study(
            tmp_path, ("[30, 60, 120, 240, 480]", "[30]"), ("[0.25, 0.125]", "[0.25]")
        )
        program = (
            "import json, sys\n"
            "from esfem.runs.run_case import run_case\n"
            "from esfem.studies.study import load_study\n"
            "from esfem.meshes import surface_mesh\n"
            f"case, = load_study(__import__('pathlib').Path({str(study)!r})).cases()\n"
            "record, _ = run_case(case, surface_mesh('sphere', 30))\n"
            "assert record.status == 'ok'\n"
            "print(json.dumps(sorted(sys.modules)))"
        )
        run = subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT
        )
        loaded = {m for m in json.loads(run.stdout) if m.split(".")[0] == "esfem"}
        counted = closure(*NUMERICS, "esfem.studies.study", without=())
        gathering = {m for m in loaded if any(other.startswith(f"{m}.") for other in loaded)}
        assert loaded - gathering <= counted.keys()
        assert len(loaded) > 60

    @pytest.mark.parametrize("left", NO_NUMBERS)
    def test_what_is_left_out_would_be_in_it(self, left):
        """A module that is moved must be named anew here."""
        assert left in closure(*NUMERICS, RESULTS, without=())

    def test_packages_do_nothing_but_gather_names(self):
        """So that one that is passed on the way to a module cannot change a number."""
        allowed = (ast.Import, ast.ImportFrom, ast.Assign, ast.AnnAssign, ast.If)
        for path in FILES:
            if path.name == "__init__.py" and path != OF_SCHEMES:
                body = ast.parse(path.read_text()).body
                rest = [node for node in body if not isinstance(node, (*allowed, ast.FunctionDef))]
                assert all(is_docstring(node) for node in rest), path

    def test_modules_are_imported_by_name_where_that_is_counted_otherwise(self):
        """Schemes and surfaces, each of which is hashed for the runs that name it."""
        dynamic = [
            name
            for name, path in closure(*NUMERICS, RESULTS).items()
            if {"import_module", "__import__"} & words(path)
        ]
        assert dynamic == ["esfem.reference_solutions.surfaces", "esfem.schemes"]

    @pytest.mark.parametrize("name", scheme_names())
    def test_every_scheme_has_a_closure(self, name):
        module = f"esfem.schemes.{name.replace('-', '_')}"
        assert {module, "esfem.schemes", "esfem.solver.geometry"} <= closure(module).keys()


def is_docstring(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def words(path: Path) -> set[str]:
    """The names in a source file."""
    return {node.id for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Name)}
