"""Series of errors: what is refused by its place, paths of h and tau together, floors, levels."""

import numpy as np
import pytest

from esfem.cli.series import Claim, Series, judged
from esfem.common.bad_input import BadInput
from esfem.judging import Floor

H = 0.4 * 0.5 ** np.arange(5)


def series(error, h=H, tau=None, h_name="h"):
    error = np.asarray(error, float)
    n = len(error)
    return Series(
        name="",
        h=None if h is None else np.asarray(h, float),
        tau=None if tau is None else np.broadcast_to(np.asarray(tau, float), n).copy(),
        error=error,
        status=("ok",) * n,
        places=tuple(f"run {i + 1}" for i in range(n)),
        h_name=h_name,
    )


def outcome(one, order=2.0, **claim):
    return judged(one, Claim(order=order, **claim)).judgement.outcome


class TestRefused:
    @pytest.mark.parametrize(
        ("one", "said"),
        [
            (series(H**2, h=[0, *H[1:]]), "run 1, column h: 0: must be positive"),
            (series(H**2, h=[*H[:4], np.nan]), "run 5, column h: is missing: must be"),
            (series(H**2, tau=[1, 1, -1, 1, 1]), "run 3, column tau: -1: must be"),
            (series(-(H**2)), "run 1: the error -0.16 is negative; errors are norms"),
            (series(H**2, h=[*H[:4], H[1]]), "run 2 and run 5: h = 0.2 is given twice"),
            (series(H, h=None, tau=[*H[:4], H[3]]), "run 4 and run 5: tau = 0.05 is given"),
        ],
    )
    def test_by_the_run(self, one, said):
        with pytest.raises(BadInput, match=said):
            judged(one, Claim(order=2.0))

    def test_one_h_with_two_steps_is_no_level_given_twice(self):
        one = series(np.r_[H, H] ** 2, h=np.r_[H, H], tau=np.repeat([0.1, 0.05], 5))
        assert outcome(one, steady=True) == "pass"


class TestNumbersOfCells:
    CELLS = np.array([4.0, 8, 16, 32, 64])

    def test_h_that_grows_while_errors_fall_is_refused_with_what_to_give(self):
        with pytest.raises(BadInput, match=r"grows from 4 to 64 .*--cells h .*give 1 / h"):
            judged(series(0.3 / self.CELLS**2, h=self.CELLS), Claim(order=2.0))

    def test_in_any_order_of_the_runs_if_it_is_whole(self):
        with pytest.raises(BadInput, match="number of cells"):
            judged(series(0.3 / self.CELLS**2, h=self.CELLS)
                   .at(np.array([2, 0, 1, 4, 3])), Claim(order=2.0))  # fmt: skip

    def test_not_where_a_user_says_that_it_is_h(self):
        one = series(0.3 / self.CELLS**2, h=self.CELLS, h_name="given h")
        assert outcome(one) == "fail"

    def test_errors_that_grow_as_h_falls_diverge(self):
        assert outcome(series(1 / H)) == "fail"
        assert outcome(series(1 / H, h=1000 * H)) == "fail"

    def test_errors_on_fine_meshes_first_are_judged(self):
        assert outcome(series(H[::-1] ** 2, h=H[::-1])) == "pass"

    def test_large_h_are_no_cells(self):
        assert outcome(series(H**2, h=1e4 * H)) == "pass"


class TestPaths:
    @pytest.mark.parametrize(
        ("k", "q", "gamma", "claimed"), [(2, 1, 1, 1), (2, 1, 2, 2), (2, 2, 1, 2), (3, 1, 2, 2)]
    )
    def test_the_claim_is_the_smaller_of_both_orders_along_it(self, k, q, gamma, claimed):
        tau = H**gamma
        one = series(0.2 * H**k + 0.3 * tau**q, tau=tau)
        found = judged(one, Claim(order=float(k), other_order=float(q)))
        assert found.judgement.outcome == "pass" and found.judgement.claimed == pytest.approx(
            claimed
        )
        assert "judged along that path" in found.notes[0]

    def test_it_fails_where_the_time_step_rules_against_the_claim_in_h(self):
        tau = H
        found = judged(series(H**2 + tau, tau=tau), Claim(order=2.0))
        assert found.judgement.outcome == "fail"
        assert "refined together, tau ~ h^1" in found.notes[0]

    def test_in_tau_along_the_path(self):
        tau = H**2
        one = series(H**2 + tau, tau=tau)
        assert outcome(one, order=1.0, direction="tau") == "pass"
        found = judged(one, Claim(order=3.0, direction="tau", other_order=2.0))
        assert found.judgement.claimed == pytest.approx(1.0) and found.judgement.outcome == "pass"


class TestDirection:
    def test_tau_if_it_alone_changes(self):
        found = judged(series(H**2, h=np.full(5, 0.1), tau=H), Claim(order=2.0))
        assert (found.judgement.direction, found.judgement.outcome) == ("tau", "pass")

    def test_a_study_in_time_needs_no_h_and_speaks_of_none(self):
        found = judged(series(H**2 * [1, 1.3, 1, 1.3, 1], h=None, tau=H), Claim(order=2.0))
        assert found.judgement.direction == "tau"
        assert "h = " not in found.judgement.next_run

    def test_what_is_not_there_is_not_judged(self):
        with pytest.raises(BadInput, match="direction tau: the table has no tau"):
            judged(series(H**2), Claim(order=2.0, direction="tau"))


class TestFloors:
    def test_what_lies_at_it_is_no_level(self):
        h = 0.5 ** np.arange(12.0)
        found = judged(series(np.maximum(h**6, 1e-15), h=h), Claim(order=6.0))
        assert found.judgement.outcome == "pass"
        assert {m.floor for m in found.judgement.masked} == {"rounding"}

    def test_a_given_one_takes_its_place(self):
        floors = (Floor("rounding", 1e-2),)
        found = judged(series(H**2), Claim(order=2.0, floors=floors))
        assert not any("assumed" in note for note in found.notes)
        assert [m.h for m in found.judgement.masked] == [h for h in H if h**2 <= 0.1]

    def test_nothing_above_a_given_floor_is_not_exercised(self):
        assert outcome(series(H**2), floors=(Floor("solver", 1.0),)) == "not exercised"

    def test_zeros_prove_nothing_unless_a_floor_was_measured(self):
        found = judged(series(0 * H), Claim(order=2.0))
        assert found.judgement.outcome == "inconclusive"
        assert "exactly 0" in found.judgement.cause
        assert outcome(series(0 * H), floors=(Floor("rounding", 1e-15),)) == "not exercised"


class TestWords:
    def test_without_tau_there_is_no_word_of_time(self):
        for e in (H**2 + 0.05, [0.73, 0.17, 0.064, 0.028, 0.02], 1e-2 + 0 * H + 1e-4 * H):
            j = judged(series(e), Claim(order=2.0)).judgement
            assert not any(word in j.cause + j.next_run for word in ("tau", "in time", "step"))

    def test_levels_are_chosen_and_said(self):
        e = H**2 * [9, 1, 1, 1, 1]
        found = judged(series(e), Claim(order=2.0, levels=(1, None)))
        assert found.judgement.outcome == "pass" and len(found.judgement.window) == 4
        assert found.notes[0] == "4 of 5 levels are judged as asked, h = 0.2 to 0.025"
        with pytest.raises(BadInput, match="none of 5 is chosen"):
            judged(series(e), Claim(order=2.0, levels=(7, None)))

    def test_more_than_the_order_may_be_expected(self):
        one = series(0.1 * H**5)
        assert outcome(one) == "suspect" and outcome(one, at_least=True) in ("pass", "super")
