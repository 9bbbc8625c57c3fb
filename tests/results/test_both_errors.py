"""Verdicts of a variable from two errors, u_h - u and u_h - I_h u, on planted records: each rule
with a table that breaks it, and tables of methods that are wrong as a whole."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd
import pytest
from studies import write_study

from esfem.judging.outcome import exit_status
from esfem.measuring.lift import VARIABLES
from esfem.reference_solutions import STARTS, StationarySphere
from esfem.results.remarks import masked_lines, reasons
from esfem.results.study_result import judged
from esfem.results.tables import verdict_table, verdicts_frame
from esfem.results.verdicts import judge
from esfem.studies.claims import claims
from esfem.studies.study import STUDIES, load_study

LADDER = [30, 60, 120, 240, 480, 960]
STEPS = (0.2, 0.1, 0.05, 0.025, 0.0125)
CLAIMED = ("x", "nu", "H")


def sphere_at_rest(h, tau):
    """The plain error is that of the interpolation, and so is what the initial State scores."""
    return {"err": 0.7 * h**2, "nodal": 0.3 * h**3, "idle": 0.7 * h**2}


def good(h, tau):
    """Of a solution that moves by 1: orders 2 in h and in tau."""
    error = 0.7 * h**2 + 0.01 * tau**2
    return {"err": error, "nodal": 0.4 * error, "idle": 1.0}


def records(errors=good, taus=(0.1, 0.05), moved=True, statuses=(), **of_variable) -> pd.DataFrame:
    """Records of both errors of all variables, and of the score of the initial State, from
    functions of (h, tau); ``statuses`` are those of cells that stopped."""
    rows = []
    for tau in taus:
        for vertices in LADDER:
            h, status = vertices**-0.5, dict(statuses).get((vertices, tau), "ok")
            row = {"vertices": vertices, "nodes": 4 * vertices - 6, "tau": tau, "h": h}
            row |= {"status": status, "stopped_at": np.nan if status == "ok" else 0.3}
            row |= {"seconds": vertices / tau, "final_time": 1.0, "moved": moved}
            for name in VARIABLES:
                found = of_variable.get(name, errors)(h, tau)
                keys = {f"{kind}_{name}": found[kind] for kind in ("err", "nodal", "idle")}
                row |= keys if status == "ok" else dict.fromkeys(keys, np.nan)
            rows.append(row)
    return pd.DataFrame(rows)


def with_sweep(study, taus=(0.1, 0.05)):
    sweep = study.sweep.model_copy(update={"vertices": LADDER, "tau": list(taus)})
    return study.model_copy(update={"sweep": sweep})


@dataclass(frozen=True)
class Moving(StationarySphere):
    stationary: ClassVar[bool] = False


@pytest.fixture
def at_rest(tmp_path):
    return with_sweep(load_study(write_study(tmp_path)))


@pytest.fixture
def study(tmp_path, monkeypatch):
    """Of a solution that moves, judged in h."""
    monkeypatch.setitem(STARTS, "sphere", Moving)
    return with_sweep(load_study(write_study(tmp_path)))


@pytest.fixture
def in_tau(tmp_path, monkeypatch):
    """Of a solution that moves, judged in tau: order 2."""
    monkeypatch.setitem(STARTS, "sphere", Moving)
    return with_sweep(load_study(write_study(tmp_path, ("section-7", "bdf-order"))), STEPS)


def of(verdicts, variable):
    return next(v for v in verdicts if v.variable == variable)


def outcomes(study, table, variable="x", floors=None) -> list[str]:
    """Those of both errors, and of the variable."""
    verdict = of(judge(study, table, floors), variable)
    return [*(part.outcome for part in verdict.parts), verdict.verdict]


def measured(floor, value, tau=0.05, variables=VARIABLES) -> pd.DataFrame:
    """A floor of the variables, as floors.csv has it."""
    return pd.DataFrame({"floor": floor, "variable": list(variables), "tau": tau, "value": value})


ROUNDING = measured("rounding", 1e-13)


def outcome(study, table, tmp_path, floors=ROUNDING) -> str:
    return judged(study, tmp_path, table, floors).outcome


class TestParts:
    def test_both_errors_are_judged_and_the_first_of_equals_decides(self, study):
        verdict = of(judge(study, records()), "x")
        assert [part.name for part in verdict.parts] == ["error", "interpolation"]
        assert outcomes(study, records()) == ["pass"] * 3
        assert verdict.deciding is verdict.parts[0]

    @pytest.mark.parametrize("bad", ["err", "nodal"])
    def test_the_worst_of_the_exercised_errors_decides(self, study, bad):
        table = records(x=lambda h, tau: {**good(h, tau), bad: 0.05 * h})
        expected = {"err": ["fail", "pass", "fail"], "nodal": ["pass", "fail", "fail"]}
        assert outcomes(study, table) == expected[bad]
        assert of(judge(study, table), "nu").verdict == "pass"

    def test_the_numbers_are_those_of_the_error_that_decides(self, study):
        verdict = of(judge(study, records(x=lambda h, t: {**good(h, t), "nodal": 0.05 * h})), "x")
        assert verdict.observed == pytest.approx(1.0) and verdict.error == verdict.parts[1].error
        assert verdict.deciding.column("x") == "nodal_x"

    def test_an_error_that_is_not_exercised_leaves_the_verdict_to_the_other(self, at_rest):
        assert outcomes(at_rest, records(sphere_at_rest)) == ["not exercised", "super", "super"]
        wrong = records(x=lambda h, tau: {**sphere_at_rest(h, tau), "nodal": 0.3 * h})
        assert outcomes(at_rest, wrong) == ["not exercised", "fail", "fail"]

    def test_a_table_without_errors_against_the_interpolation_has_one_part(self, study):
        table = records().drop(columns=[f"nodal_{name}" for name in VARIABLES])
        assert [part.name for part in of(judge(study, table), "x").parts] == ["error"]

    def test_two_parts_of_one_name_are_refused(self, study):
        from dataclasses import replace

        verdict = of(judge(study, records()), "x")
        for parts in ((), verdict.parts[:1] * 2):
            with pytest.raises(ValueError, match="must be different errors"):
                replace(verdict, parts=parts)


class TestExercised:
    @pytest.mark.parametrize(("times", "expected"), [(9.9, "not exercised"), (10.1, "pass")])
    def test_the_initial_state_must_score_ten_times_the_error_on_the_finest_level(
        self, study, times, expected
    ):
        finest = good(LADDER[-1] ** -0.5, 0.05)["err"]
        table = records(x=lambda h, tau: {**good(h, tau), "idle": times * finest})
        assert outcomes(study, table) == [expected, "pass", "pass"]

    def test_on_coarser_levels_it_need_not(self, study):
        coarse = good(LADDER[0] ** -0.5, 0.05)["err"]
        assert good(LADDER[-1] ** -0.5, 0.05)["err"] < coarse / 10
        table = records(x=lambda h, tau: {**good(h, tau), "idle": coarse})
        assert outcomes(study, table)[0] == "pass"

    def test_it_is_so_in_tau_as_well(self, in_tau):
        def of_time(h, tau):
            return {"err": tau**2, "nodal": tau**2, "idle": 1.0}

        assert outcomes(in_tau, records(of_time, STEPS)) == ["pass"] * 3
        finest = 9.0 * min(STEPS) ** 2
        table = records(of_time, STEPS, x=lambda h, t: {**of_time(h, t), "idle": finest})
        assert outcomes(in_tau, table) == ["not exercised", "pass", "pass"]

    def test_at_rest_it_measures_the_interpolation_alone_and_says_so(self, at_rest):
        (part, _) = of(judge(at_rest, records(sphere_at_rest)), "x").parts
        assert part.reason.endswith("it measures the interpolation alone")
        assert np.isfinite(part.observed)

    def test_an_older_table_is_judged_and_says_that_the_score_is_not_known(self, at_rest):
        table = records(sphere_at_rest).drop(columns=[f"idle_{name}" for name in VARIABLES])
        (part, other) = of(judge(at_rest, table), "x").parts
        assert part.outcome == "pass" and "kept for ever scores is not known" in part.reason
        assert "not known" not in other.reason

    @pytest.mark.parametrize("kind", ["zero", "rounding"])
    def test_an_error_against_the_interpolation_at_rounding_is_not_exercised(self, study, kind):
        size = 0.0 if kind == "zero" else 1e-13
        floors = measured("rounding", 5e-13)
        table = records(x=lambda h, tau: {**good(h, tau), "nodal": size / h})
        assert outcomes(study, table, floors=floors) == ["pass", "not exercised", "pass"]

    def test_where_neither_is_exercised_nothing_is(self, at_rest):
        table = records(lambda h, tau: {**sphere_at_rest(h, tau), "nodal": 0.0})
        assert outcomes(at_rest, table, floors=ROUNDING) == ["not exercised"] * 3

    def test_zeros_prove_nothing_where_no_rounding_was_measured(self, at_rest, tmp_path):
        """What was solved for may be compared with itself."""
        table = records(lambda h, tau: {**sphere_at_rest(h, tau), "nodal": 0.0})
        for floors in (None, pd.DataFrame(), measured("solver", np.nan), measured("tau", 1e-9)):
            assert outcomes(at_rest, table, floors=floors)[1:] == ["inconclusive"] * 2
        assert outcome(at_rest, table, tmp_path, pd.DataFrame()) == "inconclusive"


class TestWholeStudies:
    def test_nothing_exercised_is_not_green(self, at_rest, tmp_path):
        table = records(lambda h, tau: {**sphere_at_rest(h, tau), "nodal": 0.0})
        assert outcome(at_rest, table, tmp_path) == "not exercised"
        assert exit_status(["not exercised"]) == 3

    def test_one_exercised_variable_is_enough(self, at_rest, tmp_path):
        still = lambda h, tau: {**sphere_at_rest(h, tau), "nodal": 0.0}  # noqa: E731
        assert outcome(at_rest, records(still, x=sphere_at_rest), tmp_path) == "super"

    def test_what_is_not_claimed_does_not_make_a_study_green(self, at_rest, tmp_path):
        still = lambda h, tau: {**sphere_at_rest(h, tau), "nodal": 0.0}  # noqa: E731
        assert outcome(at_rest, records(still, z=good), tmp_path) == "not exercised"

    @pytest.mark.parametrize(
        ("several", "status"),
        [
            (["pass", "super", "no claim"], 0),
            (["pass", "not exercised"], 3),
            (["pass", "inconclusive"], 3),
            (["fail", "not exercised", "inconclusive"], 1),
            (["suspect", "pass"], 1),
            ([], 0),
        ],
    )
    def test_of_several_studies_each_counts(self, several, status):
        assert exit_status(several) == status

    def test_a_failed_cell_off_the_judged_line_does_not_matter(self, study):
        for status in ("failed", "diverged"):
            table = records(statuses=[((30, 0.1), status)])
            assert outcomes(study, table) == ["pass"] * 3

    def test_a_failed_cell_on_it_is_masked_as_a_diverged_one_is(self, study):
        for status in ("failed", "diverged"):
            verdict = of(judge(study, records(statuses=[((30, 0.05), status)])), "x")
            assert verdict.vertices == tuple(LADDER[1:]) and verdict.tau == (0.05,)
            assert [m.reason for m in verdict.masked] == [status]


class TestStatesThatNeverChange:
    def test_every_claimed_variable_is_not_exercised_and_why(self, study, tmp_path):
        table = records(moved=False)
        for name in CLAIMED:
            assert outcomes(study, table, name) == ["not exercised"] * 3
        assert "the States never change" in reasons(judge(study, table))[0]
        assert outcome(study, table, tmp_path) == "not exercised"

    def test_claims_with_a_limit_are_not_exercised_either(self, tmp_path):
        """A scheme that does nothing keeps H, V and z of a sphere at rest, and normals of unit
        length."""
        for name in ("theta-at-rest", "growth-projected"):
            study = with_sweep(load_study(STUDIES / f"{name}.toml"))
            table = records(lambda h, tau: dict.fromkeys(("err", "nodal", "idle"), 0.0))
            table["err_growth"] = 0.0
            assert outcome(study, table, tmp_path) == "pass"
            assert outcome(study, table.assign(moved=False), tmp_path) == "not exercised"

    def test_one_run_that_moves_is_enough(self, study):
        table = records(moved=False)
        table.loc[3, "moved"] = True
        assert outcomes(study, table) == ["pass"] * 3

    def test_a_run_that_stopped_and_moved_is_not(self, study):
        table = records(moved=False, statuses=[((30, 0.1), "diverged")])
        table.loc[table["status"] != "ok", "moved"] = True
        assert outcomes(study, table)[-1] == "not exercised"

    def test_an_older_table_does_not_tell(self, study):
        for table in (records().drop(columns="moved"), records(moved=None)):
            assert outcomes(study, table) == ["pass"] * 3


class TestWrongMethods:
    """What a whole study says of them: nowhere green."""

    @staticmethod
    def do_nothing(h, tau):
        error = 1.0 + 0.1 * h**2
        return {"err": error, "nodal": 1.0, "idle": error}

    @staticmethod
    def half_speed(h, tau):
        return {"err": 0.5 + 0.1 * h**2, "nodal": 0.5, "idle": 1.0}

    @staticmethod
    def late(h, tau):
        return {"err": 0.5 * tau + 1e-4 * h**2, "nodal": 0.5 * tau, "idle": 1.0}

    def test_do_nothing_is_not_green(self, study, in_tau, tmp_path):
        for one, taus in ((study, (0.1, 0.05)), (in_tau, STEPS)):
            table = records(self.do_nothing, taus, moved=False)
            assert outcome(one, table, tmp_path) == "not exercised"
            assert outcome(one, table.drop(columns="moved"), tmp_path) == "fail"

    def test_do_nothing_at_rest_is_not_green(self, at_rest, tmp_path):
        table = records(lambda h, tau: {**sphere_at_rest(h, tau), "nodal": 0.0})
        assert outcome(at_rest, table, tmp_path) == "not exercised"

    @pytest.mark.parametrize("scatter", [0.0, 0.01])
    def test_half_speed_fails_in_h(self, study, scatter):
        """Be it one number or not; where the part in time was measured, that is no excuse."""

        def half_speed(h, tau):
            nodal = 0.5 * (1.0 + scatter * np.sin(1e3 * h))
            return {"err": nodal + 0.1 * h**2, "nodal": nodal, "idle": 1.0}

        floors = measured("tau", 1e-4)
        assert outcomes(study, records(half_speed), floors=floors)[1:] == ["fail"] * 2

    def test_half_speed_fails_in_tau(self, in_tau):
        verdict = of(judge(in_tau, records(self.half_speed, STEPS)), "x")
        assert verdict.verdict == "fail"
        assert verdict.reason.startswith("the errors do not fall with tau, nor with h")

    def test_late_fails_in_tau(self, in_tau):
        assert outcomes(in_tau, records(self.late, STEPS)) == ["fail"] * 3
        assert of(judge(in_tau, records(self.late, STEPS)), "x").observed == pytest.approx(1, 0.1)


class TestSharp:
    @pytest.fixture
    def sharp(self, study, monkeypatch):
        found = claims()["section-7"].model_copy(update={"sharp": True})
        monkeypatch.setattr("esfem.studies.study.claims", lambda: {"section-7": found})
        return study

    @pytest.mark.parametrize("order", [3.0, 4.0])
    def test_of_the_plain_error_alone(self, sharp, order):
        plain = records(x=lambda h, tau: {**good(h, tau), "err": h**order})
        assert outcomes(sharp, plain) == ["fail", "pass", "fail"]
        nodal = records(x=lambda h, tau: {**good(h, tau), "nodal": h**order})
        assert outcomes(sharp, nodal) == ["pass", "super", "super"]


class TestSuperconvergence:
    FAST: ClassVar = {"x": lambda h, tau: {"err": h**4, "nodal": h**4, "idle": 1.0}}

    def judged(self, study, declared):
        about = study.study.model_copy(update={"superconvergent": declared})
        return of(judge(study.model_copy(update={"study": about}), records(**self.FAST)), "x")

    @pytest.mark.parametrize(
        ("declared", "expected"),
        [
            ({"x": "why"}, ["super", "super"]),
            ({"interpolation": {"x": "why"}}, ["suspect", "super"]),
            ({"error": {"x": "why"}}, ["super", "suspect"]),
            ({"nu": "why"}, ["suspect", "suspect"]),
        ],
    )
    def test_is_declared_of_both_errors_or_of_one(self, study, declared, expected):
        assert [part.outcome for part in self.judged(study, declared).parts] == expected

    def test_its_sentence_is_shown_with_the_verdict(self, study):
        (_, part) = self.judged(study, {"interpolation": {"x": "because"}}).parts
        assert part.reason.endswith("; more is declared: because")


class TestTimeInSpace:
    """A measured part in time: no model, and no plateau."""

    @staticmethod
    def floors(value, tau=0.05):
        return pd.DataFrame(
            {"floor": "tau", "variable": ["x"], "tau": tau, "value": value, "vertices": 240}
        )

    @staticmethod
    def in_quadrature(h, tau):
        error = np.hypot(0.7 * h**2, 0.02 * tau**2)
        return {"err": error, "nodal": 0.9 * error, "idle": 1.0}

    def test_the_judged_line_is_taken_alone(self, study):
        table = records(self.in_quadrature)
        assert outcomes(study, table, floors=self.floors(0.02 * 0.05**2)) == ["pass"] * 3
        other = table["tau"] == 0.1
        table.loc[other, ["err_x", "nodal_x"]] *= 1.5
        assert outcomes(study, table, floors=self.floors(0.02 * 0.05**2)) == ["pass"] * 3

    def test_a_floor_near_the_errors_masks_them_and_decides_nothing(self, study):
        flat = records(lambda h, tau: {"err": 0.1, "nodal": 0.1 + 0.01 * h**3, "idle": 10.0})
        found = outcomes(study, flat.assign(err_x=0.1 + flat["h"] ** 3), floors=self.floors(0.02))
        assert found[0] == "inconclusive"

    def test_a_floor_at_one_time_step_is_larger_at_a_larger_one(self, study):
        """Of order 2: four times at twice the step, where the errors are near it."""
        stopped = [((v, 0.05), "diverged") for v in (120, 240, 480, 960)]
        table = records(statuses=stopped)
        least = table.loc[table["tau"] == 0.1, "err_x"].min()
        masked = of(judge(study, table, self.floors(least / 30.0)), "x").parts[0].masked
        assert {m.floor for m in masked if m.tau == 0.1} == {"tau"}
        masked = of(judge(study, table, self.floors(least / 50.0)), "x").parts[0].masked
        assert {m.floor for m in masked if m.tau == 0.1} == set()


class TestShown:
    def test_a_row_an_error_says_which_and_which_decides(self, study):
        table = records(x=lambda h, tau: {**good(h, tau), "nodal": 0.05 * h})
        shown = verdict_table(judge(study, table))
        x = shown[shown["variable"] == "x"]
        assert x["error"].tolist() == ["u_h - u", "u_h - I_h u"]
        assert x["verdict"].tolist() == ["PASS", "FAIL"] and x["decides"].tolist() == ["", "yes"]

    def test_without_a_second_error_the_table_says_nothing_of_it(self, study):
        table = records().drop(columns=[f"nodal_{name}" for name in VARIABLES])
        assert not {"error", "decides"} & set(verdict_table(judge(study, table)))

    def test_the_csv_names_the_error_and_which_decides(self, study):
        frame = verdicts_frame(judge(study, records()))
        assert len(frame) == 2 * len(VARIABLES)
        assert frame.groupby("variable")["decides"].sum().eq(1).all()
        assert set(frame["error_of"]) == {"error", "interpolation"}

    def test_reasons_name_the_error(self, study):
        found = reasons(judge(study, records(nu=lambda h, t: {**good(h, t), "nodal": 0.05 * h})))
        assert any(line.startswith("nu against the interpolation: orders from 1") for line in found)

    def test_what_is_masked_for_its_error_is_told_and_what_stopped_elsewhere(self, study):
        def wild(h, tau):
            factor = 30.0 if h == LADDER[0] ** -0.5 else 1.0
            return {**good(h, tau), "err": factor * good(h, tau)["err"]}

        floors = measured("tau", 1e-9)
        (line,) = masked_lines(judge(study, records(x=wild), floors))
        assert line.startswith("x masked: h = 0.183, tau = 0.05: off the line")
        stopped = records(statuses=[((30, 0.05), "diverged")])
        assert not masked_lines(judge(study, stopped, floors))
