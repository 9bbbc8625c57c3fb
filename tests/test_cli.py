"""The command line: what it prints, and its exit status."""

import sys

import pytest
import trimesh
from rich.console import Console
from studies import write_study

from harness.api import meshes_of
from harness.claims import claims
from harness.cli import main
from harness.display import LiveGrid, PlainLines, Tally, clock
from harness.meshing import SurfaceMesh
from harness.study import load_study
from harness.sweep import cells_of


@pytest.fixture
def esfem(monkeypatch, capsys):
    def run(*words: object) -> tuple[int, str]:
        monkeypatch.setattr(sys, "argv", ["esfem", *map(str, words)])
        with pytest.raises(SystemExit) as stop:
            main()
        return stop.value.code or 0, capsys.readouterr().out

    return run


@pytest.mark.parametrize("command", [[], ["run"], ["list"], ["table"], ["mesh"]])
def test_every_help_has_an_example(esfem, command):
    status, out = esfem(*command, "--help")
    assert status == 0
    assert "Example" in out and "esfem" in out


def test_list_names_studies_solutions_laws_claims_and_meshes(esfem):
    status, out = esfem("list")
    assert status == 0
    for word in ("sphere-unprojected", "clifford_torus", "willmore", "theorem", "3840"):
        assert word in out


def test_a_study_whose_claims_hold_exits_with_0_and_shows_rates_and_verdicts(esfem, tmp_path):
    status, out = esfem("run", write_study(tmp_path), "--out", tmp_path / "out", "--jobs", 1)
    assert status == 0
    assert "EOC" in out and "V=240" in out
    assert "PASS" in out


def test_table_shows_what_run_showed(esfem, tmp_path):
    _, ran = esfem("run", write_study(tmp_path), "--out", tmp_path / "out", "--jobs", 1)
    status, shown = esfem("table", tmp_path / "out" / "small")
    assert status == 0
    start = ran.index("A small study")
    assert (
        shown[shown.index("A small study") :].split("files:")[0] == ran[start:].split("files:")[0]
    )


def test_a_failed_claim_exits_with_1(esfem, tmp_path, monkeypatch):
    ambitious = claims()["section-7"].model_copy(update={"order": 6.0})
    monkeypatch.setattr("harness.verdicts.claims", lambda: {"section-7": ambitious})
    status, out = esfem("run", write_study(tmp_path), "--out", tmp_path / "out", "--jobs", 1)
    assert status == 1
    assert "FAIL" in out


def test_an_inconclusive_study_exits_with_3(esfem, tmp_path):
    study = write_study(tmp_path, ("vertices = [30, 60, 120, 240]", "vertices = [30, 60]"))
    status, out = esfem("run", study, "--out", tmp_path / "out", "--jobs", 1)
    assert status == 3
    assert "INCONCLUSIVE" in out


def test_a_study_without_a_claim_runs_and_says_so(esfem, tmp_path):
    study = write_study(tmp_path, ('claim = "section-7"\n', ""))
    status, out = esfem("run", study, "--out", tmp_path / "out", "--jobs", 1)
    assert status == 0
    assert "NO CLAIM" in out and "PASS" not in out


def test_an_interrupted_run_says_that_it_can_go_on(esfem, tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("harness.api.sweep", interrupt)
    status, _ = esfem("run", write_study(tmp_path), "--out", tmp_path / "out")
    assert status == 130


@pytest.mark.parametrize("ending", [".npz", ".ply", ".stl"])
def test_mesh_writes_a_closed_surface_of_the_asked_size(esfem, tmp_path, ending):
    path = tmp_path / f"mesh{ending}"
    status, out = esfem("mesh", "sphere", "--vertices", 60, "--out", path)
    assert status == 0 and "radius ratio" in out
    if ending == ".npz":
        assert len(SurfaceMesh.load(path).vertices) == 60
    else:
        mesh = trimesh.load(path)
        assert mesh.is_watertight and len(mesh.vertices) == 60


@pytest.fixture
def cells(tmp_path):
    study = load_study(write_study(tmp_path))
    meshes = meshes_of(study, tmp_path / "meshes", Console(quiet=True))
    return cells_of(study, tmp_path / "small", meshes)


def test_the_grid_shows_waiting_running_done_diverged_and_the_remaining_time(cells):
    console = Console(width=100, record=True, quiet=False, force_terminal=False, file=None)
    grid = LiveGrid(cells, console)
    grid.found(cells[0], "ok")
    grid.finished(cells[1], "diverged", 1.0)
    cells[2].progress_path.parent.mkdir(parents=True)
    cells[2].progress_path.write_text("0.42")
    with console.capture() as capture:
        console.print(grid._draw())
    text = capture.get()
    for word in ("done", "diverged", "42 %", "waiting", "2 of 8 runs done", "0.125"):
        assert word in text


def test_plain_lines_tell_count_case_and_status(cells):
    console = Console(width=200)
    with console.capture() as capture, PlainLines(cells, console) as lines:
        lines.finished(cells[3], "ok", 1.25)
    assert "1 of 8 runs done" in capture.get()
    assert "small V=60 tau=0.125: ok, 1.2 s" in capture.get()


def test_the_remaining_time_is_proportional_to_the_remaining_cost(cells, monkeypatch):
    now = [0.0]
    monkeypatch.setattr("harness.display.monotonic", lambda: now[0])
    tally = Tally(cells)
    now[0] = 30.0
    assert tally.remaining({}) is None
    tally.finished(cells[-1], "ok")
    rest = sum(cell.cost for cell in cells[:-1])
    assert tally.remaining({}) == pytest.approx(30.0 * rest / cells[-1].cost)


def test_clock_counts_minutes_and_seconds():
    assert [clock(s) for s in (0, 59.9, 61, 3600)] == ["0:00", "0:59", "1:01", "60:00"]
