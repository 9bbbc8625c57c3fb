"""The installed package, from a wheel and as `make env` installs it, in somebody's folder.

That folder holds modules of the same names as ours: solver.py, harness.py, reference_solutions/,
tests/. Nothing is downloaded: the packages that are needed are those of the present environment.
"""

import filecmp
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pandas as pd
import pytest
from filelock import FileLock
from studies import write_study

import esfem
from esfem.campaigns.mutants.markdown import campaign_digest
from esfem.common.closure import FOLDERS
from esfem.common.provenance import numerics_digest, version
from esfem.results.result_files import code_digest

pytestmark = pytest.mark.slow

ROOT = Path(esfem.__file__).resolve().parent.parent
NAMES = {folder: name.replace(".", "/") for name, folder in FOLDERS.items()}
NOT_INSTALLED = shutil.ignore_patterns("__pycache__")
THEIRS = 'MINE = "theirs"\n'
USED = """
import json, sys
import harness, reference_solutions, solver

assert {m.MINE for m in (harness, reference_solutions, solver)} == {"theirs"}
import esfem, esfem.cli.run, esfem.results.run_studies, esfem.campaigns.paper.run
import esfem.campaigns.mutants.markdown as mutants
from esfem.common.provenance import numerics_digest
from esfem.results.result_files import code_digest

ours = {name for name in sys.modules if name.split(".")[0] in ("solver", "harness")}
print(json.dumps({
    "folder": esfem.__path__[0],
    "version": esfem.__version__,
    "digests": [numerics_digest(), code_digest(), mutants.campaign_digest()],
    "theirs": sorted(ours),
}))
"""
GUARDED = """
import harness, reference_solutions, solver

h = [2.0**-i for i in range(6)]

def test_order(esfem_order):
    esfem_order(h, [s**2 for s in h], 2)
    assert {m.MINE for m in (harness, reference_solutions, solver)} == {"theirs"}

def test_no_order(esfem_order):
    esfem_order(h, h, 2)
"""


def run(place: Path, *words: object, status: int = 0, **variables: str) -> str:
    """Run a program in that folder, as outside of this session: what it says."""
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "PYTEST", "NUMBA"))}
    done = subprocess.run(
        [str(word) for word in words],
        cwd=place,
        env={**kept, "PYTHONUNBUFFERED": "1", **variables},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert done.returncode == status, done.stdout
    return done.stdout


def once(tmp_path_factory: pytest.TempPathFactory, name: str, make: Callable[[Path], None]) -> Path:
    """A folder that one process of the session makes for all."""
    shared = tmp_path_factory.getbasetemp()
    shared = shared.parent if "PYTEST_XDIST_WORKER" in os.environ else shared
    folder = shared / name
    with FileLock(shared / f"{name}.lock"):
        if not folder.exists():
            make(folder)
    return folder


@pytest.fixture(scope="session")
def wheel(tmp_path_factory) -> Path:
    """A wheel of this checkout, built from a copy: setuptools leaves its traces there."""

    def make(folder: Path) -> None:
        for name in NAMES:
            shutil.copytree(ROOT / name, folder / "source" / name, ignore=NOT_INSTALLED)
        for name in ("pyproject.toml", "README.md", "LICENSE"):
            shutil.copy(ROOT / name, folder / "source")
        words = ("wheel", "--no-deps", "--no-build-isolation", "--no-index", "-w", folder)
        run(folder, sys.executable, "-m", "pip", "-q", *words, folder / "source")

    (file,) = once(tmp_path_factory, "wheel", make).glob("*.whl")
    return file


@pytest.fixture(scope="session")
def python(wheel, tmp_path_factory) -> Path:
    """The interpreter of a fresh environment with that wheel."""

    def make(folder: Path) -> None:
        venv.create(folder)
        python = folder / "bin" / "python"
        words = ("-m", "pip", "--python", python, "install", "-q", "--no-deps", "--no-index")
        run(folder, sys.executable, *words, wheel)
        site = sysconfig.get_path("purelib", vars={"base": str(folder)})
        # Of the files *.pth there Python reads none, so that an editable install stays unseen.
        (Path(site) / "packages.pth").write_text(sysconfig.get_path("purelib"))

    return once(tmp_path_factory, "fresh", make) / "bin" / "python"


@pytest.fixture
def place(tmp_path) -> Path:
    """A folder of somebody who has modules of the same names."""
    for name in ("solver.py", "harness.py", "reference_solutions/__init__.py", "tests/__init__.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(THEIRS)
    (tmp_path / "tests/test_user.py").write_text(GUARDED)
    (tmp_path / "use.py").write_text(USED)
    return tmp_path


def test_the_wheel_has_every_file_of_the_packages(wheel, tmp_path):
    """Studies, meshes, claims, templates, sentences, texts, mutants and py.typed among them."""
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    expected = {
        Path(name, path.relative_to(ROOT / folder)): path
        for folder, name in NAMES.items()
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    found = {path.relative_to(tmp_path) for path in (tmp_path / "esfem").rglob("*")}
    assert {path for path in found if (tmp_path / path).is_file()} == set(expected)
    assert all(filecmp.cmp(tmp_path / name, path, False) for name, path in expected.items())


class TestNames:
    def test_of_the_wheel(self, python, place):
        self.belong(python, place, Path(sysconfig.get_path("purelib", vars={"base": ""})).name)
        assert "clifford-degree-2" in run(place, python, "-m", "esfem", "list")

    def test_of_this_environment(self, place):
        self.belong(Path(sys.executable), place, "harness")

    def belong(self, python: Path, place: Path, where: str) -> None:
        """What is imported by whom, and the digests of what is installed."""
        used = json.loads(run(place, python, "use.py").splitlines()[-1])
        folder = Path(used.pop("folder"))
        assert (folder if where == "harness" else folder.parent).name == where
        assert used == {
            "version": version(),
            "digests": [numerics_digest(), code_digest(), campaign_digest()],
            "theirs": ["harness", "solver"],
        }
        said = run(place, python.parent / "esfem", "--version")
        assert said == f"esfem-willmore {version()} (numerics {numerics_digest()})\n"


def test_processes_of_both_kinds_run_a_study_and_kernels_are_kept(python, place):
    """The processes of dask load what those of loky compiled, below the installed package."""
    small = (("[30, 60, 120, 240, 480]", "[30]"), ("[0.25, 0.125]", "[0.25, 0.125]"))
    study = write_study(place, *small, ('claim = "section-7"\n', ""))
    tables, said = [], []
    second = "dask" if find_spec("distributed") else "local"
    for i, (executor, jobs) in enumerate([("local", 2), (second, 1)]):
        words = ("run", study, "--jobs", jobs, "--executor", executor, "--out", f"out-{i}")
        said.append(run(place, python.parent / "esfem", *words, NUMBA_DEBUG_CACHE="1"))
        table = pd.read_csv(place / f"out-{i}/small/records.csv", comment="#")
        assert list(table["status"]) == ["ok", "ok"]
        tables.append(table.filter(regex="^(err|nodal)_"))
    pd.testing.assert_frame_equal(*tables, check_exact=True)
    kept = set(re.findall(r"data saved to '(.*?)'", said[0]))
    loaded = set(re.findall(r"data loaded from '(.*?)'", said[1]))
    assert kept and kept <= loaded and "data saved to" not in said[1]
    assert all("/esfem/solver/__pycache__/kernels-" in name for name in kept)


@pytest.mark.parametrize("words", [(), ("-n", "2")], ids=["plain", "xdist"])
def test_the_fixture_guards_a_foreign_project(python, place, words):
    said = run(place, python, "-m", "pytest", "-q", *words, status=1)
    assert "1 failed, 1 passed" in said
    assert "test_user.py::test_no_order" in said and "95 % interval" in said
