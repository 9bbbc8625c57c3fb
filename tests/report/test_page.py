"""The report: a page that stands alone, says everything, and shows foreign words as words."""

import re
from base64 import b64decode, b64encode
from hashlib import sha256

import numpy as np
import pandas as pd
import pytest
from pages import EXTRA, HOSTILE, SVG, Page

from esfem.common.drawing import LOOKS
from esfem.judging.outcome import SEVERITY
from esfem.report.content import Table, found, summary
from esfem.report.results_folder import Sentence, read_folder
from esfem.report.write import write_report
from esfem.results.result_files import load_result

pytestmark = pytest.mark.slow

PNG, SVG_DATA = "data:image/png;base64,", "data:image/svg+xml;base64,"


@pytest.fixture(scope="module")
def text(report):
    return (report / "index.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_the_page_is_well_formed(page):
    assert 5_000 < len(page.elements) < 15_000
    assert page.wrong == []


def test_no_id_occurs_twice(page):
    assert len(page.ids) == len(set(page.ids))


def test_every_reference_leads_to_an_element_of_the_page(page, text):
    referred = {a["href"][1:] for _, a, _ in page.elements if a.get("href", "").startswith("#")}
    referred |= {a["aria-labelledby"] for _, a, _ in page.elements if "aria-labelledby" in a}
    referred |= set(re.findall(r"url\(#([^)]+)\)", text))
    assert 50 < len(referred) < 150
    assert referred <= set(page.ids)


def test_nothing_is_loaded_from_elsewhere(page, text):
    for _, attributes, _ in page.elements:
        for name in ("href", "src"):
            assert attributes.get(name, "#").startswith(("#", PNG, SVG_DATA))
    assert "@import" not in text.lower()
    assert not re.search(r"url\((?!#)", text.lower())
    assert "evil.example" not in text
    assert not page.all("link")


def test_a_foreign_figure_is_a_picture_of_the_bytes_of_its_file(page):
    (picture,) = (a for a, _ in page.all("img") if a["src"].startswith(SVG_DATA))
    assert b64decode(picture["src"].removeprefix(SVG_DATA)).decode() == SVG
    assert picture["alt"] == EXTRA["alt"]


def test_nothing_of_a_foreign_figure_is_in_the_page(page, text):
    tags = {tag for tag, _, _ in page.elements}
    assert not tags & {"foreignobject", "iframe", "image", "animate", "object", "embed"}
    assert len(page.all("script")) == len(page.all("body")) == 1
    assert not [
        name for _, attributes, _ in page.elements for name in attributes if name[:2] == "on"
    ]
    assert "display: none}" not in text and "javascript:" not in text.lower()
    assert [a["id"] for a, _ in page.all("section") if a["id"] == "summary"] == ["summary"]


def test_the_rules_of_a_figure_are_about_itself(page):
    figures = [a["id"] for a, _ in page.all("svg")]
    rules = [text for _, text in page.all("style")[1:]]
    selectors = [rule.split("{")[0] for text in rules for rule in text.split("}") if rule.strip()]
    assert 100 < len(selectors) < 250
    assert {selector.split()[0].removeprefix("#") for selector in selectors} == set(figures)


def test_the_page_allows_itself_its_own_script_and_pictures_alone(page):
    (script,) = (text for _, text in page.all("script"))
    digest = b64encode(sha256(script.encode()).digest()).decode()
    (allowed,) = (a["content"] for a, _ in page.all("meta") if "http-equiv" in a)
    assert dict(rule.split(" ", 1) for rule in allowed.split("; ")) == {
        "default-src": "'none'",
        "img-src": "data:",
        "style-src": "'unsafe-inline'",
        "script-src": f"'sha256-{digest}'",
    }


def test_every_figure_has_words(page):
    figures, pictures = page.all("svg"), page.all("img")
    titles = {a["id"]: text for a, text in page.all("title") if "id" in a}
    assert len(figures) == 2 * 2 + 2
    assert len(pictures) == 1 + 1
    assert all(a["role"] == "img" and titles[a["aria-labelledby"]] for a, _ in figures)
    assert all(a["alt"] for a, _ in pictures)


def test_all_studies_and_verdicts_are_there(page, folder):
    headings = [text.strip() for _, text in page.all("h2")]
    badges = [text.strip() for a, text in page.all("span") if "badge" in a.get("class", "")]
    verdicts = [v for r in read_folder(folder).studies for v in r.verdicts]
    for result in read_folder(folder).studies:
        assert result.study.study.title in headings
        assert f"study-{result.study.name}" in page.ids
    for outcome in {v.verdict for v in verdicts}:
        expected = sum(v.verdict == outcome for v in verdicts)
        assert badges.count(outcome.upper()) >= expected


def test_foreign_words_are_words(page, text):
    """Titles of a study and a flow, a check, a reason, a sentence, a section, a table's head."""
    assert "<script>alert" not in text and "alert(1)</script>" not in text
    assert 10 <= text.count("&lt;script&gt;alert(1)&lt;/script&gt;") <= 40
    shown = [tag for tag, _, words in page.elements if HOSTILE in "".join(words)]
    assert set(shown) >= {"a", "td", "th", "p", "title", "h2"}


def test_the_order_is_summary_sentences_studies_flows_extras(page):
    anchors = [a["id"] for a, _ in page.all("section")]
    studies = ["study-clifford", "study-small"]
    assert anchors == ["summary", "sentences", *studies, "flow-small", "extra-0"]


def test_a_study_that_was_begun_is_named(text):
    assert "No results yet, runs were begun: begun." in text


def test_each_series_can_be_toggled(page):
    buttons = [a["data-series"] for a, _ in page.all("button")]
    drawn = [a["class"].split() for _, a, _ in page.elements if "class" in a]
    assert len(buttons) == 5 + 2
    assert all(any(name in classes for classes in drawn) for name in buttons)


def test_without_scripts_no_control_is_shown(page):
    toggles = [a for a, _ in page.all("div") if a.get("class") == "toggles"]
    assert len(toggles) == 2
    assert all("hidden" in a for a in toggles)


def test_the_page_is_modest_in_size(report):
    """Half a megabyte for two studies and a flow, so a few for all studies."""
    assert 100_000 < (report / "index.html").stat().st_size < 500_000


def test_data_files_hold_the_errors_to_the_last_bit(report, folder):
    runs = load_result(folder / "clifford").records
    runs = runs[runs["tau"] == 0.0125].sort_values("h", ascending=False)
    file = report / "data" / "study-clifford_tau-0.0125.dat"
    read = pd.read_csv(file, sep=" ", comment="#")
    np.testing.assert_array_equal(read["err_x"], runs["err_x"])
    np.testing.assert_array_equal(read["h"], runs["h"])


def test_a_page_without_extras_shows_nothing_of_them(folder, tmp_path):
    for name in ("verdicts.json", "records.csv", "floors.csv"):
        (tmp_path / "runs" / "small").mkdir(parents=True, exist_ok=True)
        (tmp_path / "runs" / "small" / name).write_bytes((folder / "small" / name).read_bytes())
    page = Page(write_report(tmp_path / "runs", tmp_path / "out").read_text())
    assert [a["id"] for a, _ in page.all("section")] == ["summary", "study-small"]


def test_the_headline_counts_what_holds(folder):
    found = summary(read_folder(folder))
    assert sum(found.counts.values()) == 2
    assert found.sentences == {"suspect": 1}
    assert "0 of 1 sentences hold, 1 SUSPECT" in found.headline


def test_a_sentence_says_in_which_error_it_was_judged():
    words = {"label": "l", "section": "7", "quote": "q", "study": "s", "verdict": "pass"}
    line = Sentence(**words, measured="x 2.00", expected="2")
    assert found(line) == "x 2.00 (expected: 2)"
    told = line.model_copy(update={"error": "u_h - I_h u, L = 1"})
    assert found(told) == f"u_h - I_h u, L = 1: {found(line)}"


def test_every_outcome_has_a_symbol_of_its_own():
    assert set(LOOKS) == set(SEVERITY)
    assert len({look.symbol for look in LOOKS.values()}) == len(SEVERITY)


def test_columns_of_numbers_are_told_from_words():
    frame = pd.DataFrame({"a": ["1", "-"], "b": ["[1, 2]", "-"], "c": ["12 %", ""], "d": "x" * 99})
    assert Table("t", "", frame).classes == ["n", "t", "n", ""]


def test_the_hostile_title_is_one_that_a_study_may_have(folder):
    assert load_result(folder / "small").study.study.title == HOSTILE
