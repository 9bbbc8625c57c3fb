"""Columns of a table, and what of it is judged."""

import numpy as np
import pytest
from judged import LADDER, grid, line

from esfem.common.bad_input import BadInput
from esfem.judging import Floor
from esfem.judging.floors import near_floors, rounding_floor
from esfem.judging.second_mesh import falls_with_h
from esfem.judging.slices import FAILED, GROWN, TURNED, judged_slice, path, spread_enough
from esfem.judging.table_columns import column_names, numbers
from esfem.judging.validate import validated


class TestColumns:
    @pytest.mark.parametrize("values", [[1, 2], ["1", "2e0"], np.array([1.0, 2.0])])
    def test_numbers_may_be_written_in_any_way(self, values):
        assert numbers({"h": values}, "h").tolist() == [1.0, 2.0]

    def test_what_is_missing_is_nan(self):
        assert np.isnan(numbers({"error": [None, float("nan")]}, "error")).all()

    def test_what_is_no_number_is_named_by_its_row(self):
        with pytest.raises(BadInput, match="column h, row 2: 'fine' is not a number"):
            numbers({"h": [1.0, "fine"]}, "h")

    def test_columns_are_as_long_as_each_other(self):
        with pytest.raises(BadInput, match="column h: has 2 rows, column error 3"):
            validated({"h": [1.0, 0.5], "error": [1.0, 0.5, 0.2]}, "h")

    def test_a_structured_array_has_names(self):
        table = np.array([(1.0, 2.0)], dtype=[("h", float), ("error", float)])
        assert column_names(table) == ["h", "error"]


class TestPath:
    @pytest.mark.parametrize("gamma", [0.5, 1.0, 2.0, 1.37])
    def test_a_power_is_found(self, gamma):
        table = line(LADDER).assign(tau=0.3 * LADDER**gamma)
        assert path(validated(table, "h")) == pytest.approx(gamma)

    def test_steps_that_end_on_the_final_time_are_still_one(self):
        tau = 1.0 / np.round(7.0 / LADDER)
        assert path(validated(line(LADDER).assign(tau=tau), "h")) == 1.0

    @pytest.mark.parametrize("tau", [0.1, LADDER[::-1], [0.1, 0.1, 0.05, 0.05, 0.02, 0.02]])
    def test_anything_else_is_none(self, tau):
        assert np.isnan(path(validated(line(LADDER).assign(tau=tau), "h")))
        assert np.isnan(path(validated(line(LADDER), "h")))


class TestLine:
    def runs(self, errors, floors=()):
        return near_floors(validated(line(errors), "h"), floors)

    def test_what_is_coarser_than_a_failure_is_masked(self):
        errors = LADDER**2
        errors[1] = np.nan
        part = judged_slice(self.runs(errors), "h", False, 4)
        assert part.s.tolist() == LADDER[2:].tolist()
        assert part.runs.reason[0] == FAILED

    def test_what_is_coarser_than_a_level_at_a_floor_is_masked(self):
        errors = LADDER**2
        errors[2] = 1e-9
        part = judged_slice(self.runs(errors, [Floor("solver", 1e-9)]), "h", False, 3)
        assert part.s.tolist() == LADDER[3:].tolist()
        assert part.runs.reason[:2].tolist() == [TURNED, TURNED]

    def test_floors_at_the_fine_end_leave_the_coarse_one(self):
        errors = np.maximum(LADDER**2, 0.06)
        part = judged_slice(self.runs(errors, [Floor("solver", 0.01)]), "h", False, 3)
        assert part.s.tolist() == LADDER[: len(part.s)].tolist() and 0 < len(part.s) < 6

    def test_what_grows_from_rounding_is_rounding(self):
        errors = 1e-14 * 4.0 ** np.arange(6)
        part = judged_slice(self.runs(errors), "h", False, 4)
        assert len(part.s) == 0 and GROWN in part.runs.reason

    def test_what_falls_is_not(self):
        errors = [1e-15, *LADDER[1:] ** 2]
        part = judged_slice(self.runs(errors), "h", False, 4)
        assert len(part.s) == 5

    def test_the_finest_line_with_enough_levels_is_judged(self):
        table = grid(lambda h, tau: h**2 + tau)
        table.loc[(table["tau"] == 0.025) & (table["h"] < 0.4), "error"] = np.nan
        part = judged_slice(near_floors(validated(table, "h"), ()), "h", True, 4)
        assert set(part.line.tau) == {0.05} and part.grid is None

    def test_four_levels_need_a_range(self):
        assert spread_enough(np.array([1.0, 0.8, 0.6, 0.4]), 4)
        assert not spread_enough(np.array([1.0, 0.8, 0.6, 0.41]), 4)
        assert not spread_enough(np.array([1.0, 0.5, 0.25]), 4)


class TestRounding:
    def test_the_assumed_floor_is_that_of_the_largest_value(self):
        eps = np.finfo(float).eps
        assert rounding_floor(np.array([1e-3, np.nan])) == eps
        assert rounding_floor(np.array([1e3, 1.0])) == 1e3 * eps

    def test_a_given_one_takes_its_place(self):
        table = line(1e-16 * LADDER**2)
        assert not near_floors(validated(table, "h"), ()).clear.any()
        assert near_floors(validated(table, "h"), [Floor("rounding", 0.0)]).clear.all()


class TestSecondMesh:
    @pytest.mark.parametrize(("e", "falls"), [(lambda h, tau: h**2, True), (1.0, False)])
    def test_it_tells_whether_errors_are_in_space(self, e, falls):
        table = grid(e if callable(e) else lambda h, tau: e + 0 * h, h=LADDER[:2])
        assert falls_with_h(validated(table, "tau"), 2.0) is falls

    def test_one_mesh_tells_nothing(self):
        table = grid(lambda h, tau: tau, h=LADDER[:1])
        assert falls_with_h(validated(table, "tau"), 2.0) is None
