"""What `make lint` runs finds what is planted in a copy of the program."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from links import ROOT, link

FOLDERS = ("harness", "solver", "reference_solutions")
BIN = Path(sys.executable).parent


@pytest.fixture
def place(tmp_path) -> Path:
    return copied(tmp_path)


def copied(folder: Path) -> Path:
    """A copy of the program, to be edited."""
    for part in FOLDERS:
        ignored = shutil.ignore_patterns("__pycache__", "*.npz")
        shutil.copytree(ROOT / part, folder / part, ignore=ignored)
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def imports(root: Path) -> tuple[int, str]:
    """Status and output of import-linter over the program there."""
    link(root / "build/types", root)
    return run(root, "lint-imports", "--no-logo", "--no-cache")


def types(root: Path, module: str) -> tuple[int, str]:
    """Status and output of mypy over one module there, and what it imports."""
    link(root / "build/types", root)
    return run(root, "mypy", "-m", module)


def run(root: Path, tool: str, *words: str) -> tuple[int, str]:
    environment = {**os.environ, "PYTHONPATH": "build/types"}
    done = subprocess.run(
        [BIN / tool, *words], cwd=root, env=environment, capture_output=True, text=True
    )
    return done.returncode, done.stdout + done.stderr


def plant(path: Path, text: str) -> None:
    path.write_text(f"{path.read_text(encoding='utf-8')}\n{text}\n", encoding="utf-8")


# Imports that point up or aside: where, how it is written, and how it is told.
UPWARD = (
    ("harness/common/bad_input.py", "import esfem.cli", "esfem.common.bad_input -> esfem.cli"),
    ("solver/bdf.py", "from esfem import common", "esfem.solver.bdf -> esfem.common"),
    (
        *("solver/bdf.py", "import esfem.reference_solutions"),
        "esfem.solver.bdf -> esfem.reference_solutions",
    ),
    ("solver/mesh.py", "from esfem.solver import flow", "esfem.solver.mesh -> esfem.solver.flow"),
    ("solver/forms.py", "import esfem.solver", "esfem.solver.forms -> esfem.solver"),
    (
        *("solver/schemes/bgn.py", "from . import dziuk"),
        "esfem.solver.schemes.bgn -> esfem.solver.schemes.dziuk",
    ),
    ("harness/runs/store.py", "import esfem", "esfem.runs.store -> esfem"),
)


class TestImports:
    @pytest.fixture(scope="class")
    @staticmethod
    def said(tmp_path_factory) -> str:
        """What is said of a program with all of them, and with a room that has no place."""
        place = copied(tmp_path_factory.mktemp("upward"))
        for file, text, _ in UPWARD:
            plant(place / file, text)
        (place / "harness/attic.py").write_text("")
        status, said = imports(place)
        assert status == 1
        return said

    def test_the_program_keeps_all_contracts(self, place):
        status, said = imports(place)
        assert status == 0, said
        assert " 0 broken" in said

    @pytest.mark.parametrize(("file", "text", "told"), UPWARD)
    def test_an_import_that_points_up_is_found(self, said, file, text, told):
        assert f"{told} (l." in said

    def test_every_contract_can_break(self, said):
        assert "Contracts: 0 kept" in said

    def test_a_new_room_must_have_a_place(self, said):
        assert "not listed as layers" in said and "- esfem.attic\n" in said


@pytest.mark.slow
class TestTypes:
    def test_the_program_has_none(self, tmp_path):
        link(tmp_path / "build/types")
        shutil.copy(ROOT / "pyproject.toml", tmp_path)
        status, said = run(tmp_path, "mypy")
        assert status == 0, said

    PLANTED = """
ORDER: int = BDF.TABLE[1]
def untyped(order):
    return order
ONE = combine([1.0])
"""

    def test_errors_are_found(self, place):
        plant(place / "solver/bdf.py", self.PLANTED)
        status, said = types(place, "esfem.solver.bdf")
        assert status == 1
        assert "Found 3 errors in 1 file" in said
        assert all(f"[{code}]" in said for code in ("assignment", "no-untyped-def", "call-arg"))
