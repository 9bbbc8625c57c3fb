"""The comparison of schemes: texts, figures, entrants, the command, what it writes."""

import json
from pathlib import Path

import pytest
from entrant_runs import made
from rich.console import Console
from studies import write_study

from esfem import schemes
from esfem.campaigns.contest import PARTS, extras
from esfem.campaigns.contest.contest import (
    GROUNDS,
    PRINCIPAL,
    Contest,
    Sizes,
    case_of,
    principal,
)
from esfem.campaigns.contest.entrant_run import run_entrant
from esfem.campaigns.contest.extras import TEXTS, computed
from esfem.common.bad_input import BadInput
from esfem.common.drawing import save_figure
from esfem.schemes import named_scheme, scheme_file

QUIET = Console(quiet=True)
CONTEST = Contest(Path("extra"), QUIET)


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


@pytest.mark.slow
@pytest.mark.usefixtures("figures")
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


@pytest.mark.slow
def test_results_stand_in_the_order_of_the_items(processes):
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
@pytest.mark.usefixtures("figures")
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


@pytest.mark.slow
class TestCommand:
    def test_studies_are_judged_published_and_reported(self, command, tmp_path, monkeypatch):
        study = write_study(
            tmp_path,
            ('name = "small"', 'name = "schemes-small"'),
            ("[30, 60, 120, 240, 480]", "[30, 60, 120, 240, 480, 960]"),
        )
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
