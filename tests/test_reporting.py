"""The report: a page that stands alone, says everything, and shows foreign words as words."""

import json
import re
from base64 import b64decode, b64encode
from hashlib import sha256
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib import pyplot as plt
from pages import BASELINE, EXTRA, FIGURE, HOSTILE, SENTENCE, SVG, Page, write_extra, write_folder
from PIL import Image

from esfem.common.bad_input import BadInput
from esfem.common.drawing import LOOKS
from esfem.flows.history import COLUMNS, History
from esfem.judging.outcome import SEVERITY
from esfem.report.content import Table, summary
from esfem.report.figures import MOST_LEVELS, fitted_points, masked_points, thinned
from esfem.report.results_folder import read_folder
from esfem.report.sections import pictures
from esfem.report.svg import drawn, inline, picture
from esfem.report.write import write_report
from esfem.results.result_files import load_result
from esfem.solver.laws import energy_of

pytestmark = pytest.mark.slow

PNG, SVG_DATA = "data:image/png;base64,", "data:image/svg+xml;base64,"
# Ten entities, each ten times the one before: a text of ten gigabytes.
ENTITIES = "".join(f'<!ENTITY e{i + 1} "{f"&e{i};" * 10}">' for i in range(9))
BOMB = f'<!DOCTYPE svg [<!ENTITY e0 "0123456789">{ENTITIES}]><svg>&e9;</svg>'.encode()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_folder(tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def report(folder):
    return write_report(folder, folder / "report").parent


@pytest.fixture(scope="module")
def text(report):
    return (report / "index.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_the_page_is_well_formed(page):
    assert len(page.elements) > 500
    assert page.wrong == []


def test_no_id_occurs_twice(page):
    assert len(page.ids) == len(set(page.ids))


def test_every_reference_leads_to_an_element_of_the_page(page, text):
    referred = {a["href"][1:] for _, a, _ in page.elements if a.get("href", "").startswith("#")}
    referred |= {a["aria-labelledby"] for _, a, _ in page.elements if "aria-labelledby" in a}
    referred |= set(re.findall(r"url\(#([^)]+)\)", text))
    assert len(referred) > 20
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
    assert len(selectors) > 20
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
    assert text.count("&lt;script&gt;alert(1)&lt;/script&gt;") >= 10
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
    assert (report / "index.html").stat().st_size < 500_000


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


def test_every_outcome_has_a_symbol_of_its_own():
    assert set(LOOKS) == set(SEVERITY)
    assert len({look.symbol for look in LOOKS.values()}) == len(SEVERITY)


@pytest.fixture
def own():
    """A figure with one series, cut at its frame, with a title that means no good."""
    figure, axes = plt.subplots()
    axes.plot([0.0, 1.23456], [0.0, 1.0], marker="o", gid="series-0-x")
    axes.set_title(HOSTILE, parse_math=False)
    return Page(inline(drawn(figure), "p", HOSTILE))


def test_ids_of_an_own_figure_are_its_own_and_those_that_are_used(own):
    used = {a["href"][1:] for a, _ in own.all("use")}
    cut = {a["clip-path"][5:-1] for _, a, _ in own.elements if "clip-path" in a}
    assert used and cut and used | cut < set(own.ids)
    assert set(own.ids) == used | cut | {"p", "p-title"}
    assert all(name.startswith("p-") for name in used | cut)


def test_the_series_of_an_own_figure_has_its_class(own):
    assert [a["class"] for a, _ in own.all("g") if "class" in a] == ["s0"]


def test_words_of_an_own_figure_are_words(own):
    assert own.wrong == []
    assert not own.all("script")
    assert own.all("title") == [({"id": "p-title"}, HOSTILE)]
    assert HOSTILE in [text for _, text in own.all("text")]


def test_coordinates_of_an_own_figure_are_short(own):
    assert all(re.findall(r"\.\d{3,}", a["d"]) == [] for a, _ in own.all("path"))


@pytest.mark.parametrize(
    "bad",
    [b"<svg", b"<html/>", b"", b"\xff\xfe\xff", b"<?xml version='1.0' encoding='no'?><svg/>", BOMB],
)
def test_what_is_no_svg_is_refused(tmp_path, bad):
    (tmp_path / "map.svg").write_bytes(bad)
    with pytest.raises(BadInput, match=r"map\.svg: no SVG"):
        picture(tmp_path / "map.svg")


def test_a_picture_that_is_no_png_is_not_even_tried(tmp_path):
    """Pillow would hand PostScript to another program."""
    (tmp_path / "surfaces.png").write_text("%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n")
    with pytest.raises(BadInput, match="no picture that can be read: cannot identify"):
        pictures(SimpleNamespace(folder=tmp_path))


def test_a_picture_of_too_many_pixels_is_refused(tmp_path, monkeypatch):
    Image.new("RGB", (100, 100), "red").save(tmp_path / "surfaces.png")
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 10)
    with pytest.raises(BadInput, match=r"no picture that can be read: .* pixels"):
        pictures(SimpleNamespace(folder=tmp_path))


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


def test_the_drawn_fit_is_the_judged_one_and_the_fan_meets_it_in_the_middle():
    result = load_result(BASELINE / "clifford")
    verdict = result.verdicts[0]
    points = fitted_points(verdict, result.records)
    assert len(points) == len(verdict.vertices)
    slope = np.polyfit(np.log(points["s"]), np.log(points["error"]), 1)[0]
    np.testing.assert_allclose(slope, verdict.observed, rtol=1e-12)
    middles = {n: np.exp(np.log(points[n]).mean()) for n in ("error", "low", "high")}
    np.testing.assert_allclose(list(middles.values()), middles["error"], rtol=1e-12)


def test_masked_runs_are_marked_where_they_lie():
    result = load_result(BASELINE / "helfrich-bdf2")
    (verdict,) = (v for v in result.verdicts if v.variable == "z")
    points = masked_points(verdict, result.records)
    assert len(points) == len(verdict.masked) > 0
    assert set(points["error"]) <= set(result.records["err_z"])


def test_a_long_history_keeps_its_ends_and_its_order():
    history = History(energy_of("willmore"))
    history.rows = [(0.1 * n,) * len(COLUMNS) for n in range(5000)]
    t = thinned(history).column("t")
    assert t[0] == 0.0
    assert t[-1] == history.rows[-1][0]
    assert len(t) <= MOST_LEVELS
    assert (np.diff(t) > 0).all()


def test_columns_of_numbers_are_told_from_words():
    frame = pd.DataFrame({"a": ["1", "-"], "b": ["[1, 2]", "-"], "c": ["12 %", ""], "d": "x" * 99})
    assert Table("t", "", frame).classes == ["n", "t", "n", ""]


def test_the_hostile_title_is_one_that_a_study_may_have(folder):
    assert load_result(folder / "small").study.study.title == HOSTILE
