"""Time levels: where they are, which of them a step may use, and which must be remembered."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from esfem.solver.levels import Levels, Memory, Stretch

TAU = 0.1
# Whole steps, then halves, then double ones: what a list of steps of changing size looks like.
UNEQUAL = Levels(TAU, (Stretch(3, 2), Stretch(4, 1), Stretch(3, 4)), parts=2)


class TestTimes:
    def test_equal_ones_are_whole_multiples_of_tau_and_never_a_sum(self):
        levels = Levels.equal(TAU, 12, t_0=0.3)
        assert [levels.t(n) for n in range(13)] == [0.3 + n * TAU for n in range(13)]
        assert all(levels.step(n) == TAU for n in range(1, 13))

    def test_whole_steps_lie_at_the_same_times_to_the_last_bit_with_substeps(self):
        """For every number of substeps, in which tau / m is rounded."""
        for m in (2, 3, 7, 10, 49):
            levels = Levels.started(TAU, 12, 3, m)
            whole = [m * n if n <= 3 else 3 * m + n - 3 for n in range(13)]
            assert [levels.t(n) for n in whole] == [n * TAU for n in range(13)]
            assert levels.steps == 3 * m + 9

    def test_substeps_divide_the_first_steps_only(self):
        levels = Levels.started(TAU, 5, 2, 4)
        sizes = [levels.step(n) for n in range(1, levels.steps + 1)]
        assert sizes == [0.25 * TAU] * 8 + [TAU] * 3
        times = [levels.t(n) for n in range(levels.steps + 1)]
        np.testing.assert_allclose(np.diff(times), sizes, rtol=1e-14, atol=0)

    def test_one_substep_is_none(self):
        assert Levels.started(TAU, 5, 2, 1) == Levels.equal(TAU, 5)

    def test_a_run_of_first_steps_only_ends_with_a_substep(self):
        levels = Levels.started(TAU, 2, 4, 3)
        assert levels.steps == 6 and levels.t(6) == 2 * TAU

    def test_unequal_ones_follow_their_stretches(self):
        halves = [0, 2, 4, 6, 7, 8, 9, 10, 14, 18, 22]
        assert [UNEQUAL.t(n) for n in range(11)] == [i / 2 * TAU for i in halves]

    @pytest.mark.parametrize("levels", [Levels.started(TAU, 9, 3, 7, t_0=0.3), UNEQUAL])
    def test_each_is_found_by_its_time(self, levels):
        assert [levels.at(levels.t(n)) for n in range(levels.steps + 1)] == list(
            range(levels.steps + 1)
        )

    @pytest.mark.parametrize("t", [-0.1, 0.05, 0.36, 0.41, 1.2, 1e300])
    def test_a_time_between_them_is_refused(self, t):
        with pytest.raises(ValueError, match="is not the time of a level"):
            UNEQUAL.at(t)


class TestHistory:
    def test_of_equal_levels_is_the_last_ones(self):
        levels = Levels.equal(TAU, 20)
        assert levels.history(3, 6) == (2, 1, 0)
        assert levels.history(12, 6) == (11, 10, 9, 8, 7, 6)

    def test_behind_the_substeps_it_is_the_whole_steps_among_them(self):
        """BDF3 with substeps of a quarter: the first whole step is level 13, to 4 tau."""
        levels = Levels.started(TAU, 9, 3, 4)
        assert levels.history(12, 6) == (11, 10, 9, 8, 7, 6)
        assert levels.history(13, 6) == (12, 8, 4, 0)
        assert levels.history(14, 6) == (13, 12, 8, 4, 0)

    def test_ends_where_a_level_is_missing(self):
        """From whole steps to halves: one level at the right distance, so a new start."""
        assert UNEQUAL.history(4, 6) == (3,)
        assert UNEQUAL.history(5, 6) == (4, 3)
        assert UNEQUAL.history(8, 6) == (7, 3, 1)

    @given(
        order=st.integers(1, 5),
        substeps=st.integers(1, 12),
        steps=st.integers(1, 9),
        depth=st.integers(1, 7),
    )
    def test_is_spaced_by_its_step_and_long_enough_where_steps_are_whole(
        self, order, substeps, steps, depth
    ):
        levels = Levels.started(TAU, steps, order, substeps)
        for n in range(1, levels.steps + 1):
            past = levels.history(n, depth)
            times = [levels.t(i) for i in (n, *past)]
            np.testing.assert_allclose(-np.diff(times), levels.step(n), rtol=1e-12, atol=0)
            if n > substeps * min(order, steps):
                assert len(past) >= min(order, depth)


class TestMemory:
    @given(
        order=st.integers(1, 5),
        substeps=st.integers(1, 12),
        steps=st.integers(1, 9),
        depth=st.integers(1, 7),
        resumed=st.integers(0, 40),
    )
    def test_has_all_that_a_step_may_use_also_when_resumed(
        self, order, substeps, steps, depth, resumed
    ):
        levels = Levels.started(TAU, steps, order, substeps)
        memory = Memory(levels, depth)
        for n in range(levels.steps + 1):
            if n > 0:
                assert memory.before(n) == list(levels.history(n, depth))
            memory.add(n, n)
            if n == resumed:
                kept = [entry for _, entry in memory.items()]
                memory = Memory(levels, depth)
                memory.restore(n, kept)

    def test_holds_no_more_than_later_steps_need(self):
        """Of a thousand substeps: the last ones, and those at whole multiples of tau."""
        levels = Levels.started(TAU, 9, 2, 500)
        memory: Memory[int] = Memory(levels, 6)
        sizes = []
        for n in range(levels.steps + 1):
            memory.add(n, n)
            sizes.append(len(memory.items()))
        assert max(sizes) == 8
        assert [n for n, _ in memory.items()] == [levels.steps]

    def test_too_few_entries_are_refused(self):
        memory: Memory[int] = Memory(Levels.started(TAU, 9, 2, 9), 6)
        with pytest.raises(ValueError, match="2 States given, 8 needed after level 16"):
            memory.restore(16, [16, 15])


class TestBadInput:
    @pytest.mark.parametrize("tau", [0.0, -0.1, np.inf, np.nan])
    def test_bad_tau_is_refused(self, tau):
        with pytest.raises(ValueError, match=r"tau = .*: must be a positive finite number"):
            Levels.equal(tau, 1)

    @pytest.mark.parametrize("steps", [0, -1])
    def test_too_few_steps_are_refused(self, steps):
        with pytest.raises(ValueError, match=f"steps = {steps}: must be at least 1"):
            Levels.equal(0.1, steps)

    @pytest.mark.parametrize("steps", [2.0, True, "2"])
    def test_steps_that_are_no_whole_number_are_refused(self, steps):
        with pytest.raises(ValueError, match=r"steps = .*: must be a whole number"):
            Levels.equal(0.1, steps)

    @pytest.mark.parametrize("bad", [{"parts": 0}, {"stretches": ()}])
    def test_no_parts_or_no_stretch_is_refused(self, bad):
        with pytest.raises(ValueError, match=r"(parts|stretches) = .*: must be"):
            Levels(**{"tau": 0.1, "stretches": (Stretch(1),), **bad})

    def test_ticks_below_one_are_refused(self):
        with pytest.raises(ValueError, match="ticks = 0: must be at least 1"):
            Stretch(3, 0)

    def test_a_step_that_is_lost_in_rounding_is_refused(self):
        with pytest.raises(ValueError, match=r"tau = 1e-20: a step of it does not change t = 1\.0"):
            Levels.equal(1e-20, 5, t_0=1.0)

    @pytest.mark.parametrize("n", [-1, 11])
    def test_a_level_that_is_not_there_has_no_time(self, n):
        with pytest.raises(ValueError, match=f"level {n}: must be 1 to 10"):
            UNEQUAL.t(n)
