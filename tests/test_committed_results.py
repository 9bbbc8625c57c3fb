"""results/ as it is committed: nothing was edited or lost, and it is of this program or older."""

import json
import re
import shutil
from dataclasses import asdict
from itertools import zip_longest

import committed
import pytest
from committed import RESULTS, by_this_program, studies_below, whole

from esfem.campaigns.paper.sentences import Sentence, judged, sentences
from esfem.common.bad_input import BadInput
from esfem.common.provenance import numerics_digest, stepping_digest
from esfem.results.error_verdicts import ErrorName
from esfem.results.tables import SYMBOLS
from esfem.schemes import scheme_file, scheme_names

NO_ROW = (None, None)
REMEDIES = {
    "baseline": "esfem baseline --update",
    "paper": "make paper",
    "schemes": "make schemes",
}
EVERY = [folder for name in REMEDIES for folder in studies_below(name)]


def test_there_are_results_of_each_kind():
    assert all(len(studies_below(name)) > 10 for name in REMEDIES)


@pytest.mark.parametrize("folder", EVERY, ids=lambda f: f"{f.parent.name}-{f.name}")
def test_no_file_of_a_study_was_edited_or_lost(folder):
    assert whole(folder)["study"] == folder.name


@pytest.mark.parametrize("name", REMEDIES)
def test_studies_are_by_this_program(name):
    made = {whole(folder)["numerics"] for folder in studies_below(name)}
    by_this_program(
        f"results/{name}",
        f"numerics {listed(made)}",
        f"numerics {listed({numerics_digest()})}",
        REMEDIES[name],
    )


def test_flows_are_by_this_program():
    paths = sorted((RESULTS / "paper" / "flows").glob("*/checks.json"))
    made = {json.loads(path.read_text())["environment"]["numerics"] for path in paths}
    assert made
    here = f"numerics {numerics_digest()}"
    by_this_program("results/paper/flows", f"numerics {listed(made)}", here, REMEDIES["paper"])


def test_sentences_were_judged_by_this_program():
    lines = sentence_lines()
    made = {line.get("numerics", "not told") for line in lines}
    here = f"numerics {numerics_digest()}"
    what = "results/paper/sentences.json"
    by_this_program(what, f"numerics {listed(made)}", here, REMEDIES["paper"])


def test_sentences_are_those_of_the_file():
    """The first line that is another one is told."""
    rows = [(sentence, error) for sentence in sentences() for error in sentence.read_in]
    pairs = zip_longest(rows, sentence_lines(), fillvalue=None)
    words = [(read_as(*(row or NO_ROW)), found_in(line, (row or NO_ROW)[0])) for row, line in pairs]
    here, stored = next((pair for pair in words if pair[0] != pair[1]), ("", ""))
    by_this_program("results/paper/sentences.json", stored, here, REMEDIES["paper"])


def sentence_lines() -> list[dict]:
    path = RESULTS / "paper" / "sentences.json"
    return json.loads(path.read_text(encoding="utf-8"))


def read_as(sentence: Sentence | None, error: ErrorName | None = None) -> str:
    """Label, quote, studies and note of an entry of sentences.toml, and the error of that row."""
    if sentence is None:
        return "no sentence"
    words = (sentence.label, sentence.quote, ", ".join(sentence.studies), sentence.note)
    return " | ".join((*words, SYMBOLS[error] if error else ""))


def found_in(line: dict | None, sentence: Sentence | None) -> str:
    """The same of a line of sentences.json, whose note goes on with that of the check."""
    if line is None:
        return "no sentence"
    note = line["note"]
    if sentence is not None and (not sentence.note or note.startswith(f"{sentence.note}; ")):
        note = sentence.note
    error = line.get("error", "").partition(",")[0]  # without the unit of length
    return " | ".join((line["label"], line["quote"], line["study"], note, error))


@pytest.mark.parametrize(
    "path", sorted(RESULTS.glob("*/extra/*.json")), ids=lambda p: f"{p.parts[-3]}-{p.stem}"
)
def test_extra_tables_are_by_this_program(path):
    content = json.loads(path.read_text(encoding="utf-8"))
    made = set(re.findall(r"\(numerics ([0-9a-f]{16})\)", content.get("by", ""))) or {"not told"}
    schemes = content.get("schemes", {})
    here = {name: stepping_digest(scheme_file(name)) for name in schemes if name in scheme_names()}
    by_this_program(
        f"results/{path.relative_to(RESULTS)}",
        f"numerics {listed({*made, *schemes.values()})}",
        f"numerics {listed({numerics_digest(), *here.values()})}",
        REMEDIES[path.parts[-3]],
    )


def listed(digests: set[str]) -> str:
    return ", ".join(sorted(digests))


class TestTheTests:
    """What the functions that all of these use tell apart."""

    @pytest.mark.parametrize("change", [{}, {"note": ""}])
    def test_a_sentence_with_what_its_check_adds_is_the_same(self, change, tmp_path):
        sentence = next(s for s in sentences() if s.note).model_copy(update=change)
        (line,) = map(asdict, judged(sentence, tmp_path, tmp_path))
        assert len(line["note"]) > len(sentence.note) + 2
        assert found_in(line, sentence) == read_as(sentence)

    @pytest.mark.parametrize("key", ["label", "quote", "study", "note"])
    def test_a_sentence_with_another_word_is_another_one(self, key, tmp_path):
        sentence = next(s for s in sentences() if s.note)
        (line,) = map(asdict, judged(sentence, tmp_path, tmp_path))
        assert found_in({**line, key: f"not {line[key]}"}, sentence) != read_as(sentence)
        assert found_in(None, sentence) != read_as(sentence)
        assert found_in(line, None) != read_as(None)

    def test_a_sentence_in_another_error_is_another_one(self, tmp_path):
        sentence = next(s for s in sentences() if s.errors)
        lines = map(asdict, judged(sentence, tmp_path, tmp_path))
        found = [found_in(line, sentence) for line in lines]
        assert found == [read_as(sentence, error) for error in sentence.errors]
        assert found[0] != found[1]

    @pytest.fixture
    def copy(self, tmp_path):
        return shutil.copytree(studies_below("paper")[0], tmp_path / "copy")

    @pytest.mark.parametrize("name", ["records.csv", "table.md", "verdicts.json"])
    def test_an_edited_file_is_damage(self, copy, name):
        text = (copy / name).read_text()
        (copy / name).write_text(text.replace("1", "2", 1))
        with pytest.raises(BadInput, match=f"{name}: was edited or damaged"):
            whole(copy)

    def test_a_lost_file_is_damage(self, copy):
        (copy / "rates.csv").unlink()
        with pytest.raises(BadInput, match=r"rates\.csv: cannot be read"):
            whole(copy)

    def test_what_an_older_program_made_is_told_of(self, monkeypatch):
        monkeypatch.setattr(committed, "STRICT", False)
        with pytest.warns(UserWarning, match="older than the program: a is by b, this is c; make"):
            assert not by_this_program("a", "b", "c", "make it")

    def test_and_fails_once_everything_is_to_be_of_this_program(self, monkeypatch):
        monkeypatch.setattr(committed, "STRICT", True)
        with pytest.raises(pytest.fail.Exception, match="older than the program: a is by b"):
            by_this_program("a", "b", "c", "make it")

    @pytest.mark.parametrize("strict", [True, False])
    def test_what_this_program_made_is_not(self, strict, monkeypatch):
        monkeypatch.setattr(committed, "STRICT", strict)
        assert by_this_program("a", "b", "b", "make it")
