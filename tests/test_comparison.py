"""The comparison of schemes: marches, the largest stable step, the command, what it writes."""

import io
import json

import numpy as np
import pytest
from rich.console import Console
from studies import write_study

from harness.comparison import extras, figure, stability, tables
from harness.comparison.command import PARTS
from harness.comparison.contest import ENTRANTS, GROUNDS, March, case_of, march
from harness.comparison.stability import largest_stable
from harness.stored_results import read_results


class TestLargestStable:
    @pytest.mark.parametrize("threshold", [0.7, 0.03, 1.3e-4])
    def test_finds_a_threshold_from_below_within_its_factor(self, threshold):
        found = largest_stable(lambda tau: tau <= threshold)
        assert found <= threshold < stability.FACTOR * found

    def test_ends_of_the_range(self):
        assert largest_stable(lambda tau: True) == stability.LARGEST
        assert largest_stable(lambda tau: False) == 0.0

    def test_a_step_beyond_which_none_was_tried_is_shown_as_a_bound(self):
        assert tables.shown_step(stability.LARGEST) == f">= {stability.LARGEST:g}"
        assert tables.shown_step(0.99 * stability.LARGEST) == f"{0.99 * stability.LARGEST:.2g}"
        assert tables.shown_step(0.0) == "none"

    def test_growth_of_the_energy_is_no_stability(self, monkeypatch):
        """A run that ends, on a surface that W says to be another one."""
        monkeypatch.setattr(stability, "GROWTH", 1.0)
        assert not stability.is_stable("bgn", GROUNDS["sphere"], 30, 1e-4)
        monkeypatch.setattr(stability, "GROWTH", 1.1)
        assert stability.is_stable("bgn", GROUNDS["sphere"], 30, 1e-4)


@pytest.mark.parametrize("entrant", ENTRANTS)
class TestMarch:
    def test_measures_every_level(self, entrant):
        found = march(case_of(entrant, GROUNDS["sphere"], 60, 1e-4, 4e-4))
        assert found.ended == "ok"
        np.testing.assert_allclose(found.t, 1e-4 * np.arange(5), rtol=1e-12)
        assert len(found.seconds) == 4 and min(found.seconds) > 0
        assert 0 < found.distance < 1e-2 and found.W < 1e-2
        assert all(0.5 < quality <= 1.0 for quality in found.quality)

    def test_drift_is_beside_the_change_of_the_flow_itself(self, entrant):
        """The sphere keeps its area; the area of the cell changes, and so does that of the flow."""
        rest = march(case_of(entrant, GROUNDS["sphere"], 60, 1e-4, 4e-4))
        moving = march(case_of(entrant, GROUNDS["red blood cell"], 240, 2.5e-4, 5e-3))
        assert rest.area_drift == pytest.approx(abs(rest.area[-1] / rest.area[0] - 1.0))
        change = abs(moving.volume[-1] / moving.volume[0] - 1.0)
        assert change > 0.01 and moving.volume_drift < 0.1 * change

    def test_a_breakdown_ends_it_by_name(self, entrant):
        case = case_of(entrant, GROUNDS["Clifford torus"], 30, 0.05, 1.0)
        found = march(case.model_copy(update={"disturbance": 0.5}), compare=False)
        assert found.ended.startswith(("diverged at t = ", "failed at t = "))
        assert np.isnan(found.distance)


def test_rises_of_the_energy_are_relative_and_after_the_first_step():
    found = march(case_of("kll", GROUNDS["sphere"], 30, 1e-4, 2e-4))
    found.energy[:] = [10.0, 11.0, 10.5]
    assert found.rise == 0.0
    found.energy[:] = [10.0, 11.0, 12.0]
    assert found.rise == pytest.approx(0.1)


def test_the_theorem_is_judged_where_it_speaks():
    solution = GROUNDS["Clifford torus"]
    marches = [March(nodes=1, h=h, h1=[h**2]) for h in (0.5, 0.35, 0.25, 0.18, 0.12)]
    verdict = {
        (entrant, k): tables.verdict(case_of(entrant, solution, 60, 1e-4, 1e-3, k), marches)
        for entrant in ENTRANTS
        for k in (1, 2, 3)
    }
    assert verdict["kll, theta", 2].startswith("PASS [")
    assert verdict["kll, theta", 3].startswith("FAIL [")
    assert {v for key, v in verdict.items() if key[0] != "kll, theta" or key[1] == 1} == {"none"}


@pytest.mark.slow
def test_the_command_writes_extras_for_the_report(tmp_path, monkeypatch):
    names = ("sphere", "Clifford torus", "1 + 0.2 P2 sphere")
    grounds = {name: GROUNDS[name] for name in names}
    monkeypatch.setattr(tables, "GROUNDS", grounds)
    monkeypatch.setattr("harness.comparison.words.GROUNDS", grounds)
    monkeypatch.setattr(tables, "DEGREES", (1,))
    monkeypatch.setattr(tables, "ORDER_V", (30, 60, 120))
    monkeypatch.setattr(tables, "DECAY_V", (30, 60, 120))
    monkeypatch.setattr(tables, "COST_V", 120)
    monkeypatch.setattr(figure, "LADDER", (60, 120))
    monkeypatch.setattr(extras, "V", 120)
    monkeypatch.setattr(extras, "V_STABLE", 120)
    monkeypatch.setattr(extras, "TIME", 1e-3)
    console = Console(file=io.StringIO(), width=200)
    monkeypatch.setattr(tables, "ORDER_TIME", 5e-4)
    monkeypatch.setattr(figure, "LONG_TIME", 0.02)
    extras.compare_schemes(tmp_path, console, extras.PARTS)
    written = {
        path.stem: json.loads(path.read_text()) for path in (tmp_path / "extra").glob("*.json")
    }
    assert set(written) == {f"schemes-{part}" for part in extras.PARTS}
    rows = written["schemes-comparison"]["table"]
    assert len(rows) == len(grounds) * len(ENTRANTS)
    assert {row["scheme"] for row in rows} == set(ENTRANTS)
    assert written["schemes-comparison"]["text"].count(". ") >= 3
    for name in ("schemes-comparison", "schemes-course"):
        svg = (tmp_path / "extra" / written[name]["figure"]).read_text()
        assert all(entrant in svg for entrant in ENTRANTS)
    by_scheme = {row["scheme"]: row["x in H^1"] for row in rows if row["surface"] == "sphere"}
    assert by_scheme.pop("bgn") == "-" and "-" not in by_scheme.values()  # where nodes slide
    assert {row["theorem"] for row in written["schemes-orders"]["table"]} == {"none"}  # k = 1
    for extra in written.values():
        assert {"title", "text", "table"} <= extra.keys()


class TestCommand:
    def test_studies_are_judged_published_and_reported(self, command, tmp_path, monkeypatch):
        study = write_study(tmp_path, ('name = "small"', 'name = "schemes-small"'))
        monkeypatch.setattr("harness.comparison.command.scheme_studies", lambda: [study])
        runs, out = tmp_path / "runs", tmp_path / "out"
        status, said = command(
            "schemes", "--runs", runs, "--out", out, "--only", "studies", "--jobs", 1
        )
        assert status == 0 and "SUPER         schemes-small" in said
        assert read_results(out / "schemes-small")["verdict"] == "super"
        assert not list((out / "extra").iterdir())
        assert (runs / "schemes-small" / "records").is_dir()
        assert not (out / "schemes-small" / "records").exists()
        assert "schemes-small" in (out / "report" / "index.html").read_text()

    def test_a_part_that_is_none_is_refused_with_those_there_are(self, command, tmp_path):
        status, said = command("schemes", "--out", tmp_path, "--only", "costs")
        assert status == 2 and "--only costs" in said
        assert all(part in said for part in PARTS)

    def test_the_parts_are_those_that_can_be_computed(self):
        assert set(PARTS) == {"studies", *extras.PARTS}
