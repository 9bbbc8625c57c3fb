"""Figures and tables of `esfem paper`, and what is published of its results."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from paper_examples import FLOORS, runs, study
from rich.console import Console

from esfem.campaigns.paper import ablation as ablation_module
from esfem.campaigns.paper.ablation import (
    FACTORS,
    ablation,
    row,
    rows_by_variant,
    run_ablation,
    variants,
)
from esfem.campaigns.paper.convergence import ON_TORUS, error_figure, stopped_early
from esfem.campaigns.paper.growth import LEAST_FACTOR, UPTO, growth, phase
from esfem.campaigns.paper.run import EXTRAS, write_extras
from esfem.campaigns.paper.stored_results import Missing
from esfem.campaigns.publish import copy_flows, copy_studies, thinned
from esfem.common.provenance import numerics_digest
from esfem.report.extra import Extra, write_extra
from esfem.results.study_result import StudyResult
from esfem.studies.catalogue import study_path
from esfem.studies.study import load_study

QUIET = Console(quiet=True)


class TestExtras:
    def test_without_results_all_but_the_normalisation_name_what_is_missing(self, tmp_path):
        for name, make in EXTRAS.items():
            if name != "figure-2-normalisation":
                with pytest.raises(Missing, match="has not been run"):
                    make(tmp_path)

    def test_a_figure_that_can_not_be_made_any_more_is_removed(self, tmp_path, monkeypatch):
        def gone(runs):
            raise Missing("gone")

        monkeypatch.setattr("esfem.campaigns.paper.run.EXTRAS", {"one": gone})
        (tmp_path / "one.json").write_text("{}")
        (tmp_path / "one.svg").write_text("")
        write_extras(tmp_path, tmp_path, QUIET)
        assert not list(tmp_path.iterdir())

    @pytest.mark.parametrize("both", [True, False])
    def test_the_figure_shows_each_error_that_was_measured(self, both):
        """The paper does not say which its own show; stored results of before have the first."""
        table = runs(willmore_T=25.1)
        table = table.assign(nodes=table["vertices"])
        if both:
            table = table.assign(**{f"nodal_{v}": table[f"err_{v}"] ** 2 for v in ("x", "nu", "H")})
        drawn = error_figure(StudyResult(study(), Path(), table, FLOORS, []))
        shown = {axis.get_title(): axis for axis in drawn.axes if axis.get_visible()}
        assert len(shown) == (7 if both else 4)
        assert r"$\nu$: $u_h - u$" in shown and (r"$\nu$: $u_h - I_h u$" in shown) == both
        for title, power in (("u", 1), ("I_h u", 2))[: 1 + both]:
            line = shown[rf"$\nu$: $u_h - {title}$"].lines[0]
            assert line.get_ydata() == pytest.approx(line.get_xdata() ** (2 * power), rel=1e-12)

    def test_the_map_names_what_stops_and_when(self, tmp_path, monkeypatch):
        ends = pd.DataFrame(
            {
                "vertices": [30, 30, 60, 60],
                "tau": [0.2, 0.1, 0.2, 0.1],
                "status": ["ok", "diverged", "ok", "failed"],
                "stopped_at": [None, 0.3, None, 0.125],
            }
        )
        monkeypatch.setattr("esfem.campaigns.paper.convergence.stored_study", planted(ends))
        stopped = stopped_early(tmp_path).table
        assert len(stopped) == 2 * len(ON_TORUS)
        assert stopped[0]["end"] == "diverged" and stopped[0]["V (stopped at)"] == "30 (t = 0.3)"
        assert stopped[1]["end"] == "linear algebra failed"


class TestAblation:
    def test_a_line_has_the_largest_errors_of_what_finishes_on_the_finer_mesh(self):
        runs = pd.DataFrame(
            {
                "vertices": [240, 240, 480, 480, 480],
                "tau": [0.2, 0.1, 0.2, 0.1, 0.05],
                "status": ["ok", "diverged", "ok", "ok", "diverged"],
                "stopped_at": [None, 0.3, None, None, 0.25],
                **{f"err_{name}": [9.0, None, 1.0, 2.0, None] for name in ("x", "nu", "H")},
                **{f"nodal_{name}": [9.0, None, 0.5, 0.25, None] for name in ("x", "nu", "H")},
            }
        )
        runs = runs.assign(bdf=1, theta=False, project=True, reaction="implicit")
        found = row(runs)
        assert found["reach T, V = 240"] == "1 of 6" and found["reach T, V = 480"] == "2 of 6"
        assert (found["x_h - x"], found["H_h - I_h H"]) == (2.0, 0.5)
        assert (
            found["stops early"] == "V = 240: tau = 0.1 (t = 0.3); V = 480: tau = 0.05 (t = 0.25)"
        )
        none = row(runs.assign(status="diverged", stopped_at=0.1))
        assert none["x_h - x"] is None and none["reach T, V = 480"] == "0 of 6"

    def test_each_variant_gets_its_own_runs(self):
        every = [
            {name: getattr(o, name) for name in FACTORS}
            | {"vertices": 480, "tau": 0.1, "status": "ok", "stopped_at": None}
            | {f"{kind}_{name}": float(i) for kind in ("err", "nodal") for name in ("x", "nu", "H")}
            for i, o in enumerate(variants())
        ]
        for i, (o, line) in enumerate(
            zip(variants(), rows_by_variant(pd.DataFrame(every)), strict=True)
        ):
            told = (line["BDF"], line["theta"], line["projection"], line["reaction"])
            theta, projection = "yes" if o.theta else "no", "on" if o.project else "off"
            assert told == (o.bdf, theta, projection, o.reaction)
            assert line["x_h - x"] == i and line["reach T, V = 480"] == "1 of 6"

    @pytest.mark.slow
    def test_runs_with_f1_and_f2_apart_are_stored_and_differ(self, tmp_path, monkeypatch):
        some = [o for o in variants() if (o.bdf, o.theta, o.project) == (1, False, True)]
        monkeypatch.setattr(ablation_module, "variants", lambda: some)
        monkeypatch.setattr(ablation_module, "VERTICES", (30, 60))
        monkeypatch.setattr(ablation_module, "TAUS", (0.2,))
        monkeypatch.setattr(ablation_module, "FINAL_TIME", 0.4)
        monkeypatch.setattr(ablation_module, "figure", lambda found: None)
        with pytest.raises(Missing):
            ablation(tmp_path)
        run_ablation(tmp_path, 1, QUIET)
        records = sorted((tmp_path / "ablation" / "records").iterdir())
        written = [path.stat().st_mtime_ns for path in records]
        table = ablation(tmp_path).table
        assert [line["reaction"] for line in table] == list(ablation_module.REACTIONS)
        assert len({line["H_h - I_h H"] for line in table}) == len(table) == 5
        run_ablation(tmp_path, 1, QUIET)
        assert [path.stat().st_mtime_ns for path in records] == written


class TestGrowth:
    t = np.linspace(0.0, 1.0, 201)

    def size(self, rate, start=1e-3):
        """A start-up that dies away, and what grows under it."""
        return np.exp(-60.0 * self.t) + start * np.exp(rate * (self.t - 0.1))

    @pytest.mark.parametrize("rate", [8.0, 13.0, 20.0])
    def test_the_rate_is_that_of_the_exponential_under_the_start_up(self, rate):
        found = phase(self.t, self.size(rate))
        assert found.rate == pytest.approx(rate, rel=0.01)  # what is left of the start-up
        assert self.size(rate)[found.last] <= UPTO

    def test_what_comes_after_the_linear_phase_does_not_count(self):
        size = self.size(13.0)
        bent = np.where(size > UPTO, UPTO * (size / UPTO) ** 3, size)
        assert phase(self.t, bent).rate == pytest.approx(phase(self.t, size).rate, rel=1e-12)

    @pytest.mark.parametrize("rate", [-2.0, 0.0, 1.2])
    def test_what_hardly_grows_has_no_rate(self, rate):
        size = self.size(rate)
        assert phase(self.t, size) is None
        assert size[-1] / size.min() < 3.0 * LEAST_FACTOR

    def test_a_run_that_ends_at_once_has_no_rate(self):
        assert phase(self.t[:5], self.size(13.0)[:5]) is None

    def test_a_study_whose_records_are_gone_counts_as_missing(self, tmp_path, monkeypatch):
        runs = pd.DataFrame({"vertices": [240], "tau": [0.003125], "key": ["none"]})
        monkeypatch.setattr("esfem.campaigns.paper.growth.stored_study", planted(runs))
        with pytest.raises(Missing, match="record"):
            growth(tmp_path)

    def test_a_table_says_where_it_is_from(self, tmp_path):
        write_extra(tmp_path, "one", Extra("title", "text", [{"a": 1}]))
        assert numerics_digest() in json.loads((tmp_path / "one.json").read_text())["by"]


def planted(records):
    return lambda folder, name: StudyResult(
        load_study(study_path(name)), folder, records, FLOORS, []
    )


def test_what_is_not_there_is_not_published(tmp_path):
    for copy in (copy_studies, copy_flows):
        copy(tmp_path / "runs", tmp_path / "out", ["paper-sphere"])
    assert not (tmp_path / "out").exists()


def test_a_long_history_is_thinned_to_its_first_and_last_and_every_so_many_levels():
    table = "t\n" + "".join(f"{i}\n" for i in range(10))
    assert thinned(table, 4) == "t\n0\n3\n6\n9\n"
    assert thinned(table, 5) == "t\n0\n2\n4\n6\n8\n9\n"
    assert thinned(table, 10) == table
