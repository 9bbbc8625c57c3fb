"""Lines of records.csv, also of runs that stopped early."""

from dataclasses import replace

import numpy as np
import pytest
from studies import write_study

from esfem.measuring.lift import VARIABLES
from esfem.meshes import surface_mesh
from esfem.results.records import record_row, run_errors
from esfem.runs.recorder import TABLES
from esfem.runs.run_case import run_case
from esfem.studies.study import load_study


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    case = load_study(write_study(tmp_path_factory.mktemp("study"))).cases()[0]
    return run_case(case, surface_mesh("sphere", 30))[0]


def test_the_errors_are_the_largest_over_the_time_levels(record):
    row = record_row("small", "key", record)
    assert row["err_nu"] == max(record.h1()["nu"])
    assert row["err_nu_l2"] == max(record.l2["nu"])
    assert row["t_nu"] == record.t[int(np.argmax(record.h1()["nu"]))]
    assert row["nodal_nu"] == max(record.nodal_h1()["nu"])
    assert row["nodal_nu_l2"] == max(record.nodal_l2["nu"])
    assert row["t_nodal_nu"] == record.t[int(np.argmax(record.nodal_h1()["nu"]))]
    assert row["idle_nu"] == max(record.idle_h1()["nu"])
    assert row["length"] == 1.0 and row["moved"] is True
    assert row["energy_T"] == record.levels["energy"][-1]


@pytest.mark.parametrize("levels", [0, 1, 2])
def test_a_run_that_stopped_has_a_line_without_errors(record, levels):
    stopped = replace(
        record,
        status="diverged",
        stopped_at=0.25 * levels,
        t=record.t[:levels],
        **{table: cut(getattr(record, table), levels) for table in TABLES},
        iterations=[],
    )
    row, whole = record_row("small", "key", stopped), record_row("small", "key", record)
    assert np.isnan(row["err_x"]) and np.isnan(row["growth_rate"]) and np.isnan(row["energy_T"])
    assert np.isnan(row["energy_0"]) == np.isnan(row["willmore_0"]) == (levels == 0)
    assert np.isnan([row["willmore_T"], row["energy_rise"]]).all()
    assert row.keys() == whole.keys()
    errors = [name for name in row if name.startswith(("err_", "t_", "nodal_", "idle_"))]
    # Seven columns a variable, growth, and the balance of the energy.
    assert len(errors) == 7 * 6 + 2 and np.isnan([row[name] for name in errors]).all()


def cut(series: dict[str, list[float]], levels: int) -> dict[str, list[float]]:
    """What a run has measured that stopped before that level."""
    return {name: values[:levels] for name, values in series.items()} if levels else {}


def test_another_unit_of_length_weighs_the_values_against_the_gradients(record):
    """Every norm in H^1, by its definition from the two that have a unit."""
    for L in (0.5, 3.0):
        row = run_errors(record, L)
        for name in VARIABLES:
            for kind, l2, seminorm in (
                ("err", record.l2, record.seminorm),
                ("nodal", record.nodal_l2, record.nodal_seminorm),
                ("idle", record.idle_l2, record.idle_seminorm),
            ):
                squares = np.square(l2[name]) / L**2 + np.square(seminorm[name])
                expected = np.sqrt(squares).max()
                assert row[f"{kind}_{name}"] == pytest.approx(expected, rel=1e-14, abs=0)
    assert run_errors(record) == run_errors(record, record.length)


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
