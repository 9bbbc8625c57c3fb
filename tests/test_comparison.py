"""The comparison of schemes: runs, tables, texts, figures, the command, what it writes."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from studies import write_study

from esfem import schemes
from esfem.campaigns.contest import PARTS, entrant_run, extras
from esfem.campaigns.contest import scores as tables
from esfem.campaigns.contest.contest import (
    GROUNDS,
    PRINCIPAL,
    VARIANTS,
    Contest,
    Sizes,
    case_of,
    principal,
)
from esfem.campaigns.contest.entrant_run import EntrantRun, largest_stable, run_entrant
from esfem.campaigns.contest.extras import TEXTS, computed
from esfem.campaigns.contest.scores import shown, shown_step
from esfem.common.bad_input import BadInput
from esfem.common.drawing import save_figure
from esfem.judging.window import fewest_levels
from esfem.meshes import surface_mesh
from esfem.runs.run_case import computational_mesh
from esfem.schemes import named_scheme, scheme_file
from esfem.solver.functionals import mesh_width
from esfem.solver.geometry import geometry

EVERYONE = {**PRINCIPAL, **VARIANTS}
QUIET = Console(quiet=True)
CONTEST = Contest(Path("extra"), QUIET)
each_entrant = pytest.mark.parametrize("entrant", EVERYONE)


class TestLargestStable:
    @pytest.mark.parametrize("threshold", [0.7, 0.03, 1.3e-4])
    def test_finds_a_threshold_from_below_within_its_factor(self, threshold):
        found = largest_stable(lambda tau: tau <= threshold)
        assert found <= threshold < entrant_run.FACTOR * found

    def test_ends_of_the_range(self):
        assert largest_stable(lambda tau: True) == entrant_run.LARGEST
        assert largest_stable(lambda tau: False) == 0.0

    def test_a_step_beyond_which_none_was_tried_is_shown_as_a_bound(self):
        assert shown_step(entrant_run.LARGEST) == f">= {entrant_run.LARGEST:g}"
        assert shown_step(0.99 * entrant_run.LARGEST) == f"{0.99 * entrant_run.LARGEST:.2g}"
        assert shown_step(0.0) == "none"

    def test_growth_of_the_energy_is_no_stability(self, monkeypatch):
        """A run that ends, on a surface that W says to be another one."""
        bgn = PRINCIPAL["bgn"]
        monkeypatch.setattr(entrant_run, "GROWTH", 0.5)
        assert not entrant_run.is_stable(bgn, GROUNDS["sphere"], 30, 1e-4)
        monkeypatch.setattr(entrant_run, "GROWTH", 1.1)
        assert entrant_run.is_stable(bgn, GROUNDS["sphere"], 30, 1e-4)


class TestRun:
    @each_entrant
    def test_measures_every_level(self, entrant):
        found = run_entrant(case_of(EVERYONE[entrant], GROUNDS["sphere"], 60, 1e-4, 4e-4))
        assert found.ended == "ok"
        np.testing.assert_allclose(found.levels["t"], 1e-4 * np.arange(5), rtol=1e-12)
        assert len(found.seconds) == 4 and min(found.seconds) > 0
        assert 0 < found.at("end", "distance") < 1e-2 and found.at("end", "W") < 1e-2
        assert all(0.5 < quality <= 1.0 for quality in found.levels["quality"])
        assert (entrant == "bgn") == np.isnan(found.at("end", "x"))  # its nodes slide

    def test_at_the_start_errors_are_those_of_the_interpolation(self):
        found = run_entrant(case_of(PRINCIPAL["dziuk"], GROUNDS["Clifford torus"], 60, 1e-4, 4e-4))
        apart = found.levels["apart"]
        assert apart[0] == 0.0 < apart[-1] == found.furthest
        gap = abs(found.at("end", "x") - found.at("start", "x"))
        assert gap <= 1.1 * found.furthest  # the triangle inequality, but for the two surfaces

    @pytest.mark.parametrize("entrant", PRINCIPAL)
    def test_drift_is_beside_the_change_of_the_flow_itself(self, entrant):
        """The sphere keeps its area; the area of the cell changes, and so does that of the flow."""
        options = PRINCIPAL[entrant]
        rest = run_entrant(case_of(options, GROUNDS["sphere"], 60, 1e-4, 4e-4))
        moving = run_entrant(case_of(options, GROUNDS["red blood cell"], 240, 2.5e-4, 5e-3))
        area, volume = rest.levels["area"], moving.levels["volume"]
        assert rest.at("end", "area_drift") == pytest.approx(abs(area[-1] / area[0] - 1.0))
        change = abs(volume[-1] / volume[0] - 1.0)
        assert change > 0.01 and moving.at("end", "volume_drift") < 0.1 * change

    @each_entrant
    def test_a_breakdown_ends_it_by_name(self, entrant):
        case = case_of(EVERYONE[entrant], GROUNDS["Clifford torus"], 30, 0.05, 1.0)
        found = run_entrant(case.model_copy(update={"disturbance": 0.5}))
        assert found.ended.startswith(("diverged at t = ", "failed at t = "))
        assert np.isnan([found.at("end", "distance"), found.rise(), found.furthest]).all()

    @pytest.mark.parametrize("name", ["start", "energy"])
    def test_a_start_or_an_energy_that_fails_ends_it_by_name(self, name, monkeypatch):
        def fails(*_):
            raise np.linalg.LinAlgError("singular")

        plugin = replace(named_scheme("dziuk"), **{name: fails})
        for module in ("studies.case", "campaigns.contest.contest", "runs.stepping"):
            monkeypatch.setattr(f"esfem.{module}.named_scheme", lambda _: plugin)
        found = run_entrant(case_of(PRINCIPAL["dziuk"], GROUNDS["sphere"], 30, 1e-4, 2e-4))
        assert found.ended == "failed at t = 0"

    def test_the_energy_of_dziuk_is_his_own_and_falls(self):
        """That of the recovered H would rise on the torus."""
        torus = GROUNDS["Clifford torus"]
        found = run_entrant(case_of(PRINCIPAL["dziuk"], torus, 120, 2.5e-4, 2.5e-3))
        own = found.levels["own_energy"]
        assert found.rise("own_energy") == 0.0 and (np.diff(own) < 0).all()
        assert own[0] == pytest.approx(4 * np.pi**2, rel=0.01)


def made(distance=1e-3, ended="ok", energy=(10.0, 9.0, 8.0), **more):
    """A run as if it had been computed."""
    levels = {"t": [0.0, 0.1, 0.2], "quality": [0.9, 0.8, 0.85]}
    levels |= {"energy": list(energy), "own_energy": list(energy)}
    found = EntrantRun(100, 0.1, levels, seconds=[0.5, 0.5], ended=ended, **more)
    if ended == "ok":
        found.errors = {"start": {"distance": 2e-3}, "end": {"distance": distance}}
    return found


class TestTables:
    def test_rises_of_the_energy_are_relative_and_after_the_first_step(self):
        assert made(energy=(10.0, 11.0, 10.5)).rise() == 0.0
        assert made(energy=(10.0, 11.0, 12.0)).rise() == pytest.approx(0.1)

    def test_a_run_that_broke_down_claims_nothing(self):
        broken = made(ended="diverged at t = 0.1", energy=(1.0, 50.0))
        row = shown(tables.measured(broken))
        nothing = ("W rises by", "distance, end", "W error", "x in H^1, end")
        assert {row[name] for name in nothing} == {"-"}
        course = shown(tables.course_row("kll", broken))
        assert {course[k] for k in ("W rises by", "quality, end", "W / 8 pi, end")} == {"-"}

    def test_an_order_has_its_standard_error_and_leaves_out_what_did_not_run(self):
        assert str(tables.order([0.4, 0.2, 0.1], [0.16, 0.04, 0.01])) == "2.00 ± 0.00"
        four = tables.order([0.8, 0.4, 0.2, 0.1], [np.nan, 0.16, 0.04, 0.01])
        assert str(four) == "2.00 ± 0.00 (3 of 4)"
        assert tables.order([0.4, 0.2, 0.1], [0.16, np.nan, 0.01]) is None
        scattered = tables.order([0.8, 0.4, 0.2, 0.1], [0.16, 0.08, 0.04, 0.08])
        assert scattered.fit.uncertainty > 0.2

    def test_numbers_are_shown_by_their_column(self):
        row = {"N": 7, "W error": 0.01234, "quality, end": 0.5, "own W / 8 pi, end": 1.0}
        row |= {"W rises by": 1e-12, "own W rises by": 0.5, "largest stable tau": 0.0}
        row |= {"order k": None, "W": None, "CPU s a step": 0.016149}
        assert list(shown(row).values()) == [
            *(7, "1.2e-02", "0.50", "1.00000"),
            *("never", "5.0e-01", "none"),
            *("none", "-", 0.0161),
        ]

    @pytest.mark.parametrize("k", [1, 2, 3])
    @each_entrant
    def test_an_order_is_judged_where_one_is_claimed(self, entrant, k):
        runs = [EntrantRun(100, h, {"apart": [0.0, h**2]}) for h in (0.5, 0.35, 0.25, 0.18, 0.12)]
        found = tables.verdict(EVERYONE[entrant], k, runs, Sizes())
        word = tables.shown_verdict(found).partition(" ")[0]
        spoken = entrant.startswith("kll, theta") and "Ritz" not in entrant and k > 1
        assert word == ({2: "PASS", 3: "FAIL"}[k] if spoken else "none")

    def test_the_ladder_is_long_enough_for_the_judge(self):
        case = case_of(PRINCIPAL["kll"], GROUNDS["Clifford torus"], 30, 1e-4, 1e-4)
        torus, h = case.solution.initial(), []
        for v in Sizes().order_V:
            mesh, p = computational_mesh(surface_mesh(torus.mesh_surface, v), torus, 1)
            h.append(mesh_width(geometry(mesh, p)))
        assert len(h) >= fewest_levels(np.array(h))

    def test_a_verdict_tells_its_cause(self):
        few = [EntrantRun(100, h, {"apart": [0.0, h**2]}) for h in (0.5, 0.35, 0.25)]
        found = tables.verdict(PRINCIPAL["kll, theta"], 2, few, Sizes())
        assert tables.shown_verdict(found) == "INCONCLUSIVE, too few levels"

    def test_decay_rates_do_not_depend_on_the_amplitude(self):
        at = partial(tables.rate_on_mesh, PRINCIPAL["kll, theta"], 60, 3)
        rate = at(Sizes())[1]
        half = Sizes(decay_amplitude=Sizes().decay_amplitude / 2)
        assert 1e-4 < abs(rate - 24.0) < 0.1
        assert abs(at(half)[1] - rate) < 0.05 * abs(rate - 24.0)

    def test_extrapolated_rates_have_hardly_an_error_in_tau(self):
        """The implicit Euler method on a' = -24 a."""
        steps = [Sizes().decay_tau / m for m in (1, 2, 4)]
        rates = [np.log1p(24.0 * tau) / tau for tau in steps]
        assert abs(rates[0] - 24.0) > 0.1
        assert abs(tables.extrapolated(*rates) - 24.0) < 1e-5

    def test_a_scheme_that_breaks_down_has_no_cost(self, monkeypatch):
        broken = made(ended="diverged at t = 0.1")
        monkeypatch.setattr(tables, "run_entrant", lambda *_, **__: broken)
        row = shown(tables.cost_row("kll", PRINCIPAL["kll"], Sizes()))
        assert (row["ended"], row["CPU s a step"]) == (broken.ended, "-")


class TestTexts:
    """What is said of the schemes is what they declare."""

    schemes = {name: named_scheme(name) for name in ("kll", "dziuk", "bgn")}  # noqa: RUF012

    def test_the_recovered_are_those_that_are_named(self):
        lacks = [f"{', '.join(s.recovered)} of {n}" for n, s in self.schemes.items() if s.recovered]
        assert f"Recovered are {'; '.join(lacks)}." in TEXTS["comparison"]["text"]

    def test_the_energies_are_those_of_the_schemes(self):
        told = TEXTS["both"]["energies"]
        of_recovered = [name for name, s in self.schemes.items() if "H" in s.recovered]
        own = [name for name, s in self.schemes.items() if s.energy is not None]
        assert f"of the recovered H for {', '.join(of_recovered)}. Own W" in told
        assert f"where it has another one, which {', '.join(own)} has." in told

    @pytest.mark.parametrize("part", extras.PARTS)
    def test_all_numbers_are_inserted(self, part):
        for text in TEXTS[part].values():
            assert not set("{}[]") & set(extras.told(text, CONTEST))


class TestFigures:
    def test_a_run_that_broke_down_is_a_cross(self, tmp_path):
        path, good, stop = tmp_path / "figure.svg", made(), made(ended="diverged at t = 0.1")
        good.errors["end"]["W"] = 1e-3
        save_figure(extras.cost_figure({"a": [good, good], "b": [good, stop]}), path, "cell")
        assert 'id="broken-1"' in path.read_text() and 'id="broken-0"' not in path.read_text()
        save_figure(extras.course_figure({"a": good, "b": stop}), path, "cell")
        assert 'id="broken-1"' in path.read_text() and 'id="broken-0"' not in path.read_text()

    @pytest.mark.parametrize("seconds", [[], [0.5]])
    def test_the_cross_is_drawn_also_where_the_first_step_failed(self, tmp_path, seconds):
        path, good, stop = tmp_path / "figure.svg", made(), made(ended="failed at t = 0.1")
        good.errors["end"]["W"], stop.seconds = 1e-3, seconds
        save_figure(extras.cost_figure({"a": [good], "b": [stop]}), path, "cell")
        group = path.read_text().partition('id="broken-1"')[2].partition("</g>\n  </g>")[0]
        assert "<use" in group


def test_results_stand_in_the_order_of_the_items():
    assert computed(pow, [(2, 5), (2, 3), (2, 4)], 2, QUIET, "powers") == [32, 8, 16]


class TestEntrants:
    def test_a_further_scheme_takes_part_at_its_defaults(self, tmp_path, monkeypatch):
        (tmp_path / "my_own.py").write_text(scheme_file("dziuk").read_text())
        monkeypatch.setattr(schemes, "__path__", [*schemes.__path__, str(tmp_path)])
        entrants = principal(["my-own"])
        assert list(entrants) == [*PRINCIPAL, "my-own"]
        found = run_entrant(case_of(entrants["my-own"], GROUNDS["sphere"], 30, 1e-4, 2e-4))
        assert found.ended == "ok"

    def test_one_that_is_there_is_left_as_it_is(self):
        assert principal(["kll", "bgn"]) == principal() == PRINCIPAL

    def test_options_without_default_are_named(self, tmp_path, monkeypatch):
        source = scheme_file("kll").read_text().replace('name: str = "kll"', 'name: str = "new"')
        (tmp_path / "demanding.py").write_text(source)
        monkeypatch.setattr(schemes, "__path__", [*schemes.__path__, str(tmp_path)])
        with pytest.raises(BadInput, match=r"--scheme demanding: cannot run .*: bdf: is missing;"):
            principal(["demanding"])

    @pytest.mark.parametrize("name", ["kll-mcf", "nothing"])
    def test_a_scheme_without_willmore_flow_is_refused_with_those_there_are(self, name):
        with pytest.raises(BadInput, match=rf"--scheme {name}: must be one of bgn, dziuk, kll"):
            principal([name])


@pytest.mark.slow
def test_extras_for_the_report_are_written(tmp_path):
    sizes = Sizes(
        V=120,
        time=1e-3,
        ladder=(60, 120),
        long_time=0.02,
        degrees=(1,),
        order_V=(30, 60, 120),
        order_time=5e-4,
        decay_V=(30, 60, 120),
        cost_V=120,
    )
    grounds = ("sphere", "red blood cell")
    contest = Contest(tmp_path / "extra", QUIET, 1, variants={}, grounds=grounds, sizes=sizes)
    extras.compare_schemes(contest, extras.PARTS)
    written = {
        path.stem: json.loads(path.read_text()) for path in (tmp_path / "extra").glob("*.json")
    }
    assert set(written) == {f"schemes-{part}" for part in extras.PARTS}
    rows = written["schemes-comparison"]["table"]
    assert len(rows) == 2 * len(PRINCIPAL)
    for name in ("schemes-comparison", "schemes-course"):
        svg = (tmp_path / "extra" / written[name]["figure"]).read_text()
        assert (tmp_path / "extra" / f"{name}.pdf".replace("comparison", "cost")).is_file()
        assert all(entrant in svg for entrant in PRINCIPAL)
    assert "V = 120, tau = 0.00025 to t = 0.001" in written["schemes-comparison"]["text"]
    assert {row["order k"] for row in written["schemes-orders"]["table"]} == {"none"}  # k = 1
    for extra in written.values():
        assert {"title", "text", "table", "by"} <= extra.keys()
        assert set(extra["schemes"]) == {"kll", "dziuk", "bgn"}


class TestCommand:
    def test_studies_are_judged_published_and_reported(self, command, tmp_path, monkeypatch):
        study = write_study(tmp_path, ('name = "small"', 'name = "schemes-small"'))
        monkeypatch.setattr("esfem.campaigns.contest.run.scheme_studies", lambda: [study])
        runs, out = tmp_path / "runs", tmp_path / "out"
        status, said = command(
            "schemes", "--runs", runs, "--out", out, "--only", "studies", "--jobs", 1
        )
        assert status == 0 and "SUPER         schemes-small" in said
        assert (
            json.loads((out / "schemes-small" / "verdicts.json").read_text())["verdict"] == "super"
        )
        assert not list((out / "extra").iterdir())
        assert (runs / "schemes-small" / "records").is_dir()
        assert not (out / "schemes-small" / "records").exists()
        assert "schemes-small" in (out / "report" / "index.html").read_text()

    def test_a_part_that_is_none_is_refused_with_those_there_are(self, command, tmp_path):
        status, said = command("schemes", "--out", tmp_path, "--only", "costs")
        assert status == 2 and "--only costs" in said
        assert all(part in said for part in PARTS)

    def test_a_folder_that_cannot_be_written_is_named_before_anything_is_computed(
        self, command, tmp_path
    ):
        (tmp_path / "file").write_text("")
        status, said = command("schemes", "--out", tmp_path / "file", "--runs", tmp_path / "runs")
        assert status == 2 and str(tmp_path / "file") in said.replace("\n", "")
        assert not (tmp_path / "runs").exists()

    def test_one_folder_for_both_is_refused(self, command, tmp_path):
        status, said = command("schemes", "--out", tmp_path, "--runs", tmp_path)
        assert status == 2 and "must be another folder than --runs" in " ".join(said.split())

    def test_no_process_is_refused(self, command, tmp_path):
        assert command("schemes", "--out", tmp_path, "--jobs", 0)[0] == 2

    def test_the_parts_are_those_that_can_be_computed(self):
        assert set(PARTS) == {"studies", *extras.PARTS}
