"""Orders in time at a rough start: what is measured, and what docs/rough-starts.md says of it."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

import harness
from harness.rough_starts import report, runs
from harness.rough_starts.runs import METHODS, Method

ROOT = Path(harness.__file__).parent.parent
RESULTS = ROOT / report.OUT
DOCS = (ROOT / "docs" / "rough-starts.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def found() -> pd.DataFrame:
    return pd.read_csv(RESULTS / "orders.csv")


def own(found: pd.DataFrame, q: int, m: int, stretch: int = 1, theta: bool = True) -> pd.DataFrame:
    keys = {"q": q, "first_steps": m, "stretch": stretch, "theta": theta}
    return found[np.logical_and.reduce([found[k] == v for k, v in keys.items()])]


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


class TestCommitted:
    def test_has_all_methods(self, found):
        assert len(found) == len(METHODS) * (runs.HALVINGS + 1)
        assert all(len(own(found, m.q, m.substeps, m.stretch, m.theta)) for m in METHODS)

    def test_the_table_is_that_of_the_runs(self, found):
        assert (RESULTS / "table.md").read_text(encoding="utf-8") == report.table(found)

    def test_the_figure_has_a_column_a_method(self, found):
        drawn = report.figure(found)
        assert [axis.get_title() for axis in drawn.axes[:4]] == ["BDF1", "BDF2", "BDF3", "BDF4"]
        plt.close(drawn)


class TestDocs:
    """What it says in words, for the committed runs."""

    @pytest.mark.parametrize("q", [2, 3, 4])
    def test_four_substeps_lower_the_error_of_a_large_step_three_to_ten_times(self, found, q):
        plain, divided = (
            run[run["tau"] == 0.005]["error_E"].abs().item()
            for run in (own(found, q, 1), own(found, q, 4))
        )
        assert 3.0 < plain / divided < 10.0

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
        rows = [line for line in DOCS.splitlines() if line.startswith("| BDF")]
        table = (RESULTS / "table.md").read_text(encoding="utf-8").splitlines()
        assert len(rows) >= 8 and all(row in table for row in rows)
