"""What README shows works as it stands."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import harness
from harness.meshing import generate
from harness.study import load_study
from reference_solutions import surfaces

ROOT = Path(harness.__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_the_study_of_the_readme_is_valid(tmp_path):
    (study,) = blocks("toml")
    path = tmp_path / "study.toml"
    path.write_text(study)
    assert load_study(path).study.claim == "theorem"


def test_the_surface_of_the_readme_can_be_meshed(tmp_path, monkeypatch):
    (code,) = blocks("py")
    (tmp_path / "pebble.py").write_text(code)
    monkeypatch.setattr(surfaces, "__path__", [*surfaces.__path__, str(tmp_path)])
    mesh = generate("pebble", 120, seeds=(0,))
    assert surfaces.named_surface("pebble").fields(mesh.vertices).H.min() > 0


MY_STUDY = """
def my_study():
    h = [2.0 ** (-i) for i in range(5)]
    return h, [s**{power} for s in h]
"""


def test_the_guard_of_the_readme_guards(tmp_path):
    (code,) = (block for block in blocks("python") if "def test_" in block)
    assert len(code.splitlines()) == 3
    for power, status in ((2, 0), (1, 1)):
        (tmp_path / "test_user.py").write_text(f"{MY_STUDY.format(power=power)}\n\n{code}")
        command = [sys.executable, "-m", "pytest", "-p", "harness.pytest_plugin", str(tmp_path)]
        path = {"PYTHONPATH": str(ROOT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
        done = subprocess.run(
            command, cwd=tmp_path, env={**os.environ, **path}, capture_output=True
        )
        assert done.returncode == status


SCRIPTS = [block for block in blocks("python") if "def test_" not in block]


@pytest.mark.slow
@pytest.mark.parametrize("code", SCRIPTS, ids=["run_study", "evolve"])
def test_the_python_of_the_readme_runs(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(code.replace("harness/studies", str(ROOT / "harness" / "studies")), {})
    assert len(capsys.readouterr().out.splitlines()) >= 7


def test_every_make_target_of_the_readme_exists():
    makefile = (ROOT / "Makefile").read_text()
    named = set(re.findall(r"make ([a-z-]+)", README))
    assert {"convergence", "test"} <= named
    for target in named:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE)


def test_every_link_of_the_readme_leads_to_a_file():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


def test_the_rates_of_the_judge_are_those_of_the_report():
    """Also the program's: the table of README stands in the report that it wrote."""
    report = (ROOT / "results" / "judge" / "report.md").read_text(encoding="utf-8").splitlines()
    section = README.partition("## Judge any table")[2].partition("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("|")]
    assert len(rows) == 7
    assert all(row in report for row in rows)
