"""Figures and tables of `esfem paper`, and what is published of its results."""

import json

import pandas as pd
import pytest
from rich.console import Console

from harness.catalogue import study_path
from harness.paper.ablation import VARIANTS, ablation, ablation_row, divergence
from harness.paper.evidence import StudyData
from harness.paper.extra import Extra, NoData, write_extra
from harness.paper.extras import EXTRAS, write_extras
from harness.paper.publish import publish, thinned
from harness.provenance import numerics_digest
from harness.study import load_study

QUIET = Console(quiet=True)


class TestExtras:
    def test_without_results_all_but_the_normalisation_name_what_is_missing(self, tmp_path):
        for name, make in EXTRAS.items():
            if name != "figure-2-normalisation":
                made = make(tmp_path)
                assert isinstance(made, NoData) and "has not been run" in made.reason

    def test_a_figure_that_can_not_be_made_any_more_is_removed(self, tmp_path, monkeypatch):
        monkeypatch.setattr("harness.paper.extras.EXTRAS", {"one": lambda runs: NoData("gone")})
        (tmp_path / "one.json").write_text("{}")
        (tmp_path / "one.svg").write_text("")
        write_extras(tmp_path, tmp_path, QUIET)
        assert not list(tmp_path.iterdir())

    def test_the_ablation_counts_and_names_what_stops(self, tmp_path, monkeypatch):
        ends = pd.DataFrame(
            {
                "vertices": [30, 30, 60, 60],
                "tau": [0.2, 0.1, 0.2, 0.1],
                "status": ["ok", "diverged", "ok", "failed"],
                "stopped_at": [None, 0.3, None, 0.125],
                "err_x": [1.0, None, 0.25, None],
            }
        )
        monkeypatch.setattr("harness.paper.ablation.study_data", planted(ends))
        (row, *others) = ablation(tmp_path).table
        assert (row["ok"], row["diverged"], row["failed"]) == (2, 1, 1)
        assert (row["least error of x"], row["at tau"]) == (0.25, 0.2)
        assert len(others) == len(VARIANTS) - 1
        stopped = divergence(tmp_path).table
        assert len(stopped) == 2 * len(VARIANTS)
        assert stopped[0]["end"] == "diverged" and stopped[0]["V (stopped at)"] == "30 (t = 0.3)"
        assert stopped[1]["end"] == "linear algebra failed"

    @pytest.mark.parametrize(
        ("name", "told"),
        [
            ("schemes/ellipsoid-project-nu", "of nu alone"),
            ("paper-torus", "on"),
            ("paper-torus-unprojected", "off"),
        ],
    )
    def test_the_ablation_tells_which_projection(self, name, told):
        runs = pd.DataFrame({"vertices": [30], "tau": [0.2], "status": ["diverged"]})
        row = ablation_row(StudyData(load_study(study_path(name)), runs, []))
        assert row["projection"] == told

    def test_a_table_says_where_it_is_from(self, tmp_path):
        write_extra(tmp_path, "one", Extra("title", "text", [{"a": 1}]))
        assert numerics_digest() in json.loads((tmp_path / "one.json").read_text())["by"]


def planted(records):
    return lambda folder, name: StudyData(load_study(study_path(name)), records, [])


def test_what_is_not_there_is_not_published(tmp_path):
    publish(tmp_path / "runs", tmp_path / "out", ["paper-sphere"], ["ellipsoid"])
    assert not (tmp_path / "out").exists()


def test_a_long_history_is_thinned_to_its_first_and_last_and_every_so_many_levels():
    table = "t\n" + "".join(f"{i}\n" for i in range(10))
    assert thinned(table, 4) == "t\n0\n3\n6\n9\n"
    assert thinned(table, 5) == "t\n0\n2\n4\n6\n8\n9\n"
    assert thinned(table, 10) == table
