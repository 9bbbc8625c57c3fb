"""``esfem run`` and ``esfem list``: what they print, and their exit statuses."""

import errno
import re
import shutil

import pytest
from studies import small_study, write_study

from esfem.results.run_studies import run_studies
from esfem.runs.executors import WorkerLost
from esfem.studies.claims import claims


@pytest.fixture
def printed(esfem):
    """The command line: its status and standard output."""
    return lambda *words: esfem(*words)[:2]


def test_list_names_studies_solutions_laws_claims_and_meshes(printed):
    status, out = printed("list")
    assert status == 0
    for word in ("sphere-unprojected", "clifford_torus", "willmore", "theorem", "3840"):
        assert word in out


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """The small study with its results: a folder for copies, in which nothing is computed again."""
    folder = tmp_path_factory.mktemp("ran")
    run_studies([write_study(folder)], out=folder / "out", jobs=1)
    return folder / "out"


@pytest.fixture
def run_small(printed, stored, tmp_path):
    """`esfem run` on the small study with these changes, its runs being stored."""
    out = shutil.copytree(stored, tmp_path / "out")

    def run(**changes):
        return printed("run", small_study(tmp_path, **changes), "--out", out, "--jobs", 1)

    return run


def test_a_study_whose_claims_hold_exits_with_0_and_shows_rates_and_verdicts(printed, tmp_path):
    study = small_study(tmp_path, project=False, tau=[0.125, 0.0625])
    status, out = printed("run", study, "--out", tmp_path / "out", "--jobs", 1)
    assert status == 0
    assert "EOC" in out and "V=240" in out
    assert "SUPER" in out and "it measures the interpolation alone" in out
    assert re.search(r"SUPER +small: .*\b3 no claim.* \(judged at tau = 0.0625, V = 30..480\)", out)


def test_table_shows_what_run_showed(run_small, printed, tmp_path):
    _, ran = run_small()
    status, shown = printed("table", tmp_path / "out" / "small")
    assert status == 0
    start = "A small study"
    assert start + shown.partition(start)[2].split("files:")[0] in ran


def test_a_failed_claim_exits_with_1(run_small, monkeypatch):
    ambitious = claims()["section-7"].model_copy(update={"order": 6.0})
    monkeypatch.setattr("esfem.studies.study.claims", lambda: {"section-7": ambitious})
    status, out = run_small()
    assert status == 1
    assert "FAIL" in out


def test_an_inconclusive_study_exits_with_3(run_small):
    status, out = run_small(vertices=[30, 60])
    assert status == 3
    assert "INCONCLUSIVE" in out


def test_a_study_without_a_claim_runs_and_says_so(run_small):
    status, out = run_small(claim=None)
    assert status == 0
    assert "NO CLAIM" in out and "PASS" not in out


def test_an_interrupted_run_says_that_it_can_go_on(printed, tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("esfem.runs.sweep.computed", interrupt)
    status, _ = printed("run", write_study(tmp_path), "--out", tmp_path / "out")
    assert status == 130


def test_a_killed_worker_has_an_exit_status_of_its_own(printed, tmp_path, monkeypatch):
    def lose(*_):
        raise WorkerLost("a worker process was killed; not finished: small V=30 tau=0.25")

    monkeypatch.setattr("esfem.runs.sweep.computed", lose)
    status, _ = printed("run", write_study(tmp_path), "--out", tmp_path / "out")
    assert status == 4


def test_the_help_of_run_names_the_folder_of_results(printed):
    assert "OUT/STUDY" in printed("run", "--help")[1]


def test_all_runs_the_full_studies_too(printed, monkeypatch):
    asked = []

    def record(paths, *_, **__):
        asked.extend(path.stem for path in paths)
        raise KeyboardInterrupt

    monkeypatch.setattr("esfem.results.run_studies.run_studies", record)
    printed("run")
    assert "sphere" in asked and "helfrich-bdf3" not in asked
    asked.clear()
    printed("run", "--all")
    assert "sphere" in asked and "helfrich-bdf3" in asked


def test_all_takes_no_names(printed):
    assert printed("run", "--all", "sphere")[0] == 2


def test_list_shows_the_further_studies(printed):
    _, out = printed("list")
    assert out.index("further studies (esfem run --all)") < out.index("helfrich-bdf3")
    assert out.index("named schemes/NAME (esfem schemes)") < out.index("clifford-bgn")


def test_a_full_disk_is_one_line_that_names_the_path(monkeypatch, esfem):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device", "out/small/table.md")

    monkeypatch.setattr("esfem.results.run_studies.run_studies", full)
    status, _, err = esfem("run")
    assert status == 2
    assert err == "esfem: out/small/table.md: cannot be written: No space left on device\n"
