"""What README shows works as it stands."""

import json
import os
import re
import subprocess
import sys
from collections import Counter
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import esfem
from esfem import schemes
from esfem.common.bad_input import BadInput
from esfem.meshes import generate, surface_mesh
from esfem.reference_solutions import surfaces
from esfem.results.study_result import StudyResult
from esfem.runs.run_case import run_case
from esfem.studies.study import load_study

ROOT = Path(esfem.__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_the_study_of_the_readme_is_valid(tmp_path):
    (study,) = blocks("toml")
    path = tmp_path / "study.toml"
    path.write_text(study)
    assert load_study(path).study.claim == "order-k"


def test_the_surface_of_the_readme_can_be_meshed(tmp_path, monkeypatch):
    code = blocks("py")[0]
    (tmp_path / "pebble.py").write_text(code)
    monkeypatch.setattr(surfaces, "__path__", [*surfaces.__path__, str(tmp_path)])
    mesh = generate("pebble", 120, seeds=(0,))
    assert surfaces.named_surface("pebble").fields(mesh.vertices).H.min() > 0


def test_the_scheme_of_the_readme_shrinks_the_sphere(tmp_path, monkeypatch):
    """From its one file, with an option of its own: at its order in time, 1."""
    code = blocks("py")[1]
    assert 30 <= len(code.splitlines()) <= 45
    (tmp_path / "stable_mcf.py").write_text(code)
    monkeypatch.setattr(schemes, "__path__", [*schemes.__path__, str(tmp_path)])
    lines = README.partition("names it, `-` for `_`")[2].partition("`start=`")[0].splitlines()
    toml = "\n".join(line.strip() for line in lines if line.startswith("    "))
    head = '[study]\nname = "mine"\ntitle = "Mine"\n'
    sweep = "[sweep]\nvertices = [120]\ntau = [0.01, 0.005]\nfinal_time = 0.1\n"
    path = tmp_path / "study.toml"
    path.write_text(f"{head}{toml}\n{sweep}")
    study = load_study(path)
    assert StudyResult(study, tmp_path, None, None, []).headings["nu"] == "nu (recovered)"
    errors = []
    for case in study.cases():
        record, _ = run_case(case, surface_mesh("sphere", case.vertices))
        assert record.status == "ok"
        errors.append(record.h1()["x"][-1])
    assert 0.7 < np.log2(errors[0] / errors[1]) < 1.3
    path.write_text(f"{head}{toml}\nimplicit = 2.0\n{sweep}")
    with pytest.raises(BadInput, match=r"\[scheme\] implicit = 2\.0: .*less than or equal to 1"):
        load_study(path)


MY_STUDY = """
def my_study():
    h = [2.0 ** (-i) for i in range(5)]
    return h, [s**{power} for s in h]
"""


def test_the_guard_of_the_readme_guards(tmp_path):
    (code,) = (block for block in blocks("python") if "def test_" in block)
    assert len(code.splitlines()) == 3
    for power in (2, 1):
        path = tmp_path / f"test_order_{power}.py"
        path.write_text(f"{MY_STUDY.format(power=power)}\n\n{code}")
    command = [sys.executable, "-m", "pytest", "-p", "esfem.pytest_plugin", "-rA", str(tmp_path)]
    path = {"PYTHONPATH": str(ROOT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = subprocess.run(
        command, cwd=tmp_path, env={**os.environ, **path}, capture_output=True, text=True
    )
    outcomes = re.findall(r"^(PASSED|FAILED) .*test_order_(\d)\.py", done.stdout, re.MULTILINE)
    assert sorted(outcomes) == [("FAILED", "1"), ("PASSED", "2")], done.stdout


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


def test_the_web_pages_of_dask_in_the_readme_stay_on_the_machine():
    """Its default is every interface, by http, with `--no-dashboard` as well."""
    started = re.findall(r"^ +dask (?:scheduler|worker) .*", README, re.MULTILINE)
    assert len(started) == 2
    assert all(re.search(r" --dashboard-address 127\.0\.0\.1:\d+$", line) for line in started)


def test_every_link_of_the_readme_leads_to_a_file():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


def first_table(text: str) -> list[str]:
    """Its rows, with the line below the heads."""
    lines = text.partition("\n|")[2].partition("\n\n")[0]
    return f"|{lines}".splitlines()


def test_the_rates_of_the_judge_are_those_of_the_report():
    """The first table of the report that the program wrote, whole."""
    report = (ROOT / "results" / "judge" / "report.md").read_text(encoding="utf-8")
    section = README.partition("## Judge any table")[2].partition("\n## ")[0]
    assert len(first_table(report)) > 5
    assert first_table(section) == first_table(report)


def test_the_costs_of_the_schemes_are_those_that_were_measured():
    path = ROOT / "results" / "schemes" / "extra" / "schemes-cost.json"
    rows = json.loads(path.read_text(encoding="utf-8"))["table"]
    seconds = {row["scheme"]: row["CPU s a step"] for row in rows}
    bgn, dziuk = (round(seconds[name] / seconds["kll"]) for name in ("bgn", "dziuk"))
    said = " ".join(README.split())
    assert f"a step of `bgn` costs {bgn} and one of `dziuk` {dziuk} times that of `kll`" in said


def test_the_sentences_of_the_paper_are_counted_as_they_were_judged():
    lines = json.loads((ROOT / "results/paper/sentences.json").read_text(encoding="utf-8"))
    count = Counter(line["verdict"] for line in lines)
    idle = count["not exercised"]
    said = " ".join(README.split())
    assert (
        f"Of the {len(lines)} rows {count['pass'] + count['super']} hold here; "
        f"INCONCLUSIVE: {count['inconclusive']}, without a claim: {count['no claim']}, "
        f"FAIL: {count['fail']}{f', NOT EXERCISED: {idle}' if idle else ''}"
    ) in said


def test_what_is_said_of_the_reactions_was_measured():
    def measured(table: str) -> pd.DataFrame:
        return pd.read_csv(ROOT / f"results/bench/reactions-{table}.csv", comment="#", dtype=str)

    said = " ".join(README.split())
    factors = measured("rounding").set_index(["tau", "BDF"])
    for tau, reaction in product(("0.05", "0.01"), ("implicit", "linearised", "extrapolated")):
        cells = (factors[reaction].get((tau, q), "not measured") for q in "2345")
        assert f"| {tau} | {reaction} | {' | '.join(cells)} |" in said
    stable = measured("stable").set_index("surface")
    torus, ellipsoid, cell = stable["linearised"]
    assert (
        f"τ = {torus} on the Clifford torus, {ellipsoid} on the ellipsoid 2:1:1, {cell} on" in said
    )
    others = [f"{name} {', '.join(stable[name])}" for name in ("implicit", "extrapolated")]
    assert f"({'; '.join(others)}; P2, BDF1, V = 120)" in said
    costs = measured("steps").set_index(["N", "reaction"])["ms"]["15354"].astype(float).round()
    assert "{implicit:.0f} (implicit), {extrapolated:.0f} (extrapolated)".format(**costs) in said
    starts = (
        measured("starts").set_index(["flow", "first_steps", "reaction"])["error of W"].sort_index()
    )
    plain = [starts[flow, "1"].str.replace("e-0", "e-") for flow in ("red-blood-cell", "ellipsoid")]
    cell = "{linearised} linearised, {implicit} implicit and {extrapolated} extrapolated"
    assert f"{cell.format(**plain[0])} on the red blood cell" in said
    assert "{linearised}, {implicit} and {extrapolated} on the ellipsoid".format(**plain[1]) in said
    divided = [
        starts[flow, "4"].str.replace("e-0", "e-") for flow in ("red-blood-cell", "ellipsoid")
    ]
    assert divided[0]["linearised"] == divided[0]["implicit"]
    cell = "{linearised} linearised and implicit and {extrapolated} extrapolated on the cell"
    assert cell.format(**divided[0]) in said
    assert (
        "{linearised}, {implicit} and {extrapolated} on the ellipsoid".format(**divided[1]) in said
    )


def test_the_study_files_that_pages_name_are_there():
    pages = [README, *(page.read_text(encoding="utf-8") for page in (ROOT / "docs").glob("*.md"))]
    named = {name for page in pages for name in re.findall(r"harness/studies/[\w/-]+\.toml", page)}
    assert named
    assert [name for name in sorted(named) if not (ROOT / name).is_file()] == []
