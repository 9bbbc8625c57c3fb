"""The pytest plugin, in sessions of its own: what passes, what fails, what it costs."""

import os
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest
from studies import write_study

import esfem

ROOT = Path(esfem.__file__).resolve().parent.parent
TABLE = """
import numpy as np

h = 0.7 * 0.5 ** (np.arange(6) / 2)

def test_order(esfem_order):
"""


@pytest.fixture
def session(tmp_path):
    """Runs pytest on a file of that content, warnings being errors; the plugin is the only one."""

    def run(content: str, *words: str) -> tuple[int, str]:
        (tmp_path / "test_user.py").write_text(content)
        (tmp_path / "pytest.ini").write_text("[pytest]\n")
        environment = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_ADDOPTS": ""}
        environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), environment.get("PYTHONPATH", "")])
        command = [sys.executable, "-W", "error", "-m", "pytest", "-p", "esfem.pytest_plugin"]
        done = subprocess.run(
            [*command, "-W", "error", *words],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        return done.returncode, done.stdout + done.stderr

    return run


def test_an_order_that_is_there_passes(session):
    status, out = session(TABLE + "    esfem_order(h, 0.3 * h**2, 2)\n")
    assert status == 0, out


@pytest.mark.parametrize(
    ("call", "word"),
    [
        ("h, h, 2", "FAIL"),
        ("h, h**2 + 0.03, 2", "INCONCLUSIVE"),
        ("h, h**5, 2", "SUSPECT"),
        ("h[:2], h[:2]**2, 2", "INCONCLUSIVE"),
        ("0.1, h**2, 4, tau=h, direction='tau'", "FAIL"),
    ],
)
def test_an_order_that_is_not_there_fails_with_the_table_of_the_judge(session, call, word):
    status, out = session(TABLE + f"    esfem_order({call})\n")
    assert status == 1
    assert word in out and "95 % interval" in out
    assert f"esfem_order({call})" in out, "the line of the user's test is shown"
    assert "harness/" not in out.partition("short test summary")[0], "and none of ours"


def test_an_inconclusive_table_tells_cause_and_next_run(session):
    _, out = session(TABLE + "    esfem_order(h[:2], h[:2]**2, 2)\n")
    assert "cause: too few levels" in out and "next run: " in out


def test_options_reach_the_judge(session):
    lines = (
        "    esfem_order(h, h**5, 2, declared_super=True)\n"
        "    esfem_order(h, h**1.6, 2, tolerance=0.5)\n"
        "    esfem_order(0.1, h**2, 2, tau=h, direction='tau')\n"
    )
    status, out = session(TABLE + lines)
    assert status == 0, out


@pytest.mark.parametrize(
    ("call", "named"),
    [
        ("h, h[:3], 2", "as long as each other"),
        ("h, h**2, -1", "order = -1"),
        ("h, h**2, 2, direction='x'", "must be 'h' or 'tau'"),
        ("h, -h, 2", "errors are norms"),
        ("h, h, 2, study='sphere'", "either h, errors and an order, or a study"),
        ("study='spher'", "neither a file nor a committed study"),
    ],
)
def test_bad_input_is_told(session, call, named):
    status, out = session(TABLE + f"    esfem_order({call})\n")
    assert status == 1 and named in out


def guarded(path: Path, **options: object) -> str:
    words = "".join(f", {name}={value!r}" for name, value in options.items())
    return f"def test_it(esfem_order):\n    esfem_order(study={str(path)!r}{words})\n"


def test_a_study_that_keeps_its_claims_passes_and_is_stored_for_the_next_session(session, tmp_path):
    content = guarded(write_study(tmp_path))
    for _ in range(2):
        status, out = session(content, "-p", "cacheprovider")
        assert status == 0, out
    assert (tmp_path / ".pytest_cache" / "d" / "esfem" / "small" / "verdicts.json").exists()


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (("vertices = [30, 60, 120, 240, 480]", "vertices = [30, 60]"), "INCONCLUSIVE"),
        (('claim = "section-7"\n', ""), "NO CLAIM"),
    ],
)
def test_a_study_that_proves_nothing_fails(session, tmp_path, change, word):
    study = write_study(tmp_path, change)
    status, out = session(guarded(study, out=str(tmp_path / "out")))
    assert status == 1
    assert word in out and "A small study" in out


def test_loading_the_plugin_loads_nothing_heavy(session):
    content = (
        "import sys\n\ndef test_it():\n"
        "    assert 'esfem.pytest_plugin' in sys.modules\n"
        "    heavy = {'numpy', 'scipy', 'sympy', 'pandas', 'matplotlib', 'pydantic', 'typer'}\n"
        "    assert not heavy & set(sys.modules)\n"
    )
    status, out = session(content)
    assert status == 0, out


def test_the_entry_point_names_the_plugin():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    module = import_module(project["entry-points"]["pytest11"]["esfem"])
    assert hasattr(module, "esfem_order")


def test_every_public_name_of_the_package_loads():
    for name in esfem.__all__:
        assert getattr(esfem, name).__name__ == name
    with pytest.raises(AttributeError, match="no attribute 'run_studie'"):
        _ = esfem.run_studie
