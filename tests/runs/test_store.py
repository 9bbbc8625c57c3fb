"""Records on disk: atomic, keyed by content, checked on reading."""

import json

import pytest
from studies import write_study

from esfem.meshes import surface_mesh
from esfem.runs import store
from esfem.runs.run_case import run_case
from esfem.studies.study import load_study


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    return load_study(write_study(tmp_path_factory.mktemp("study"))).cases()[0]


@pytest.fixture(scope="module")
def record(case):
    return run_case(case, surface_mesh("sphere", 30))[0]


def complaints_on_reading(folder) -> tuple[object, list[str]]:
    lines: list[str] = []
    return store.read_record(folder, "key", lines.append), lines


def test_what_is_written_is_read(tmp_path, record):
    store.write_record(tmp_path, "key", record)
    assert complaints_on_reading(tmp_path) == (record, [])


def test_an_absent_record_is_none_without_complaint(tmp_path):
    assert complaints_on_reading(tmp_path) == (None, [])


@pytest.mark.parametrize("fraction", [0.0, 0.3, 0.99])
def test_a_truncated_record_is_reported_and_set_aside(tmp_path, record, fraction):
    store.write_record(tmp_path, "key", record)
    path = store.record_path(tmp_path, "key")
    text = path.read_text()
    path.write_text(text[: int(fraction * len(text))])
    found, lines = complaints_on_reading(tmp_path)
    assert found is None
    assert "damaged" in lines[0] and "key.json" in lines[0]
    assert not path.exists() and path.with_suffix(".json.damaged").exists()


def test_a_hand_edited_record_is_reported_and_set_aside(tmp_path, record):
    store.write_record(tmp_path, "key", record)
    path = store.record_path(tmp_path, "key")
    content = json.loads(path.read_text())
    content["record"]["l2"]["x"][0] *= 0.5
    path.write_text(json.dumps(content))
    found, lines = complaints_on_reading(tmp_path)
    assert found is None
    assert "does not match its digest" in lines[0]


@pytest.mark.parametrize("text", ["[]", "null", '{"digest": 1}', "\x00"])
def test_a_file_that_is_no_record_is_set_aside(tmp_path, text):
    path = store.record_path(tmp_path, "key")
    path.parent.mkdir()
    path.write_text(text)
    found, lines = complaints_on_reading(tmp_path)
    assert found is None and len(lines) == 1


@pytest.mark.parametrize(
    "change",
    [
        {"tau": 0.0625},
        {"vertices": 60},
        {"final_time": 1.0},
        {"scheme": {"theta": True}},
        {"scheme": {"tolerance": 1e-8}},
    ],
)
def test_the_key_changes_with_the_case(case, change):
    scheme = case.scheme.model_copy(update=change.get("scheme", {}))
    other = case.model_copy(update={**change, "scheme": scheme})
    assert store.key(other, "mesh") != store.key(case, "mesh")


def test_the_key_changes_with_the_mesh(case):
    assert store.key(case, "one") != store.key(case, "other")


def test_the_key_changes_with_the_numerics(case, monkeypatch):
    before = store.key(case, "mesh")
    monkeypatch.setattr(store, "numerics_digest", lambda: "other")
    assert store.key(case, "mesh") != before


def test_writing_leaves_no_temporary_file(tmp_path):
    store.write_text(tmp_path / "deep" / "file.txt", "text")
    assert [p.name for p in (tmp_path / "deep").iterdir()] == ["file.txt"]


def test_a_failed_write_keeps_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "file.txt"
    store.write_text(path, "old")
    monkeypatch.setattr(store.os, "fsync", lambda fd: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        store.write_text(path, "new")
    assert path.read_text() == "old"
