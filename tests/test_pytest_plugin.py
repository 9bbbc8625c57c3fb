"""The pytest plugin, in a session of its own: what passes, what fails, what it costs."""

import os
import subprocess
import sys
import tomllib
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import pytest
from junitparser import JUnitXml
from studies import small_study

import esfem

ROOT = Path(esfem.__file__).resolve().parent.parent
HEAD = """
from decimal import Decimal

import numpy as np
import pandas as pd

h = 0.7 * 0.5 ** (np.arange(6) / 2)
"""
PASSES = (
    "h, 0.3 * h**2, 2",
    "h, h**5, 2, declared_super=True",
    "h, h**1.6, 2, tolerance=0.5",
    "0.1, h**2, 2, tau=h, direction='tau'",
    "0.1, h**2, 2, tau=h",
    "h, h**5, 2, at_least=True",
    "h, h**2, 2, tau=0.1 * h",
    "h, h**2 * [9, 1, 1, 1, 1, 1], 2, levels='2:'",
    "h, h**2 + 1e-9, 2, floors={'solver': 1e-9}",
    "pd.Series(h, index=list('abcdef')), pd.Series(h**2, index=list('uvwxyz')), 2",
    "list(map(str, h)), [Decimal(float(s)) ** 2 for s in h], 2",
    "np.r_[h, h], np.r_[h, h] ** 2, 2, tau=np.repeat([0.1, 0.05], 6), steady=True",
)
# What is given, and the outcome that the table of the judge has.
FAILS = {
    "h, h, 2": "FAIL",
    "h, h**2 + 0.03, 2": "INCONCLUSIVE",
    "h, h**5, 2": "SUSPECT",
    "h[:2], h[:2]**2, 2": "INCONCLUSIVE",
    "0.1, h**2, 4, tau=h, direction='tau'": "FAIL",
    "h, h**2, 2, floors={'solver': 10.0}": "NOT EXERCISED",
    "h, 0 * h, 2": "INCONCLUSIVE",
    "h, 0.01 * h**2 + h, 2, tau=h": "FAIL",
}
# What is given, and what is said of it.
REFUSED = {
    "h, h[:3], 2": "as long as each other",
    "h, h**2, -1": "order = -1",
    "h, h**2, 2, direction='x'": "must be 'h' or 'tau'",
    "h, -h, 2": "errors are norms",
    "h[::-1], h**2, 2": "number of cells",
    "1 / h, h**2, 2": "give 1 / h",
    "h, h**2, 2, tol=0.3": "unknown keyword tol; must be one of h, errors, order",
    "h, h**2": "missing a required argument: 'order'",
    "h, ['a'] * 6, 2": "errors: must be numbers",
    "h, h**2, 2, floors={'noise': 1.0}": "floors = ",
    "h, h**2, 2, floors={'rounding': -1.0}": "floors = ",
    "h, h**2, '2b'": "order = '2b': must be positive",
    "h, h**2, 2, levels=slice(1, None)": "levels = ",
    "h, h**2, 2, levels_min=2": "levels_min = 2",
    "h, [10**400] * 6, 2": "errors: must be numbers",
    "h, h, 2, study='sphere'": "either h, errors and an order, or a study",
    "study='spher'": "neither a file nor a committed study",
}
STUDIES = {
    "kept": {"vertices": [30, 60, 120, 240, 480, 960]},
    "short": {"vertices": [30, 60]},
    "unclaimed": {"claim": None},
}
CALLS = (*PASSES, *FAILS, *REFUSED)


def session(folder: Path, *words: str) -> tuple[int, dict[str, str]]:
    """The status of pytest in that folder, and by test what is said of its failure, "" of a pass.

    Warnings are errors; the plugin is the only one.
    """
    (folder / "pytest.ini").write_text("[pytest]\njunit_family = xunit1\n")
    environment = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_ADDOPTS": ""}
    environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), environment.get("PYTHONPATH", "")])
    command = [sys.executable, "-W", "error", "-m", "pytest", "-p", "esfem.pytest_plugin"]
    command += ["-W", "error", "-p", "junitxml", "--junit-xml", "told.xml", *words]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert (folder / "told.xml").exists(), done.stdout + done.stderr
    (folder / "terminal.txt").write_text(done.stdout)
    cases = [case for suite in JUnitXml.fromfile(str(folder / "told.xml")) for case in suite]
    said = {case.name: "".join(f"{r.message}\n{r.text}" for r in case.result) for case in cases}
    return done.returncode, said


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A user's tests: one a call of `esfem_order`, one a study."""
    folder = tmp_path_factory.mktemp("user")
    lines = [HEAD]
    for i, call in enumerate(CALLS):
        lines.append(f"def test_{i}(esfem_order):\n    esfem_order({call})\n")
    for name, changes in STUDIES.items():
        study = small_study(folder, name=name, **changes)
        lines.append(f"def test_{name}(esfem_order):\n    esfem_order(study={str(study)!r})\n")
    (folder / "test_user.py").write_text("\n".join(lines))
    return folder


@pytest.fixture(scope="module")
def said(folder) -> Callable[[str], str]:
    """What a session says of a call, or of a study; "" if the test passed."""
    status, found = session(folder, "-p", "cacheprovider")
    assert status == 1 and len(found) == len(CALLS) + len(STUDIES)
    return lambda of: found[f"test_{CALLS.index(of) if of in CALLS else of}"]


@pytest.mark.slow
@pytest.mark.parametrize("call", PASSES)
def test_an_order_that_is_there_passes(said, call):
    """By the options that were given, too."""
    assert said(call) == ""


@pytest.mark.slow
@pytest.mark.parametrize(("call", "word"), FAILS.items())
def test_an_order_that_is_not_there_fails_with_the_table_of_the_judge(said, call, word):
    told = said(call)
    assert told.splitlines()[0].removeprefix("Failed: ").startswith(f"{word}: ")
    assert "claimed " in told.splitlines()[0] and "95 % interval" in told
    assert f"esfem_order({call})" in told, "the line of the user's test is shown"
    assert "harness/" not in told, "and none of ours"


@pytest.mark.slow
def test_an_inconclusive_table_tells_cause_and_next_run(said):
    told = said("h[:2], h[:2]**2, 2")
    assert "an order needs 4" in told and "next run: " in told


@pytest.mark.slow
@pytest.mark.parametrize(("call", "named"), REFUSED.items())
def test_bad_input_is_told_without_a_traceback(said, call, named):
    told = said(call)
    assert named in told.splitlines()[0] and "harness/" not in told


@pytest.mark.slow
def test_a_study_that_keeps_its_claims_passes_and_is_stored_for_the_next_session(said, folder):
    assert said("kept") == ""
    stored = folder / ".pytest_cache" / "d" / "esfem" / "kept"
    before = {path: path.stat().st_mtime_ns for path in stored.rglob("*.json")}
    assert stored / "verdicts.json" in before and len(before) > 10
    assert session(folder, "-p", "cacheprovider", "-k", "kept") == (0, {"test_kept": ""})
    assert {path: path.stat().st_mtime_ns for path in stored.rglob("*.json")} == before


EXPECTED = """
import pytest

@pytest.mark.esfem_expects("inconclusiv")
def test_misspelt(esfem_order):
    esfem_order(h[:2], h[:2], 1)

@pytest.mark.esfem_expects("inconclusive", reason="two meshes")
def test_as_expected(esfem_order):
    esfem_order(h[:2], h[:2]**2, 2)

@pytest.mark.esfem_expects("inconclusive", "fail")
def test_one_of_two(esfem_order):
    esfem_order(h, h, 2)

@pytest.mark.esfem_expects("fail")
def test_better_than_expected(esfem_order):
    esfem_order(h, h**2, 2)

@pytest.mark.esfem_expects("inconclusive")
def test_worse_than_expected(esfem_order):
    esfem_order(h, h, 2)

def test_two_orders(esfem_order):
    esfem_order(h, h**2, 2)
    esfem_order(h, h**3, 3)
"""


class TestSession:
    """What is expected to fail, and the table at the end."""

    @pytest.fixture(scope="class")
    @staticmethod
    def expected(tmp_path_factory) -> Path:
        folder = tmp_path_factory.mktemp("expected")
        (folder / "test_user.py").write_text(HEAD + EXPECTED)
        return folder

    @pytest.fixture(scope="class", params=[(), ("-p", "xdist", "-n", "2")], ids=["one", "xdist"])
    @staticmethod
    def run(request, expected) -> tuple[str, dict[str, str]]:
        """What the terminal shows, and what is said of each test."""
        _, said = session(expected, "--strict-markers", *request.param)
        return (expected / "terminal.txt").read_text(), said

    @pytest.mark.slow
    def test_a_marker_expects_verdicts_and_no_others(self, run):
        _, said = run
        assert said["test_as_expected"].startswith("INCONCLUSIVE: no order seen, claimed 2 - 0.2")
        assert "two meshes" in said["test_as_expected"]
        assert said["test_one_of_two"].startswith("FAIL: ")
        assert "expected was fail" in said["test_better_than_expected"]
        assert "expected was inconclusive" in said["test_worse_than_expected"]
        assert said["test_two_orders"] == ""
        assert "must name some of 'inconclusive'" in said["test_misspelt"]

    @pytest.mark.slow
    def test_all_orders_of_the_session_are_in_a_table(self, run):
        shown, said = run
        lines = shown[shown.index("orders of convergence (esfem)") :].splitlines()[1:9]
        assert lines[0].split() == ["test", "verdict", "claim", "order", "95", "%", "interval"]
        words = {line.split()[0].split("::")[1] for line in lines[1:]}
        assert words == set(said)
        assert sum("test_two_orders" in line and "PASS" in line for line in lines) == 2
        assert "1 passed" in shown and "2 xfailed" in shown and "3 failed" in shown

    @pytest.mark.slow
    def test_junit_has_the_verdicts(self, run, expected):
        assert run and 'name="esfem_order" value="PASS; 2 - 0.2 in h; 2.00' in (
            expected / "told.xml"
        ).read_text().replace("&lt;", "<")


@pytest.mark.slow
@pytest.mark.parametrize(("study", "word"), [("short", "INCONCLUSIVE"), ("unclaimed", "NO CLAIM")])
def test_a_study_that_proves_nothing_fails(said, study, word):
    assert word in said(study) and "A small study" in said(study)


def test_loading_the_plugin_loads_nothing_heavy(tmp_path):
    (tmp_path / "test_light.py").write_text(
        "import sys\n\ndef test_it():\n"
        "    assert 'esfem.pytest_plugin' in sys.modules\n"
        "    heavy = {'numpy', 'scipy', 'sympy', 'pandas', 'matplotlib', 'pydantic', 'typer'}\n"
        "    assert not heavy & set(sys.modules)\n"
    )
    assert session(tmp_path) == (0, {"test_it": ""})


def test_the_entry_point_names_the_plugin():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    module = import_module(project["entry-points"]["pytest11"]["esfem"])
    assert hasattr(module, "esfem_order")


def test_every_public_name_of_the_package_loads():
    for name in esfem.__all__:
        assert getattr(esfem, name).__name__ == name
    with pytest.raises(AttributeError, match="no attribute 'run_studie'"):
        _ = esfem.run_studie
