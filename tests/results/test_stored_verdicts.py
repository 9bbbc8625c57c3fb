"""verdicts.json read back: what follows from the parts must agree, older files are read."""

import json

import pytest
from stored import recast, scattered, stored

from esfem.common.bad_input import BadInput
from esfem.common.files import plain, read_json
from esfem.results.result_files import StoredResult, derived
from esfem.results.verdicts import Verdict


@pytest.fixture
def content():
    """verdicts.json as plain data, with one verdict."""
    found = stored(scattered(0.01, 0)).content
    told = plain(found)
    told["verdicts"][0] |= derived(found.verdicts[0])
    return told


@pytest.fixture
def read(tmp_path):
    def read(content):
        path = tmp_path / "verdicts.json"
        path.write_text(json.dumps(content))
        return read_json(path, StoredResult)

    return read


def flat(entry):
    """The entry as a version had it that judged u_h - u alone."""
    (part,) = entry.pop("parts")
    del entry["decides"], part["name"], part["outcome"]
    return {**entry, **part}


def test_what_was_written_comes_back(content, read):
    assert repr(read(content).verdicts) == repr(stored(scattered(0.01, 0)).content.verdicts)


@pytest.mark.parametrize(("key", "value"), [("verdict", "fail"), ("decides", "interpolation")])
def test_what_contradicts_the_parts_is_refused(content, read, key, value):
    content["verdicts"][0][key] = value
    with pytest.raises(BadInput, match=rf"verdicts\.0: {key} = '{value}': of its parts it is"):
        read(content)


def test_an_entry_of_a_version_with_one_error_is_read_as_that(content, read):
    expected = read(json.loads(json.dumps(content))).verdicts
    content["verdicts"] = [flat(entry) for entry in content["verdicts"]]
    found = read(content).verdicts
    assert repr(found) == repr(expected) and found[0].deciding.name == "error"


def test_one_that_lacks_a_field_of_that_version_is_refused_by_name(content, read):
    content["verdicts"] = [flat(entry) for entry in content["verdicts"]]
    del content["verdicts"][0]["scatter"]
    with pytest.raises(BadInput, match=r"verdicts\.0: lacks 'scatter': was written by another"):
        read(content)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"parts": []}, "must be different errors, at least one"),
        ({"parts": "x"}, r"verdicts\.0\.parts = 'x': "),
        ({"direction": "x"}, r"verdicts\.0\.direction = 'x': "),
    ],
)
def test_what_is_no_verdict_is_refused_by_its_key(content, read, change, message):
    content["verdicts"][0] |= change
    with pytest.raises(BadInput, match=message):
        read(content)


def test_a_list_of_what_superconverges_is_read_of_older_results_alone(content, read):
    content["parameters"]["study"]["superconvergent"] = ["x", "nu"]
    about = read(content).parameters.study
    assert set(about.superconvergent) == {"x", "nu"}
    assert "did not ask why" in about.why_more("x", "error")


def test_the_deciding_error_follows_from_the_outcomes(content, read):
    verdict = read(content).verdicts[0]
    part = verdict.parts[0]
    other = recast(verdict, name="interpolation", outcome="inconclusive").parts[0]
    both = Verdict("s", "theorem", "", "x", "h", (part, other))
    assert derived(both) == {"verdict": "inconclusive", "decides": "interpolation"}
