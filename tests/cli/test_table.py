"""``esfem table``: what is stored is shown, judged afresh, or refused; foreign titles are text."""

import io
import json
import shutil
from dataclasses import replace

import pytest
from shortcuts import SAVE, saved_by
from studies import write_study

from esfem.common.bad_input import BadInput
from esfem.results.result_files import judged_afresh, load_result, own_digest
from esfem.results.run_studies import run_studies
from esfem.results.tables import latex


@pytest.fixture
def printed(esfem):
    """The command line: its status and standard output."""
    return lambda *words: esfem(*words)[:2]


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Results of the small study, under a title that is odd to TeX, mathtext and rich."""
    folder = tmp_path_factory.mktemp("stored [b]")
    title = ('title = "A small study"', "title = '$x_{$ 50% of R_0 & more [b] :warning:'")
    with saved_by(SAVE):
        return run_studies([write_study(folder, title)], out=folder / "out", jobs=1)[0].folder


def test_table_shows_the_stored_verdicts_and_judges_afresh_when_asked(printed, stored, tmp_path):
    folder = shutil.copytree(stored, tmp_path / "small")
    content = json.loads((folder / "verdicts.json").read_text())
    content["verdicts"][0] |= {"verdict": "fail", "decides": "error"}
    content["verdicts"][0]["parts"][0] |= {"outcome": "fail", "observed": 0.123}
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
