"""The command line: what it prints, and its exit status."""

import errno
import io
import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
import trimesh
from rich.console import Console
from rich.text import Text
from studies import write_study

from esfem.common.bad_input import BadInput
from esfem.meshes import SurfaceMesh, meshes_of
from esfem.results.result_files import judged_afresh, load_result, own_digest
from esfem.results.run_studies import run_studies
from esfem.results.tables import latex
from esfem.runs.display import Monitor, clock
from esfem.runs.executors import WorkerLost
from esfem.runs.store import cells_of
from esfem.studies.catalogue import full_studies, study_path
from esfem.studies.claims import claims
from esfem.studies.study import load_study


@pytest.fixture
def printed(esfem):
    """The command line: its status and standard output."""
    return lambda *words: esfem(*words)[:2]


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Results of the small study, under a title that is odd to TeX, mathtext and rich."""
    folder = tmp_path_factory.mktemp("stored [b]")
    title = ('title = "A small study"', "title = '$x_{$ 50% of R_0 & more [b] :warning:'")
    return run_studies([write_study(folder, title)], out=folder / "out", jobs=1)[0].folder


def test_list_names_studies_solutions_laws_claims_and_meshes(printed):
    status, out = printed("list")
    assert status == 0
    for word in ("sphere-unprojected", "clifford_torus", "willmore", "theorem", "3840"):
        assert word in out


def test_a_study_whose_claims_hold_exits_with_0_and_shows_rates_and_verdicts(printed, tmp_path):
    status, out = printed("run", write_study(tmp_path), "--out", tmp_path / "out", "--jobs", 1)
    assert status == 0
    assert "EOC" in out and "V=240" in out
    assert "SUPER" in out


def test_table_shows_what_run_showed(printed, tmp_path):
    _, ran = printed("run", write_study(tmp_path), "--out", tmp_path / "out", "--jobs", 1)
    status, shown = printed("table", tmp_path / "out" / "small")
    assert status == 0
    start = ran.index("A small study")
    assert (
        shown[shown.index("A small study") :].split("files:")[0] == ran[start:].split("files:")[0]
    )


def test_a_failed_claim_exits_with_1(printed, tmp_path, monkeypatch):
    ambitious = claims()["section-7"].model_copy(update={"order": 6.0})
    monkeypatch.setattr("esfem.studies.study.claims", lambda: {"section-7": ambitious})
    status, out = printed("run", write_study(tmp_path), "--out", tmp_path / "out", "--jobs", 1)
    assert status == 1
    assert "FAIL" in out


def test_an_inconclusive_study_exits_with_3(printed, tmp_path):
    study = write_study(tmp_path, ("vertices = [30, 60, 120, 240, 480]", "vertices = [30, 60]"))
    status, out = printed("run", study, "--out", tmp_path / "out", "--jobs", 1)
    assert status == 3
    assert "INCONCLUSIVE" in out


def test_a_study_without_a_claim_runs_and_says_so(printed, tmp_path):
    study = write_study(tmp_path, ('claim = "section-7"\n', ""))
    status, out = printed("run", study, "--out", tmp_path / "out", "--jobs", 1)
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


@pytest.mark.parametrize("ending", [".npz", ".ply", ".stl", ".PLY", ".NPZ"])
def test_mesh_writes_a_closed_surface_of_the_asked_size(printed, tmp_path, ending):
    path = tmp_path / f"mesh{ending}"
    status, out = printed("mesh", "sphere", "--vertices", 60, "--out", path)
    assert status == 0 and "radius ratio" in out
    if ending.lower() == ".npz":
        assert len(SurfaceMesh.load(path).vertices) == 60
    else:
        mesh = trimesh.load(path)
        assert mesh.is_watertight and len(mesh.vertices) == 60


@pytest.fixture
def cells(tmp_path):
    four_meshes = ("vertices = [30, 60, 120, 240, 480]", "vertices = [30, 60, 120, 240]")
    study = load_study(write_study(tmp_path, four_meshes))
    meshes = meshes_of("sphere", study.sweep.vertices, tmp_path / "meshes", print)
    return [c for c in cells_of(study, tmp_path / "small", meshes) if c.floor is None]


def runs_to(cell, fraction: float) -> None:
    """As if the cell ran, and had done that fraction."""
    cell.progress_path.parent.mkdir(parents=True, exist_ok=True)
    cell.progress_path.write_text(str(fraction))


def test_bars_show_what_runs_how_far_all_is_and_what_went_wrong(cells):
    console = Console(width=120, force_terminal=True)
    monitor = Monitor(cells, 2, console)
    with console.capture() as capture:
        monitor.done(cells[0], "ok")
        monitor.done(cells[1], "diverged", 1.0)
        runs_to(cells[2], 0.42)
        console.print(monitor.get_renderable())
    text = Text.from_ansi(capture.get()).plain
    line, *bars = text.splitlines()
    assert "small V=30 tau=0.125: diverged, 1.0 s" in line
    assert len(bars) == 2
    assert "2 of 8 runs done" in bars[0]
    assert "42%" in bars[1] and bars[1].rstrip().endswith("small V=60 tau=0.25")


def test_the_bar_of_all_is_by_weights(cells):
    monitor = Monitor(cells, 2, Console(force_terminal=True))
    for cell in cells[:-1]:
        monitor.done(cell, "ok")
    runs_to(cells[-1], 0.5)
    monitor._look()
    (total, *_) = monitor.tasks
    whole = sum(cell.weight for cell in cells)
    assert total.completed == pytest.approx(whole - 0.5 * cells[-1].weight)
    assert total.total == pytest.approx(whole)


def test_plain_lines_tell_count_case_and_status(cells):
    console = Console(width=200)
    with console.capture() as capture, Monitor(cells, 2, console) as monitor:
        monitor.done(cells[3], "ok", 1.25)
        monitor.done(cells[2], "ok")
    (line,) = capture.get().splitlines()
    assert line.startswith("[1 of 8 runs done, 0:00 gone, about ")
    assert line.endswith(" left] small V=60 tau=0.125: ok, 1.2 s")


def test_a_finer_mesh_more_steps_and_a_higher_degree_weigh_more(cells):
    coarse, *_, fine = cells
    assert fine.case.steps == 2 * coarse.case.steps
    assert fine.weight / coarse.weight == pytest.approx(2.0 * 8.0**1.1)
    scheme = coarse.case.scheme.model_copy(update={"degree": 2 * coarse.case.scheme.degree})
    higher = replace(coarse, case=coarse.case.model_copy(update={"scheme": scheme}))
    assert higher.weight / coarse.weight == pytest.approx(4.0**1.1)


def seen(cells, workers: int) -> Monitor:
    """A monitor of a sweep that takes a second for each weight of the first cell."""
    monitor = Monitor(cells, workers, Console(quiet=True))
    monitor.done(cells[0], "ok", cells[0].weight)
    return monitor


def test_the_time_left_is_that_of_all_workers_or_of_the_longest_run(cells):
    rest = [cell.weight for cell in cells[1:]]
    assert seen(cells, 1).left({}) == pytest.approx(sum(rest))
    assert seen(cells, 2).left({}) == pytest.approx(sum(rest) / 2)
    assert seen(cells, 100).left({}) == pytest.approx(max(rest))


def test_the_time_left_knows_what_is_done_and_how_fast(cells):
    monitor, last = seen(cells, 1), cells[-1]
    rest = sum(cell.weight for cell in cells[1:])
    assert monitor.left({last: 0.5}) == pytest.approx(rest - 0.5 * last.weight, rel=0.01)
    monitor.done(cells[1], "ok")  # by another sweep
    rest -= cells[1].weight
    assert monitor.left({}) == pytest.approx(rest)
    monitor.done(last, "ok", 2.0 * last.weight)  # half as fast
    pace = (cells[0].weight + 2.0 * last.weight) / (cells[0].weight + last.weight)
    assert monitor.left({}) == pytest.approx(pace * (rest - last.weight))


def test_a_run_that_stopped_early_tells_nothing_of_the_speed(cells):
    monitor = seen(cells, 1)
    monitor.done(cells[-1], "diverged", 0.1)
    assert monitor.left({}) == pytest.approx(sum(cell.weight for cell in cells[1:-1]))


def test_before_a_run_is_done_those_that_run_tell_the_speed(cells, monkeypatch):
    clock = iter([0.0, 10.0, 30.0, 40.0])
    monkeypatch.setattr("esfem.runs.display.monotonic", lambda: next(clock))
    monitor = Monitor(cells[-1:], 1, Console(quiet=True))
    assert monitor.left({}) is None
    assert monitor.left({cells[-1]: 0.5}) is None  # resumed there, by what can be seen
    assert monitor.left({cells[-1]: 0.75}) == pytest.approx(10.0)


def test_where_all_is_done_no_time_is_left(cells):
    monitor = seen(cells[:1], 1)
    assert monitor.left({}) is None
    assert monitor.headline({}) == "1 of 1 runs done, 0:00 gone"


def test_clock_counts_minutes_and_seconds():
    assert [clock(s) for s in (0, 59.9, 61, 3600)] == ["0:00", "0:59", "1:01", "60:00"]


def test_table_shows_the_stored_verdicts_and_judges_afresh_when_asked(printed, stored, tmp_path):
    folder = shutil.copytree(stored, tmp_path / "small")
    content = json.loads((folder / "verdicts.json").read_text())
    content["verdicts"][0] |= {"verdict": "fail", "observed": 0.123}
    content["digest"] = own_digest(content)
    (folder / "verdicts.json").write_text(json.dumps(content))
    (_, as_stored), (_, afresh) = printed("table", folder), printed("table", folder, "--judge")
    assert "FAIL" in as_stored and "0.12" in as_stored
    assert "FAIL" not in afresh
    original = printed("table", stored)[1].splitlines()
    assert [line for line in afresh.splitlines() if "files:" not in line] == [
        line for line in original if "files:" not in line
    ]


def test_records_that_cannot_be_judged_are_refused(stored, monkeypatch):
    def odd(*_):
        raise KeyError("err_x")

    monkeypatch.setattr("esfem.results.study_result.judge", odd)
    with pytest.raises(BadInput, match="records cannot be judged: KeyError"):
        judged_afresh(load_result(stored))


def test_titles_and_paths_are_shown_as_they_are(printed, stored):
    status, out = printed("table", stored)
    assert status == 0
    assert "$x_{$ 50% of R_0 & more [b] :warning:" in out
    assert f"files: {stored}" in out


def test_a_title_is_text_to_tex(stored):
    text = (stored / "table.tex").read_text()
    assert r"\$x\_\{\$ 50\% of R\_0 \& more [b] :warning:" in text


def test_no_line_of_a_title_escapes_the_comment(stored):
    result = load_result(stored)
    title = result.study.study.model_copy(update={"title": "one\n\\two\u2028three"})
    text = latex(replace(result, study=result.study.model_copy(update={"study": title})))
    assert text.splitlines()[1].startswith(r"% one \two three: ")


def test_a_title_is_no_formula_to_plots(stored):
    text = (stored / "energy.svg").read_text()
    assert "$x_{$ 50% of R_0 &amp; more" in text


def test_table_refuses_edited_records_and_tells_the_way_out(printed, stored, tmp_path):
    folder = shutil.copytree(stored, tmp_path / "small")
    text = (folder / "records.csv").read_text()
    (folder / "records.csv").write_text(text.replace(",120,", ",121,"))
    with pytest.raises(BadInput, match=r"records\.csv: was edited.*`esfem run` writes it anew"):
        load_result(folder)
    status, _ = printed("table", folder)
    assert status == 2


def test_bad_parameters_are_one_line(stored, tmp_path):
    folder = shutil.copytree(stored, tmp_path / "small")
    text = (folder / "verdicts.json").read_text()
    (folder / "verdicts.json").write_text(text.replace('"degree": 2', '"degree": 7'))
    with pytest.raises(BadInput, match=r"parameters\.scheme: .*degree = 7") as refusal:
        load_result(folder)
    assert len(str(refusal.value).splitlines()) == 1


def test_a_terminal_of_ascii_shows_question_marks(printed, stored, monkeypatch):
    terminal = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr("sys.stdout", terminal)
    status, _ = printed("table", stored)
    terminal.flush()
    assert status == 0
    assert b"EOC" in terminal.buffer.getvalue()


def test_the_help_of_run_names_the_folder_of_results(printed):
    assert "OUT/STUDY" in printed("run", "--help")[1]


def test_a_name_that_is_no_study_lists_those_there_are():
    with pytest.raises(BadInput, match=r"spher: .* clifford, .*helfrich-bdf3"):
        study_path("spher")


def test_a_folder_does_not_shadow_a_committed_study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("sphere").mkdir()
    assert study_path("sphere").name == "sphere.toml"
    Path("clifford").touch()
    assert study_path("clifford") == Path("clifford")


def test_a_name_too_long_is_refused():
    with pytest.raises(BadInput, match="cannot be read"):
        study_path("s" * 300)


def test_a_full_study_is_accepted_by_name():
    assert study_path("helfrich-bdf3") in full_studies()


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


def test_the_summary_tells_which_runs_were_judged(printed, tmp_path):
    _, out = printed("run", write_study(tmp_path), "--out", tmp_path / "out", "--jobs", 1)
    assert "small: 3 super, 3 no claim (judged at tau = 0.125, V = 30..480)" in out


def test_a_mesh_that_cannot_be_written_leaves_the_old_one(printed, tmp_path, monkeypatch):
    path = tmp_path / "mesh.ply"
    path.write_text("old")

    def full(mesh, file, file_type):
        file.write_text("half")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("trimesh.Trimesh.export", full)
    assert printed("mesh", "sphere", "--vertices", 60, "--out", path)[0] == 2
    assert [p.name for p in tmp_path.iterdir()] == ["mesh.ply"]
    assert path.read_text() == "old"
