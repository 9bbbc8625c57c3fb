"""Figures and pictures in a report: their ids are their own, and foreign ones are refused."""

import re
from types import SimpleNamespace

import pytest
from matplotlib import pyplot as plt
from pages import HOSTILE, Page
from PIL import Image

from esfem.common.bad_input import BadInput
from esfem.report.sections import pictures
from esfem.report.svg import drawn, inline, picture

# Ten entities, each ten times the one before: a text of ten gigabytes.
ENTITIES = "".join(f'<!ENTITY e{i + 1} "{f"&e{i};" * 10}">' for i in range(9))
BOMB = f'<!DOCTYPE svg [<!ENTITY e0 "0123456789">{ENTITIES}]><svg>&e9;</svg>'.encode()


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
