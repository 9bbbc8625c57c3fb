"""Lines of records.csv, also of runs that stopped early."""

from dataclasses import replace

import numpy as np
import pytest
from studies import write_study

from esfem.meshes import surface_mesh
from esfem.results.records import record_row
from esfem.runs.run_case import run_case
from esfem.studies.study import load_study


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    case = load_study(write_study(tmp_path_factory.mktemp("study"))).cases()[0]
    return run_case(case, surface_mesh("sphere", 30))[0]


def test_the_errors_are_the_largest_over_the_time_levels(record):
    row = record_row("small", "key", record)
    assert row["err_nu"] == max(record.h1["nu"])
    assert row["err_nu_l2"] == max(record.l2["nu"])
    assert row["energy_T"] == record.levels["energy"][-1]


@pytest.mark.parametrize("levels", [0, 1, 2])
def test_a_run_that_stopped_has_a_line_without_errors(record, levels):
    stopped = replace(
        record,
        status="diverged",
        stopped_at=0.25 * levels,
        t=record.t[:levels],
        h1={name: series[:levels] for name, series in record.h1.items()} if levels else {},
        l2={name: series[:levels] for name, series in record.l2.items()} if levels else {},
        levels={n: series[:levels] for n, series in record.levels.items()} if levels else {},
        iterations=[],
    )
    row, whole = record_row("small", "key", stopped), record_row("small", "key", record)
    assert np.isnan(row["err_x"]) and np.isnan(row["growth_rate"]) and np.isnan(row["energy_T"])
    assert np.isnan(row["energy_0"]) == np.isnan(row["willmore_0"]) == (levels == 0)
    assert np.isnan([row["willmore_T"], row["energy_rise"]]).all()
    assert {name for name in whole if not name.startswith(("t_", "err_"))} == {
        name for name in row if not name.startswith(("t_", "err_"))
    }


def test_columns_stand_in_the_order_of_the_record(record):
    """Not in that of a set, which is another one in each process: files would never repeat."""
    names = ["W", "area", "volume", "distance", "distance_mean", "distance_back", "other", "last"]
    compared = {"t": [0.1, 0.2], **{name: [1.0, 2.0] for name in names}}
    columns = list(record_row("small", "key", replace(record, compared=compared)))
    own = [c for c in columns if c.removeprefix("err_").removesuffix("_at_0.1") in names]
    assert own == [c for name in names for c in (f"err_{name}", f"err_{name}_at_0.1")]


def test_a_line_says_which_options_the_scheme_had(record):
    """Also those of an ablation, which no study file may have."""
    scheme = {**record.case["scheme"], "reaction": "implicit-F1"}
    case = {**record.case, "scheme": scheme, "first_steps": 3}
    row, plain = (record_row("small", "key", r) for r in (replace(record, case=case), record))
    assert (plain["reaction"], row["reaction"]) == ("extrapolated", "implicit-F1")
    assert (plain["first_steps"], row["first_steps"]) == (1, 3)
    # Each of the two first steps of BDF2 is made of three.
    assert row["steps"] == plain["steps"] + 4
