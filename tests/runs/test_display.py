"""The progress of a sweep: bars, lines, the time that is left."""

from dataclasses import replace

import pytest
from rich.console import Console
from rich.text import Text
from studies import small_study

from esfem.meshes import meshes_of
from esfem.runs.display import Monitor, clock
from esfem.runs.store import cells_of
from esfem.studies.study import load_study


@pytest.fixture
def cells(tmp_path):
    study = load_study(small_study(tmp_path, vertices=[30, 60, 120, 240]))
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
