"""Orders in time at a rough start: what is measured, and what docs/rough-starts.md says of it."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import esfem
from esfem.campaigns.rough_starts import methods as runs
from esfem.campaigns.rough_starts import run as report
from esfem.campaigns.rough_starts.methods import METHODS, Method

ROOT = Path(esfem.__file__).parent.parent
RESULTS = ROOT / "results" / "rough-starts"
DOCS = (ROOT / "docs" / "rough-starts.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def found() -> pd.DataFrame:
    return pd.read_csv(RESULTS / "orders.csv")


def own(found: pd.DataFrame, q: int, m: int, stretch: int = 1, theta: bool = True) -> pd.DataFrame:
    keys = {"q": q, "first_steps": m, "stretch": stretch, "theta": theta}
    return found[np.logical_and.reduce([found[k] == v for k, v in keys.items()])]


def at(found: pd.DataFrame, q: int, m: int, tau: float) -> pd.Series:
    """The run of that tau."""
    (row,) = (line for _, line in own(found, q, m).iterrows() if np.isclose(line["tau"], tau))
    return row


def about(words: str) -> str:
    """The bullet of the page that begins with these words."""
    return DOCS.partition(f"- **{words}")[2].partition("\n- **")[0]


def spelt(value: float) -> str:
    """The size of a number as the page has it: 4.6e-3."""
    return f"{abs(value):.1e}".replace("e-0", "e-")


class TestMeasuring:
    def test_the_energy_is_that_of_the_axisymmetric_solver(self):
        law = runs.LAW
        flow = runs.SURFACE.initial().profile_flow(law.name, law.parameters, (0.0, runs.T))
        assert flow.energies == pytest.approx([6.98253138, runs.ENERGY], rel=0, abs=1e-8)

    def test_the_discrete_energy_starts_there(self):
        """P4 on V = 120: within 1e-5."""
        assert runs.energy(*runs.ground()) == pytest.approx(6.98253138, rel=0, abs=1e-5)

    def test_the_rates_are_those_of_the_unit_sphere(self):
        assert {l: (l - 1) * l * (l + 1) * (l + 2) for l in runs.RATES} == runs.RATES

    def test_the_order_of_a_power_is_its_exponent(self):
        assert runs.orders([64.0, 8.0, 1.0, 0.125]) == [3.0, 3.0]

    def test_rows_have_differences_of_successive_tau(self):
        """BDF2 in 5, 10, 20 and 40 steps: x and H at T from two rows, orders from four."""
        rows = runs.measured(Method(2, 4), halvings=3)
        assert list(rows["tau"]) == [0.02, 0.01, 0.005, 0.0025]
        assert list(rows["steps"]) == [5 + 6, 10 + 6, 20 + 6, 40 + 6]
        assert list(np.isfinite(rows["difference_H"])) == [True, True, True, False]
        ratio = rows["difference_x"][0] / rows["difference_x"][2]
        assert rows["order_x"][1] == pytest.approx(np.log2(ratio) / 2.0)
        assert list(np.isfinite(rows["order_x"])) == [False, True, False, False]
        assert (rows["error_E"].abs() < 2e-2).all()

    def test_the_reaction_is_the_one_that_is_written_down(self, found, tmp_path, monkeypatch):
        method = Method(2, 1)
        usual = runs.final(method, method.levels(5))
        monkeypatch.setattr(runs, "REACTION", "linearised")
        assert not np.allclose(runs.final(method, method.levels(5)).H, usual.H, rtol=0, atol=1e-6)
        report.write(found, tmp_path, 1.0)
        origin = json.loads((tmp_path / "origin.json").read_text())
        assert origin["parameters"]["reaction"] == "linearised"


class TestCommitted:
    def test_has_all_methods(self, found):
        assert len(found) == len(METHODS) * (runs.HALVINGS + 1)
        assert all(len(own(found, m.q, m.substeps, m.stretch, m.theta)) for m in METHODS)

    def test_the_table_is_that_of_the_runs(self, found):
        assert (RESULTS / "table.md").read_text(encoding="utf-8") == report.table(found)

    def test_the_figure_has_a_column_a_method(self, found):
        drawn = report.figure(found)
        assert [axis.get_title() for axis in drawn.axes[:4]] == ["BDF1", "BDF2", "BDF3", "BDF4"]


class TestDocs:
    """What it says in words, for the committed runs."""

    @pytest.mark.parametrize(
        ("q", "tau", "least", "most"),
        [
            *((q, 0.005, 3.0, 10.0) for q in (2, 3, 4)),
            *((1, 0.005, 1.0, 1.2), (3, 0.01, 0.0, 0.2)),
            *((1, 0.02, 0.5, 0.7), (2, 0.02, 5.0, 7.0), (3, 0.02, 1.5, 2.0), (4, 0.02, 0.95, 1.05)),
        ],
    )
    def test_four_substeps_divide_the_error_of_the_energy(self, found, q, tau, least, most):
        """By three to ten at tau = 0.005, but for BDF1; at larger tau by less or not at all."""
        errors = [at(found, q, m, tau)["error_E"] for m in (1, 4)]
        assert least < abs(errors[0] / errors[1]) < most
        paragraph = about("At τ = 0.005 the error" if tau == 0.005 else "At larger τ it depends")
        assert all(spelt(error) in paragraph for error in errors)

    @pytest.mark.parametrize(("q", "lower"), [(4, True), (2, False)])
    def test_four_substeps_lower_the_difference_of_H_at_the_largest_step(self, found, q, lower):
        sizes = [at(found, q, m, 0.02)["difference_H"] for m in (1, 4)]
        assert (sizes[1] < sizes[0]) == lower
        assert all(spelt(size) in about("At larger τ it depends") for size in sizes)

    def test_the_smallest_errors_of_the_energy_are_those_of_the_mesh(self, found):
        """That of BDF4 with most of the first steps divided is the mesh's alone."""
        mesh = own(found, 4, 16, stretch=4)["error_E"].iloc[-1]
        assert f"adds \N{MINUS SIGN}{spelt(mesh)} to each" in " ".join(DOCS.split())
        last = found[found["theta"] & (found["q"] > 1) & (found["tau"] == found["tau"].min())]
        assert len(last) == 15 and (abs(last["error_E"] - mesh) < 0.3 * abs(mesh)).all()

    def test_the_least_error_of_the_table_is_of_two_that_cancel(self, found):
        """It is on its way from one sign to the other."""
        errors = own(found, 2, 1)["error_E"].to_numpy()
        assert spelt(errors[-2]) == "3.0e-7"
        assert errors[-3] > 1e-4 and errors[-1] < -3e-5

    def test_the_reaction_that_it_names_is_that_of_the_runs(self):
        assert f'reaction = "{runs.REACTION}"' in DOCS

    @pytest.mark.parametrize("q", [2, 3, 4])
    def test_at_small_steps_the_gain_is_two_to_five(self, found, q):
        plain, divided = (
            run["difference_H"].iloc[5] for run in (own(found, q, 1), own(found, q, 16))
        )
        assert 1.9 < plain / divided < 5.0

    @pytest.mark.parametrize("q", [1, 2])
    def test_low_orders_are_seen_where_the_mode_6_is_resolved(self, found, q):
        orders = own(found, q, 1).query("tau_rate < 2.5")["order_H"].dropna()
        assert len(orders) >= 2 and (abs(orders - q) < 0.25).all()

    @pytest.mark.parametrize("q", [3, 4])
    def test_high_orders_are_not_seen_with_or_without_substeps(self, found, q):
        for m in (1, 4, 16, 64):
            orders = report.trusted(own(found, q, m).query("tau_rate < 9")).dropna()
            assert len(orders) >= 3 and (orders < 2.4).all(), m

    def test_what_is_left_is_from_the_end_of_the_substeps(self, found):
        """Divided to four times as far, BDF4 is ten times as accurate at tau = 0.005 and 0.0025."""
        near, far = (own(found, 4, 16, stretch)["difference_H"].iloc[2:4] for stretch in (1, 4))
        assert (near.to_numpy() > 10.0 * far.to_numpy()).all()

    def test_its_rows_are_those_of_the_program(self):
        rows = [line for line in DOCS.splitlines() if line.startswith("|")]
        assert rows == (RESULTS / "table.md").read_text(encoding="utf-8").splitlines()
