"""What is no table: one message that names column, value and bound."""

import numpy as np
import pandas as pd
import pytest
from judged import LADDER, grid, line

from esfem.common.bad_input import BadInput
from esfem.judging import Floor, judge_table
from esfem.judging.validate import identical, validated

GOOD = line(lambda h: h**2)


@pytest.mark.parametrize(
    ("table", "direction", "words"),
    [
        (GOOD.drop(columns="error"), "h", ["column error", "missing"]),
        (GOOD.drop(columns="h"), "h", ["column h", "missing"]),
        (GOOD, "tau", ["column tau", "missing"]),
        (GOOD.iloc[:0], "h", ["no rows"]),
        (GOOD.assign(h="coarse"), "h", ["column h", "coarse"]),
        (GOOD.assign(error="1e-3 or so"), "h", ["column error", "1e-3 or so"]),
        (GOOD.assign(error=-GOOD["error"]), "h", ["column error", "negative"]),
        (GOOD.assign(h=-LADDER), "h", ["column h", "not positive"]),
        (GOOD.assign(h=[*LADDER[:-1], 0.0]), "h", ["column h", "0 is not positive"]),
        (GOOD.assign(h=[*LADDER[:-1], np.nan]), "h", ["column h", "nan is not positive"]),
        (GOOD.assign(h=[*LADDER[:-1], np.inf]), "h", ["column h", "inf is not positive"]),
        (GOOD.assign(tau=0.0), "h", ["column tau", "0 is not positive"]),
        (GOOD.assign(h=LADDER[0]), "h", ["column h", "given twice"]),
        (pd.concat([GOOD, GOOD]), "h", ["column h", "given twice"]),
        (GOOD.assign(tau=0.1, final_time=[1.0] * 5 + [2.0]), "h", ["final_time", "1 and 2"]),
        (GOOD.assign(tau=0.3, final_time=1.0), "h", ["column tau", "not a whole number"]),
    ],
)
def test_bad_tables_are_named(table, direction, words):
    with pytest.raises(BadInput) as caught:
        judge_table(table, 2.0, direction=direction)
    assert all(word in str(caught.value) for word in words)
    assert "\n" not in str(caught.value)


def test_levels_come_coarse_before_fine():
    table = grid(lambda h, tau: h + tau).sample(frac=1.0, random_state=0)
    runs = validated(table, "h")
    assert (np.diff(runs.h) <= 0).all()


def test_runs_that_stopped_have_no_error():
    runs = validated(GOOD.assign(status=["ok"] * 5 + ["diverged"]), "h")
    assert np.isnan(runs.error[-1]) and np.isfinite(runs.error[:-1]).all()


def test_identical_errors_are_told_from_close_ones():
    assert identical(np.full(4, 0.3))
    assert not identical(np.array([0.3, 0.3, 0.3 * (1 + 1e-6)]))
    assert not identical(np.array([0.3, 0.3]))


@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_a_floor_is_a_number(value):
    with pytest.raises(ValueError, match="floor tau"):
        Floor("tau", value)


def test_a_floor_has_one_value_or_one_a_row():
    with pytest.raises(ValueError, match="floor tau: needs 1 value or 6, has 2"):
        judge_table(GOOD, 2.0, floors=[Floor("tau", (1.0, 2.0))])
