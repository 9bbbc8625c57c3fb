"""What is no folder of results is refused by name."""

import json

import pytest
from pages import EXTRA, FIGURE, SENTENCE, write_extra

from esfem.common.bad_input import BadInput
from esfem.report.results_folder import read_folder
from esfem.report.write import write_report


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"figure": f"../{FIGURE}.svg"}, "name of an SVG file"),
        ({"alt": ""}, "have an alt"),
        ({"figure": "none.svg"}, "cannot be read"),
        ({"figure": f"{FIGURE}.png"}, "must be an SVG file"),
        ({"table": 3}, "ablation.json: table"),
    ],
)
def test_a_bad_section_is_refused_by_name(tmp_path, change, words):
    write_extra(tmp_path, {**EXTRA, **change})
    with pytest.raises(BadInput, match=words):
        write_report(tmp_path, tmp_path / "report")


@pytest.mark.parametrize(
    ("sentences", "words"),
    [
        ([{**SENTENCE, "verdict": "maybe"}], "0.verdict"),
        ([{"label": "x"}], "0.section"),
        ({}, "sentences.json"),
    ],
)
def test_bad_sentences_are_refused_by_name(tmp_path, sentences, words):
    (tmp_path / "sentences.json").write_text(json.dumps(sentences))
    with pytest.raises(BadInput, match=words):
        read_folder(tmp_path)


def test_a_folder_without_results_is_refused(tmp_path):
    with pytest.raises(BadInput, match="holds no results"):
        read_folder(tmp_path)


def test_a_damaged_flow_is_refused(tmp_path):
    (tmp_path / "flows" / "f").mkdir(parents=True)
    (tmp_path / "flows" / "f" / "checks.json").write_text("{}")
    with pytest.raises(BadInput, match="holds no flow"):
        read_folder(tmp_path)
