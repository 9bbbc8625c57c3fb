"""``esfem check`` and ``esfem baseline``: what they print and write, and how they end."""

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest
from committed import RESULTS, by_this_program, whole
from junitparser import JUnitXml
from studies import write_study

from esfem.campaigns.baseline.baseline import names_below, read_history, read_stored
from esfem.campaigns.baseline.change import Change
from esfem.campaigns.baseline.check import write_junit
from esfem.common.bad_input import BadInput
from esfem.common.provenance import numerics_digest
from esfem.results.result_files import file_digest, own_digest
from esfem.results.run_studies import run_studies
from esfem.studies.catalogue import study_path
from esfem.studies.study import load_study

COMMITTED = RESULTS / "baseline"
WHY = "first baseline with intervals"


@pytest.fixture(scope="module")
def computed(tmp_path_factory):
    """The small study with its results."""
    folder = tmp_path_factory.mktemp("computed")
    run_studies([write_study(folder)], out=folder / "out", jobs=1)
    return folder


@pytest.fixture
def place(computed, tmp_path, esfem):
    """A copy of them, which is the baseline too."""
    folder = shutil.copytree(computed, tmp_path / "place")
    status, *_ = esfem("baseline", "--update", folder / "study.toml", "--why", WHY, *at(folder))
    assert status == 0
    return folder


def at(folder: Path) -> tuple[object, ...]:
    return ("--out", folder / "out", "--baseline", folder / "baseline")


def rewrite(folder: Path, change) -> None:
    """Results changed by ``change(content, records)``, with digests that are right."""
    path = folder / "verdicts.json"
    content, records = json.loads(path.read_text()), pd.read_csv(folder / "records.csv")
    change(content, records)
    records.to_csv(folder / "records.csv", index=False)
    content["files"]["records.csv"] = file_digest(folder / "records.csv")
    content["digest"] = own_digest(content)
    path.write_text(json.dumps(content))


def five_times_worse(content, records):
    records["err_x"] *= 5
    for verdict in content["verdicts"]:
        if verdict["variable"] == "x":
            verdict["parts"][0]["constant"] *= 5


def snapshot(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_results_that_are_the_baseline_are_unchanged(esfem, place):
    status, out, _ = esfem("check", "--read", *at(place))
    assert status == 0
    assert "small: unchanged; since 0." in out and WHY in out


def test_check_runs_what_is_not_stored(esfem, place):
    shutil.rmtree(place / "out")
    words = ("check", place / "study.toml", "--jobs", 1, *at(place))
    status, out, _ = esfem(*words)
    assert status == 0
    assert "runs done" in out and "small: unchanged" in out


def test_a_baseline_without_a_study_file_is_run_from_its_own_parameters(esfem, place):
    assert esfem("check", "small", "--jobs", 1, *at(place))[0] == 0


def test_a_five_times_worse_constant_fails_and_says_by_how_much(esfem, place):
    rewrite(place / "out" / "small", five_times_worse)
    status, out, _ = esfem("check", "--read", *at(place))
    assert status == 1
    rows = [line for line in out.splitlines() if line.startswith("worse")]
    assert any(" constant " in row and "times 5 (tolerance" in row for row in rows)
    assert not any(" order " in row for row in rows)


def test_better_results_fail_only_strictly(esfem, place):
    def better(content, records):
        records["err_x"] /= 3

    rewrite(place / "out" / "small", better)
    assert esfem("check", "--read", *at(place))[0] == 0
    assert esfem("check", "--read", "--strict", *at(place))[0] == 1


def test_results_of_other_numerics_are_not_comparable(esfem, place):
    rewrite(place / "out" / "small", lambda content, _: content.update(numerics="old"))
    status, out, _ = esfem("check", "--read", *at(place))
    assert status == 3
    assert "old" in out and "run without --read" in " ".join(out.split())


def test_missing_results_are_named_and_not_comparable(esfem, place):
    shutil.rmtree(place / "out")
    status, out, _ = esfem("check", "--read", *at(place))
    assert status == 3
    assert "small" in out and "results" in out


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("sphere",), "sphere: has no baseline below"),
        (("spher",), "spher: cannot be read: neither a file nor a committed study"),
    ],
)
def test_a_study_without_baseline_is_bad_input(esfem, place, words, named):
    status, _, err = esfem("check", *words, "--read", *at(place))
    assert status == 2
    assert named in err and len(err.splitlines()) == 1


def test_a_folder_without_baselines_is_bad_input(esfem, tmp_path):
    status, _, err = esfem("check", "--baseline", tmp_path)
    assert (status, len(err.splitlines())) == (2, 1)
    assert "holds no baseline" in err


DAMAGE = [
    ("verdicts.json", lambda text: text.replace('n": "h"', 'n": "tau"'), "was edited or damaged"),
    ("verdicts.json", lambda text: text.replace('n": "h"', 'n": "x"'), ".direction = 'x': "),
    (
        "verdicts.json",
        lambda text: text.replace('t": "inconclusive"', 't": "best"'),
        "verdict = 'best': ",
    ),
    ("verdicts.json", lambda text: text.replace('d": 2.0', 'd": "2"x'), "cannot be read"),
    ("records.csv", lambda text: text.replace("small", "large"), "was edited or damaged"),
    ("verdicts.json", lambda text: "{", "cannot be read"),
    ("history.json", lambda text: "[", "cannot be read"),
    ("history.json", lambda text: "{}", "should be a valid array"),
    ("history.json", lambda text: text.replace('"why"', '"how"'), "0.why: is missing"),
]


@pytest.mark.parametrize(("name", "damage", "named"), DAMAGE)
def test_a_damaged_baseline_is_one_line(esfem, place, name, damage, named):
    path = place / "baseline" / "small" / name
    path.write_text(damage(path.read_text()))
    status, _, err = esfem("check", "--read", *at(place))
    assert status == 2
    assert named in err and name in err and len(err.splitlines()) == 1


def test_a_baseline_moved_by_other_means_is_refused(esfem, place):
    rewrite(place / "baseline" / "small", five_times_worse)
    status, _, err = esfem("check", "--read", *at(place))
    assert status == 2
    assert "only `esfem baseline --update` moves it" in err


def test_results_of_an_older_version_are_refused(esfem, place):
    def older(content, _):
        for verdict in content["verdicts"]:
            del verdict["parts"][0]["lower"]

    rewrite(place / "out" / "small", older)
    status, _, err = esfem("check", "--read", *at(place))
    assert status == 2
    assert "lacks 'lower'" in err and len(err.splitlines()) == 1


def test_junit_counts_what_is_worse(esfem, place):
    rewrite(place / "out" / "small", five_times_worse)
    _, out, _ = esfem("check", "--read", "--junit", place / "ci" / "check.xml", *at(place))
    (suite,) = JUnitXml.fromfile(str(place / "ci" / "check.xml"))
    assert suite.name == "small"
    failed = {case.name for case in suite if case.result}
    assert failed == {"x: errors", "x: one error", "x: constant"}
    assert suite.failures == 3 and suite.errors == 0 and suite.tests > 20
    assert "3 worse, of" in out


def test_junit_tells_better_from_not_comparable(tmp_path):
    blank = Change("run", "<a> & b", "ok", "better", study="s", since="0.1.0")
    changes = {"s": [blank, Change("cell", "there", "none", study="s", since="0.1.0")]}
    for strict, failures in ((False, 0), (True, 1)):
        write_junit(tmp_path / "check.xml", changes, strict)
        (suite,) = JUnitXml.fromfile(str(tmp_path / "check.xml"))
        assert (suite.tests, suite.failures, suite.errors) == (2, failures, 1)


def test_junit_that_cannot_be_written_is_bad_input(esfem, place):
    (place / "file").touch()
    status, _, err = esfem("check", "--read", "--junit", place / "file" / "x.xml", *at(place))
    assert (status, len(err.splitlines())) == (2, 1)


def test_the_history_records_why_what_and_since_when(esfem, place):
    rewrite(place / "out" / "small", five_times_worse)
    update = ("baseline", "--update", place / "study.toml")
    assert esfem(*update, "--why", "five times worse, on purpose", *at(place))[0] == 0
    first, second = read_history(place / "baseline" / "small")
    assert (first.why, first.moved, first.previous) == (WHY, [], "no baseline before")
    assert second.why == "five times worse, on purpose"
    assert second.previous == first.numerics
    assert {(m["variable"], m["what"]) for m in second.moved} == {
        ("x", "errors"),
        ("x", "one error"),
        ("x", "constant"),
    }
    assert all(move["by"] == pytest.approx(5.0, rel=0.01) for move in second.moved)
    assert esfem("check", "--read", *at(place))[0] == 0
    status, out, _ = esfem("baseline", "--baseline", place / "baseline")
    assert status == 0 and WHY in out and "five times worse, on purpose" in out


def test_an_update_copies_whole_results_and_keeps_the_records_of_the_baseline(esfem, place):
    kept = place / "baseline" / "small" / "records" / "kept.json"
    kept.parent.mkdir()
    kept.touch()
    rewrite(place / "out" / "small", five_times_worse)
    esfem("baseline", "--update", place / "study.toml", "--why", WHY, *at(place))
    assert kept.exists()
    assert [p.name for p in (place / "baseline").iterdir()] == ["small"]
    source, target = (snapshot(place / name / "small") for name in ("out", "baseline"))
    names = set(read_stored(place / "out" / "small").content.files) | {"verdicts.json"}
    assert {name: source[name] for name in names} == {name: target[name] for name in names}


def test_an_update_that_moves_nothing_records_nothing(esfem, place):
    before = snapshot(place / "baseline")
    status, out, _ = esfem("baseline", "--update", place / "study.toml", "--why", WHY, *at(place))
    assert status == 0 and "nothing recorded" in out
    assert snapshot(place / "baseline") == before


REFUSALS = [
    (("--why", ""), "tell the reason"),
    (("--why", "just so"), "tell the reason"),
    (("--why", "two lines\nof reasons here"), "tell the reason"),
    (("sphere", "--why", WHY), "holds no results; run `esfem run sphere"),
    (("spher", "--why", WHY), "neither a file nor a committed study"),
]


@pytest.mark.parametrize(("words", "named"), REFUSALS)
def test_a_refused_update_leaves_the_baseline(esfem, place, words, named):
    rewrite(place / "out" / "small", five_times_worse)
    before = snapshot(place / "baseline")
    status, _, err = esfem("baseline", "--update", place / "study.toml", *words, *at(place))
    assert status == 2
    assert named in err and len(err.splitlines()) == 1
    assert snapshot(place / "baseline") == before


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda content, _: content.update(numerics="old"), "computed by numerics old"),
        (
            lambda content, _: content["parameters"]["study"].update(title="another"),
            "not the results of the study as it is now",
        ),
    ],
)
def test_results_that_are_not_current_are_no_baseline(esfem, place, change, named):
    rewrite(place / "out" / "small", change)
    before = snapshot(place / "baseline")
    status, _, err = esfem("baseline", "--update", place / "study.toml", "--why", WHY, *at(place))
    assert status == 2
    assert named in err and "first" in err
    assert snapshot(place / "baseline") == before


def test_a_damaged_plot_is_no_baseline(esfem, place):
    (place / "out" / "small" / "errors.svg").write_text("")
    status, _, err = esfem("baseline", "--update", place / "study.toml", "--why", WHY, *at(place))
    assert status == 2 and "errors.svg: was edited or damaged" in err


def test_a_damaged_baseline_may_be_replaced(esfem, place):
    (place / "baseline" / "small" / "verdicts.json").write_text("{")
    words = ("baseline", "--update", place / "study.toml", "--why", "the disk was full")
    assert esfem(*words, *at(place))[0] == 0
    last = read_history(place / "baseline" / "small")[-1]
    assert last.previous.startswith("not comparable: small/verdicts.json: cannot be read")
    assert esfem("check", "--read", *at(place))[0] == 0


def test_a_disk_that_fails_in_between_leaves_the_baseline(esfem, place, monkeypatch):
    rewrite(place / "out" / "small", five_times_worse)
    before = snapshot(place / "baseline")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("esfem.campaigns.baseline.baseline.write_json", full)
    status, _, err = esfem("baseline", "--update", place / "study.toml", "--why", WHY, *at(place))
    assert status == 2 and "No space left on device" in err
    assert snapshot(place / "baseline") == before


def test_run_does_not_move_a_baseline(esfem, place):
    status, _, err = esfem("run", place / "study.toml", "--out", place / "baseline")
    assert status == 2 and "`esfem baseline --update` alone moves" in err


def test_what_lies_in_the_baseline_already_gets_its_first_entry_once(esfem, computed, tmp_path):
    folder = shutil.copytree(computed, tmp_path / "place")
    words = ("baseline", "--update", folder / "study.toml", "--why", WHY)
    both = ("--out", folder / "out", "--baseline", folder / "out")
    assert esfem(*words, *both)[0] == 0
    assert read_history(folder / "out" / "small")[0].previous == "written in place"
    assert esfem(*words, *both)[0] == 2


@pytest.mark.parametrize("name", names_below(COMMITTED))
def test_every_committed_baseline_is_whole_and_says_why(name):
    """A new one is made by `esfem baseline --update`; one of an older program may say what this one
    does not read any more."""
    content, history = whole(COMMITTED / name), read_history(COMMITTED / name)
    assert content["study"] == name
    assert history[-1].digest == content["digest"]
    try:
        assert read_stored(COMMITTED / name).study == name
        assert load_study(study_path(name)).name == name
    except BadInput:
        made, remedy = content["numerics"], f"esfem baseline --update {name}"
        if by_this_program(f"results/baseline/{name}", made, numerics_digest(), remedy):
            raise
