"""Files: bad ones are one line, whole ones are whole, and numbers come back as they were."""

import errno
import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from stored import recast, scattered, stored

from esfem.common.bad_input import BadInput
from esfem.common.files import read_json, reading, whole, write_json, write_text, writing
from esfem.judging import Masked
from esfem.results.result_files import StoredResult


@dataclass(frozen=True)
class Point:
    name: str
    place: tuple[float, ...]


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "file.json"


class TestReading:
    @pytest.mark.parametrize(
        ("content", "told"),
        [
            (b"", "cannot be read: Invalid JSON: EOF"),
            (b"\xff", "cannot be read: is not UTF-8 text: invalid start byte at byte 0"),
            (b"[1]", "cannot be read: Input should be an object"),
            (b'{"name": "a"}', "place: is missing"),
            (b'{"name": "a", "place": [1, "b"]}', "place.1 = 'b': Input should be a valid number"),
            (b"[" * 100_000, "cannot be read: Invalid JSON: recursion limit"),
        ],
    )
    def test_bad_content_is_told_by_key_value_and_what_is_allowed(self, path, content, told):
        path.write_bytes(content)
        with pytest.raises(BadInput) as refusal:
            read_json(path, Point, "make it anew")
        line = str(refusal.value)
        assert line.startswith(f"{path}: {told}") and line.endswith("; make it anew")
        assert len(line.splitlines()) == 1

    def test_a_long_value_is_cut(self, path):
        write_json(path, {"name": "a", "place": "x" * 5000})
        with pytest.raises(BadInput) as refusal:
            read_json(path, Point)
        assert len(str(refusal.value)) < len(str(path)) + 200

    def test_what_is_not_there_is_named_with_its_reason(self, path):
        with pytest.raises(BadInput) as refusal, reading(path):
            path.read_text()
        assert str(refusal.value) == f"{path}: cannot be read: No such file or directory"

    def test_bad_input_passes_as_it_is(self, path):
        with pytest.raises(BadInput, match=r"^n = 0: must be positive$"), reading(path):
            raise BadInput("n = 0: must be positive")


class TestWriting:
    def test_what_cannot_be_written_is_named_with_its_reason(self, path):
        with pytest.raises(BadInput) as refusal, writing(f"--out {path}"):
            path.parent.write_text("")
        assert str(refusal.value) == f"--out {path}: cannot be written: Is a directory"

    def test_a_writer_that_fails_leaves_the_old_file_and_nothing_else(self, path):
        write_text(path, "old")
        with pytest.raises(OSError, match="full"), whole(path) as unfinished:
            unfinished.write_text("half")
            raise OSError(errno.ENOSPC, "full")
        assert path.read_text() == "old"
        assert list(path.parent.iterdir()) == [path]

    def test_a_reader_sees_the_old_file_until_the_new_one_is_whole(self, path):
        write_text(path, "old")
        with whole(path) as unfinished:
            unfinished.write_text("new")
            assert path.read_text() == "old"
        assert path.read_text() == "new"
        assert list(path.parent.iterdir()) == [path]


class TestNumbers:
    def test_those_that_are_not_finite_are_null(self, path):
        write_json(path, {"x": Point("a", (1.5, np.nan, np.inf)), "y": np.float64(0.1)})
        assert json.loads(path.read_text()) == {
            "x": {"name": "a", "place": [1.5, None, None]},
            "y": 0.1,
        }

    def test_verdicts_come_back_to_the_last_bit_and_with_their_nan(self, path):
        content = stored(scattered(0.01, 0)).content
        masked = (Masked(h=0.1, tau=float("nan"), reason="near a floor", floor="rounding"),)
        verdict = recast(content.verdicts[0], masked=masked, observed=float("nan"))
        write_json(path, replace(content, verdicts=[verdict]))
        found = read_json(path, StoredResult)
        assert np.isnan(found.verdicts[0].limit) and np.isnan(found.verdicts[0].observed)
        assert repr(found.verdicts) == repr([verdict])
        assert found.parameters == content.parameters

    def test_a_verdict_of_another_version_is_refused_by_what_it_lacks(self, path):
        write_json(path, stored(scattered(0.01, 0)).content)
        content = json.loads(path.read_text())
        del content["verdicts"][0]["parts"][0]["lower"]
        path.write_text(json.dumps(content))
        with pytest.raises(BadInput, match=r"verdicts\.0: lacks 'lower': was written by another"):
            read_json(path, StoredResult)
