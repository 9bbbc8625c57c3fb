"""Regression: what a comparison finds, and what it must not."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stored import LADDER, TAU, of_study, recast, scattered, stored

from esfem.campaigns.baseline.change import Change, exit_status
from esfem.campaigns.baseline.compare import RANK, ROUNDING, compare, other_options
from esfem.campaigns.baseline.tolerances import (
    OTHER_MESHES,
    SAME_MESHES,
    level_tolerance,
    one_tolerance,
    order_tolerance,
)
from esfem.studies.study import CLAIMED_THEN, Study

SMOOTH = scattered(0.01, 0)


def moved(before, now) -> dict[str, str]:
    """What moved, and how."""
    return {change.what: change.effect for change in compare(before, now) if change.moved}


def with_verdict(result, **facts):
    """The same errors under another verdict."""
    verdict = recast(result.content.verdicts[0], **facts)
    return replace(result, content=replace(result.content, verdicts=[verdict]))


def test_the_same_results_have_not_moved():
    changes = compare(stored(SMOOTH), stored(SMOOTH))
    assert {c.what for c in changes} == {"verdict", "order", "errors", "one error", "constant"}
    assert not any(c.moved for c in changes)
    assert exit_status(changes) == exit_status(changes, strict=True) == 0


def test_a_lower_order_is_worse():
    now = stored(lambda h: 0.7 * h**1.5 * SMOOTH(h) / h**2)
    changes = compare(stored(SMOOTH), now)
    order = next(c for c in changes if c.what == "order")
    assert order.effect == "worse"
    assert order.by == pytest.approx(-0.5, abs=1e-6)
    assert order.tolerance < 0.2
    assert exit_status(changes) == 1


def test_five_times_the_errors_keep_their_order_and_are_worse():
    changes = compare(stored(SMOOTH), stored(lambda h: 5 * SMOOTH(h)))
    effects = {c.what: c.effect for c in changes}
    assert effects["order"] == effects["verdict"] == "same"
    for what in ("errors", "one error", "constant"):
        change = next(c for c in changes if c.what == what)
        assert change.effect == "worse"
        assert change.by == pytest.approx(5.0)


@pytest.mark.parametrize("size", [0.0, 0.03, 0.3, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_five_times_the_errors_are_worse_however_large_the_scatter(size, seed):
    error = scattered(size, seed)
    assert "worse" in moved(stored(error), stored(lambda h: 5 * error(h))).values()


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.01, 0.05, 0.1])
def test_another_draw_of_the_scatter_is_rarely_worse(size):
    """Two meshes of the same size: at most a tenth of the comparisons say worse, for 95 % intervals
    with a floor below.  Verdicts are left out: their intervals decide on their own."""
    worse = total = 0
    for seed in range(60):
        changes = compare(
            stored(scattered(size, seed)), stored(scattered(size, seed + 1000), mesh="b")
        )
        numbers = [c for c in changes if c.amount]
        total += len(numbers)
        worse += sum(c.effect == "worse" for c in numbers)
    assert total >= 150
    assert worse <= 0.1 * total


def test_smaller_errors_are_better_and_fail_only_strictly():
    changes = compare(stored(SMOOTH), stored(lambda h: SMOOTH(h) / 3))
    assert {c.effect for c in changes} == {"same", "better"}
    assert exit_status(changes) == 0
    assert exit_status(changes, strict=True) == 1


def test_one_error_alone_is_found_and_named():
    factor = np.array([1.0, 1.0, 1.0, 1.3, 1.0])
    changes = compare(stored(SMOOTH), stored(lambda h: factor * SMOOTH(h)))
    one = next(c for c in changes if c.what == "one error")
    assert one.effect == "worse"
    assert one.place == "V = 480, tau = 0.01"
    assert one.by == pytest.approx(1.3)


@pytest.mark.parametrize("before", RANK)
@pytest.mark.parametrize("now", RANK)
def test_a_verdict_gets_worse_by_its_rank_alone(before, now):
    results = [with_verdict(stored(SMOOTH), verdict=name) for name in (before, now)]
    green = before in ("pass", "super")
    effect = moved(*results).get("verdict", "same")
    if green and now not in ("pass", "super"):
        assert effect == "worse"
    assert (effect == "worse") == (RANK[now] > RANK[before])


def test_a_claim_that_is_gone_is_worse_and_another_one_is_not_comparable():
    before = stored(SMOOTH)
    assert moved(before, with_verdict(before, claim=""))["claim"] == "worse"
    assert moved(before, with_verdict(before, tolerance=0.5))["claim"] == "unknown"


def test_a_variable_that_is_not_judged_any_more_is_worse():
    before, now = stored(SMOOTH), stored(SMOOTH, variable="y")
    assert moved(before, now)["verdict"] == "worse"


def test_a_run_that_stops_is_worse_and_one_that_is_missing_is_not_comparable():
    before, stopped, missing = stored(SMOOTH), stored(SMOOTH), stored(SMOOTH)
    stopped.records.loc[1, ["status", "err_x"]] = ["diverged", np.nan]
    assert moved(before, stopped) == {"run": "worse"}
    assert moved(stopped, before)["run"] == "better"
    (gone,) = [
        c
        for c in compare(before, replace(missing, records=missing.records.drop(index=2)))
        if c.what == "cell"
    ]
    assert gone.effect == "unknown" and gone.place == f"V = {LADDER[2]}, tau = {TAU:g}"


def test_another_problem_is_not_comparable():
    before, now = (
        of_study(stored(SMOOTH), scheme={"reaction": name}) for name in ("implicit", "linearised")
    )
    (change,) = compare(before, now)
    assert (change.what, change.effect) == ("case", "unknown")
    assert change.baseline == "scheme.reaction = implicit"
    assert change.current == "scheme.reaction = linearised"
    assert exit_status([change]) == 3


@pytest.mark.parametrize(
    ("part", "told", "option", "values"),
    [
        ("law", {"name": "helfrich"}, "law.name", ("willmore", "helfrich")),
        ("law", {"volume": 2.0}, "law.volume", ("not told", 2.0)),
        ("solution", {"radius": 2.0}, "solution.radius", (1.0, 2.0)),
        ("sweep", {"final_time": 0.5}, "final_time", (1.0, 0.5)),
        ("sweep", {"first_steps": 4}, "first_steps", (1, 4)),
        ("sweep", {"vertices": [30]}, None, ()),
    ],
)
def test_what_makes_another_problem_is_named_with_both_values(part, told, option, values):
    before = stored(SMOOTH)
    now = of_study(before, **{part: told})
    assert other_options(before, now) == ({option: values} if option else {})


def test_an_option_that_a_file_of_before_does_not_tell_is_not_told():
    before = stored(SMOOTH)
    told = before.content.parameters.model_dump(mode="json")
    del told["scheme"]["reaction"]
    study = Study.model_validate_json(json.dumps(told), context=CLAIMED_THEN)
    older = replace(before, content=replace(before.content, parameters=study))
    assert other_options(older, before)["scheme.reaction"] == ("not told", "extrapolated")


def test_errors_at_rounding_level_may_do_what_they_like():
    def noise(seed):
        draw = np.random.default_rng(seed).uniform(1e-14, ROUNDING, len(LADDER))
        return stored(lambda h: draw, verdict="not exercised", vertices=(), tau=())

    assert moved(noise(0), noise(1)) == {}
    grown = stored(lambda h: 1e-6 + 0 * h, verdict="not exercised", vertices=(), tau=())
    assert moved(noise(0), grown)["errors"] == "worse"


def test_worse_goes_before_what_is_not_comparable():
    blank = Change("verdict", "pass", "fail", "worse", variable="x")
    assert exit_status([blank, replace(blank, effect="unknown")]) == 1
    assert exit_status([replace(blank, effect="unknown"), replace(blank, effect="same")]) == 3


@pytest.mark.parametrize("most", [OTHER_MESHES, SAME_MESHES])
@given(st.floats(0.0, 10.0), st.integers(3, 9))
def test_tolerances_grow_with_the_scatter_and_never_hide_a_factor_of_5(most, scatter, n):
    level, one = (f(scatter, n, most) for f in (level_tolerance, one_tolerance))
    assert 0.02 <= level <= level_tolerance(2 * scatter, n, most) <= most.level
    assert level <= one <= most.one < np.log(5.0)


def test_the_scatter_of_the_meshes_is_no_excuse_on_the_same_meshes():
    error = scattered(0.1, 0)
    worse = stored(lambda h: 1.15 * error(h))
    assert moved(stored(error), worse)["errors"] == "worse"
    assert "errors" not in moved(stored(error, mesh="b"), worse)


def fit(order, lower, upper):
    """A verdict on an error with this order and interval."""
    facts = {"observed": order, "lower": lower, "upper": upper, "scatter": 0.01}
    return replace(stored(SMOOTH).content.verdicts[0].deciding, **facts)


def test_the_tolerance_of_the_order_is_of_the_sides_that_face_each_other():
    before, now = fit(2.0, 1.9, 2.4), fit(1.8, 1.5, 1.9)
    assert order_tolerance(before, now) == pytest.approx(np.hypot(0.1, 0.1))
    assert order_tolerance(now, before) == pytest.approx(np.hypot(0.1, 0.1))


def test_a_fit_that_became_bad_does_not_excuse_itself():
    before, now = fit(2.0, 1.9, 2.1), fit(1.2, -5.0, 9.0)
    assert order_tolerance(before, now) < 0.3


def test_the_constant_is_compared_in_the_middle_of_the_window():
    """Rotating the line about the middle leaves it, though the constant at h = 1 moves."""
    before = stored(SMOOTH)
    verdict = before.content.verdicts[0]
    h = before.records.set_index("vertices").loc[list(verdict.vertices), "h"]
    middle, order = float(np.exp(np.log(h).mean())), verdict.observed
    turned = verdict.constant * middle**order / middle ** (order - 0.5)
    now = with_verdict(before, observed=order - 0.5, constant=turned)
    constant = next(c for c in compare(before, now) if c.what == "constant")
    assert turned < 0.7 * verdict.constant
    assert constant.by == pytest.approx(1.0) and not constant.moved


def test_errors_outside_the_judged_window_are_not_compared():
    def with_other_tau(factor):
        result = stored(SMOOTH)
        more = result.records.assign(tau=2 * TAU, err_x=factor * result.records["err_x"])
        return replace(result, records=pd.concat([result.records, more], ignore_index=True))

    assert moved(with_other_tau(1.0), with_other_tau(9.0)) == {}
