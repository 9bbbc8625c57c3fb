"""Measured floors: which, on what cells, in the units of the error, and what they mask."""

import numpy as np
import pandas as pd
import pytest
from studies import small_study, write_study

from esfem.measuring.lift import VARIABLES
from esfem.results.floors_table import COLUMNS, difference, floors_table
from esfem.results.remarks import floor_lines
from esfem.results.run_studies import run_studies
from esfem.runs.run_pair import PairRecord
from esfem.studies.study import load_study
from esfem.studies.variations import floor_pairs

ELLIPSOID = [
    ('name = "sphere"\nradius = 1.0', 'name = "breathing_ellipsoid"\namplitude = 0.25'),
    ("theta = false", "theta = true"),
    ('claim = "section-7"', 'claim = "order-k"'),
    ('superconvergent = { x = "A", nu = "B", H = "C" }\n', ""),
]
FINEST = [
    ("theta = false", "theta = true"),
    ('name = "sphere"\nradius = 1.0', 'name = "surface"\nsurface = "ellipsoid"'),
    ('claim = "section-7"', 'claim = "order-k"'),
    ('superconvergent = { x = "A", nu = "B", H = "C" }\n', ""),
    ("final_time = 0.5", "final_time = 0.5\ncompare_at = [0.5]"),
]


def study_of(tmp_path, *changes):
    return load_study(write_study(tmp_path, *changes))


class TestPairs:
    def test_a_moving_solution_has_a_floor_in_tau_one_at_rest_has_none(self, tmp_path):
        assert "tau" in floor_pairs(study_of(tmp_path, *ELLIPSOID))
        assert "tau" not in floor_pairs(study_of(tmp_path))

    def test_an_order_in_tau_has_no_floor_in_tau(self, tmp_path):
        claim = ('claim = "order-k"', 'claim = "bdf-order"')
        found = floor_pairs(study_of(tmp_path, *ELLIPSOID, claim))
        assert "rounding" in found and not {"tau", "quadrature"} & found.keys()

    def test_rounding_and_the_step_are_measured_on_the_finest_cell_the_rest_at_a_quarter(
        self, tmp_path
    ):
        found = floor_pairs(study_of(tmp_path, *ELLIPSOID))
        assert {name: pair.case.vertices for name, pair in found.items()} == {
            "rounding": 480,
            "tau": 480,
            "quadrature": 120,
        }
        assert {pair.case.tau for pair in found.values()} == {0.125}

    def test_errors_against_the_finest_level_have_floors_below_that_level(self, tmp_path):
        """All of them at one time step, so none in tau."""
        found = floor_pairs(study_of(tmp_path, *FINEST))
        assert {name: pair.case.vertices for name, pair in found.items()} == {
            "rounding": 240,
            "solver": 60,
            "quadrature": 60,
        }

    def test_the_two_differ_in_one_thing(self, tmp_path):
        for case, varied in floor_pairs(study_of(tmp_path, *ELLIPSOID)).values():
            plain, other = (c.model_dump() | {"scheme": None} for c in (case, varied))
            options = {k for k, v in case.scheme if v != getattr(varied.scheme, k)}
            assert len(options) + sum(plain[k] != other[k] for k in plain) == 1


class TestTable:
    @pytest.fixture
    def study(self, tmp_path):
        return study_of(tmp_path, *ELLIPSOID)

    def pair(self, study, **changes) -> PairRecord:
        """As if 3e-3 were between the two runs in every variable, and 10 % in area."""
        case, varied = floor_pairs(study)["tau"]
        numbers = {"area": [1.0, 2.0], "willmore": [1.0, 1.0], "volume": [1.0, 1.0]}
        given = {
            "case": case.model_dump(),
            "varied": varied.model_dump(),
            "mesh": {},
            "nodes": 1,
            "status": "ok",
            "stopped": "",
            "stopped_at": None,
            "reason": "",
            "t": [0.0, 1.0],
            "norms": {name: [3e-3, 1e-3] for name in (*VARIABLES, "distance")},
            "levels": numbers,
            "varied_levels": numbers | {"area": [1.0, 1.8]},
            "seconds": {"total": 1.0},
        }
        return PairRecord(**{**given, **changes})

    def table(self, study, **changes) -> pd.DataFrame:
        """The floor in tau by this pair, where errors are 1, and 0.1 without interpolation."""
        case = floor_pairs(study)["tau"].case
        sizes = {"err": 1.0, "nodal": 0.1}
        columns = {f"{of}_{name}": [sizes[of]] for of in sizes for name in study.variables}
        rows = pd.DataFrame({"vertices": [case.vertices], "tau": [case.tau], **columns})
        return floors_table(study, rows, {"tau": ("key", self.pair(study, **changes))})

    def test_the_largest_norm_is_a_part_of_the_error_in_time(self, study):
        """u_tau - u_{tau/2} = (1 - 2^-q) (u_tau - u), here with BDF2."""
        found = self.table(study)
        assert tuple(found.columns) == COLUMNS
        assert found["variable"].tolist() == list(study.variables)
        np.testing.assert_allclose(found["value"], 3e-3 / 0.75, rtol=1e-14)
        assert (found["error"] == 1.0).all() and (found["nodal"] == 0.1).all()

    def test_numbers_have_their_change_not_that_of_their_error(self, study):
        """Relative to themselves: the area is 1.8 in place of 2, in one run above an exact 1.9 and
        in the other below."""
        pair = self.pair(study)
        assert difference(study, "area", pair) == pytest.approx(0.1, rel=1e-14)
        assert difference(study, "volume", pair) == 0.0
        assert difference(study, "distance", pair) == 3e-3
        assert np.isnan(difference(study, "growth", pair))

    def test_a_claim_with_its_own_unit_of_length_has_a_floor_that_bounds_it(self, study, tmp_path):
        """Norms with L > 1 are too small for errors with 1, by L at most; distances have no L."""
        torus = [
            ('name = "sphere"\nradius = 1.0', 'name = "clifford_torus"'),
            ("bdf = 2", "bdf = 1"),
        ]
        of_paper = study_of(tmp_path, *torus)
        pair, L = self.pair(study), of_paper.initial.length
        assert of_paper.claimed_length == 1.0 < L
        assert difference(of_paper, "x", pair) == pytest.approx(3e-3 * L, rel=1e-14)
        assert difference(of_paper, "distance", pair) == difference(study, "x", pair) == 3e-3

    def test_a_decay_rate_has_its_change(self, tmp_path):
        mode = 'name = "perturbed_sphere"\namplitude = 0.01'
        study = study_of(
            tmp_path, ('name = "sphere"\nradius = 1.0', mode), ('claim = "section-7"', "")
        )
        t, rate = np.linspace(0.0, 0.1, 6), study.initial.decay_rate
        levels = [{"amplitude": list(np.exp(-r * t))} for r in (rate, 1.01 * rate)]
        pair = self.pair(
            study_of(tmp_path, *ELLIPSOID), t=list(t), levels=levels[0], varied_levels=levels[1]
        )
        assert difference(study, "decay", pair) == pytest.approx(0.01, rel=1e-9)

    def test_a_pair_of_which_one_stopped_tells_nothing(self, study):
        assert self.table(study, status="failed", stopped="varied")["value"].isna().all()

    def test_lines_show_the_share_in_both_errors(self, study):
        (line,) = floor_lines(self.table(study), study.variables)
        assert "x 4.0e-03/4.0e-02" in line
        (line,) = floor_lines(self.table(study).drop(columns="nodal"), study.variables)
        assert "x 4.0e-03," in line and "interpolation" not in line


def test_flow_maps_have_a_floor_where_they_are_judged(tmp_path):
    """Else one that never converges is no FAIL: the error may be in time, as far as known."""
    claim = ('claim = "order-k"', 'claim = "flow-map"')
    values = {"vertices": [30, 60], "tau": [0.02], "final_time": 0.06, "degree": 2}
    study = small_study(tmp_path, *ELLIPSOID, claim, **values)
    floors = run_studies([study], tmp_path / "out", jobs=1)[0].floors
    value = floors.query("variable == 'flow_map'").set_index("floor")["value"]
    assert {"tau", "rounding"} <= set(value.index)
    assert (value > 0).all() and value["rounding"] < 1e-9 < value["tau"] < 1.0


@pytest.fixture(scope="module")
def all_in_time(tmp_path_factory):
    """The breathing ellipsoid by BDF1 at a step so large that all of the error is of time."""
    folder = tmp_path_factory.mktemp("floors")
    values = {"vertices": [60, 120, 240, 480], "tau": [0.02], "final_time": 0.1, "degree": 3}
    study = small_study(folder, *ELLIPSOID, **values, bdf=1, reaction="implicit")
    return run_studies([study], folder / "out", jobs=1)[0]


def test_the_floor_in_time_is_the_error_where_all_of_it_is_of_time(all_in_time):
    """Of an error that is all in time, to first order in tau: within a factor of 2."""
    floors = all_in_time.floors.query("floor == 'tau'").set_index("variable")
    ratio = floors["value"] / floors["error"]
    assert set(ratio.index) == set(VARIABLES)
    assert ratio.between(0.5, 2.0).all()


def test_errors_that_are_all_in_time_are_no_failure_in_space(all_in_time):
    """They do not fall with h, in none of the variables, and no verdict says anything of h."""
    errors = all_in_time.records.sort_values("h")
    assert errors["err_nu"].pct_change().abs().max() < 0.05
    for verdict in all_in_time.verdicts:
        assert verdict.verdict == "inconclusive", verdict
        assert [masked.floor for masked in verdict.masked] == ["tau"] * len(errors)


def test_records_and_pairs_are_kept_apart(all_in_time):
    assert len(all_in_time.records) == 4
    assert set(all_in_time.floors["floor"]) == {"rounding", "tau", "solver", "quadrature"}
    stored = list((all_in_time.folder / "records").glob("*.json"))
    assert len(stored) == 4 + 4
