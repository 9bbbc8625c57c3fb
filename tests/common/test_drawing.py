"""Figures: their style and how they are written; what several of them draw alike."""

import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import Normalize

from esfem.common.drawing import (
    LOOKS,
    STYLE,
    labelled_map,
    legend_below,
    level_ticks,
    save_figure,
    series_look,
    stopped_crosses,
    styled,
    subplots,
)
from esfem.common.provenance import numerics_digest


@styled()
def drawn():
    figure, axis = subplots(size=(3.0, 2.0))
    axis.loglog([0.1, 0.2, 0.4], [1e-3, 4e-3, 1.6e-2], label="a", **series_look(0))
    return figure, axis


def test_colours_are_had_without_matplotlib():
    """It takes a second to load, which no verdict on a terminal is to wait for."""
    code = "import esfem.common.drawing, sys; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_style_ends_with_what_is_drawn():
    import matplotlib

    before = matplotlib.rcParams["font.size"]
    with styled({"axes.grid": False}):
        assert matplotlib.rcParams["font.size"] == STYLE["font.size"] != before
        assert not matplotlib.rcParams["axes.grid"]
    assert matplotlib.rcParams["font.size"] == before


@pytest.mark.usefixtures("figures")
class TestSaving:
    def test_the_same_figure_is_the_same_file(self, tmp_path):
        for name in ("a", "b"):
            save_figure(drawn()[0], tmp_path / f"{name}.svg", "one line")
        for ending in ("svg", "pdf"):
            assert (tmp_path / f"a.{ending}").read_bytes() == (
                tmp_path / f"b.{ending}"
            ).read_bytes()

    def test_a_file_says_what_it_shows_and_what_made_it(self, tmp_path):
        save_figure(drawn()[0], tmp_path / "deep" / "a.svg", "one line")
        text = (tmp_path / "deep" / "a.svg").read_text(encoding="utf-8")
        assert "one line; esfem-willmore" in text and numerics_digest() in text

    def test_the_endings_are_those_that_are_asked_for(self, tmp_path):
        save_figure(drawn()[0], tmp_path / "a.b.svg", "one line", [".png", ".pdf"])
        assert sorted(path.name for path in tmp_path.iterdir()) == ["a.b.pdf", "a.b.png"]

    def test_no_figure_is_left_to_a_window(self):
        import matplotlib.pyplot as plt

        drawn()
        assert not plt.get_fignums()


class TestParts:
    def test_stopped_runs_are_crosses_above_all_errors_a_row_a_line(self):
        _, axis = drawn()
        below = axis.get_ylim()[1]
        stopped_crosses(axis, [pd.Series([0.1]), pd.Series([0.2, 0.4])], 0.05, "series-{i}-x")
        *_, one, two, legend = axis.lines
        assert (one.get_gid(), two.get_gid()) == ("series-0-x", "series-1-x")
        assert one.get_color() == series_look(0)["color"] != two.get_color()
        assert legend.get_label() == "stopped early"
        heights = [float(line.get_ydata()[0]) for line in (one, two)]
        low, high = np.log(axis.get_ylim())
        band = (np.log(below) - low) / (high - low)
        assert band < heights[1] < heights[0] < 1.0

    def test_where_none_stopped_nothing_is_drawn(self):
        _, axis = drawn()
        limits = axis.get_ylim()
        stopped_crosses(axis, [pd.Series([], dtype=float)], 0.05)
        assert len(axis.lines) == 1 and axis.get_ylim() == limits

    def test_ticks_are_the_levels_with_two_digits(self):
        _, axis = drawn()
        level_ticks(axis, [0.123, 0.4])
        axis.figure.canvas.draw()
        assert [tick.get_text() for tick in axis.get_xticklabels()] == ["0.12", "0.4"]
        assert not len(axis.xaxis.get_minorticklocs())

    def test_texts_of_a_map_can_be_read_on_their_colour(self):
        _, axis = subplots()
        values = np.array([[0.0, 1.0], [np.nan, 0.2]])
        texts = np.array([["a", "b"], ["", "d"]])
        labelled_map(axis, values, texts, "viridis", Normalize(0, 1), values < 0.5)
        found = {text.get_text(): text.get_color() for text in axis.texts}
        assert found == {"a": "white", "b": "black", "": "black", "d": "white"}

    def test_a_legend_has_each_line_once(self):
        figure, axis = drawn()
        legend_below(figure, axis)
        assert [text.get_text() for text in figure.legends[0].get_texts()] == ["a"]


@pytest.mark.parametrize("outcome", LOOKS)
def test_a_verdict_is_told_by_a_colour_and_a_symbol(outcome):
    assert len(LOOKS[outcome].symbol) == 1 and LOOKS[outcome].colour.startswith("#")
