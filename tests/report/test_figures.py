"""What the figures of a report draw: the judged fit, what was masked, a history with its ends."""

import numpy as np
from pages import BASELINE

from esfem.flows.history import COLUMNS, History
from esfem.report.figures import MOST_LEVELS, fitted_points, masked_points, thinned
from esfem.results.result_files import load_result
from esfem.solver.laws import energy_of


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
