"""The simulation that judges the judge: its truths, its bookkeeping, its report."""

import numpy as np
import pandas as pd
import pytest
from committed import RESULTS, by_this_program

from esfem.campaigns.judge.grown_kinds import HELD_OUT
from esfem.campaigns.judge.kinds import kinds
from esfem.campaigns.judge.run import (
    clean_passes,
    program_digest,
    rates,
    totals,
    upper_bound,
    write,
)
from esfem.campaigns.judge.shapes import two_powers
from esfem.campaigns.judge.simulation import RULES, false_fail, false_pass, simulate

REPORT = RESULTS / "judge"


@pytest.fixture(scope="module")
def rows() -> pd.DataFrame:
    return simulate(3, seed=11)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_tables_and_verdicts(rows):
    pd.testing.assert_frame_equal(simulate(1, seed=11), simulate(1, seed=11))
    assert not simulate(1, seed=12)["scatter"].equals(simulate(1, seed=11)["scatter"])


def test_every_kind_has_its_own_name(rows):
    names = [kind.name for kind in kinds()]
    assert len(set(names)) == len(names)
    assert list(rows["kind"].unique()) == names


@pytest.mark.parametrize("kind", kinds(), ids=lambda kind: kind.name)
def test_tables_are_as_their_kind_says(kind):
    """Positive errors, 3 to 8 levels, and a truth for all but the terms that cancel."""
    for seed in range(5):
        made = kind.draw(np.random.default_rng(seed))
        e = made.table["error"]
        assert (e[e.notna()] > 0).all()
        assert 3 <= made.levels <= 8
        assert made.table[made.direction].nunique() == made.levels
        assert np.isfinite(made.truth) or " - tau" in kind.name


def test_some_of_the_kinds_that_joined_are_held_out():
    """And each name that is, is that of a kind."""
    assert {kind.name for kind in kinds() if kind.held_out} == HELD_OUT
    assert not any(kind.held_out or kind.limit for kind in kinds() if kind.group == "published")


def test_a_kind_has_the_same_tables_whichever_others_are_drawn():
    alone = simulate(2, seed=5, which=lambda kind: kind.name == "printed")
    some = simulate(2, seed=5, which=lambda kind: kind.name.startswith("printed"))
    some = some[some["kind"] == "printed"].reset_index(drop=True)
    pd.testing.assert_frame_equal(alone, some)


def test_the_power_that_rules_is_the_larger_one_on_the_finest_level():
    rng, h = np.random.default_rng(0), 0.5 ** np.arange(20)
    errors = two_powers(-1.0, 1.0, (0.5, 0.95))(rng, h, 2.0)
    share = errors[-1] - (errors[0] * h[-1] ** 3)  # what h^3, which is all of errors[0], leaves
    assert 0.5 <= share / errors[-1] <= 1.0
    local = np.diff(np.log(errors)) / np.diff(np.log(h))
    assert local[0] == pytest.approx(3.0, abs=1e-3) and local[-1] < 2.3


@pytest.mark.parametrize(
    ("said", "truth", "wrong_pass", "wrong_fail"),
    [
        ("pass", 2.0, False, False),
        ("pass", 1.85, False, False),
        ("pass", 1.5, True, False),
        ("super", 1.0, True, False),
        ("pass", float("nan"), True, False),
        ("fail", 2.0, False, True),
        ("fail", 1.5, False, False),
        ("suspect", 2.0, False, True),
        ("suspect", 4.0, False, False),
        ("inconclusive", 2.0, False, False),
        ("inconclusive", 1.0, False, False),
    ],
)
def test_verdicts_are_graded_by_the_truth(said, truth, wrong_pass, wrong_fail):
    row = pd.DataFrame({"judge": [said], "claim": [2.0], "truth": [truth]})
    assert false_pass(row, "judge").item() == wrong_pass
    assert false_fail(row, "judge").item() == wrong_fail


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(("order", "accepted"), [(2.0, True), (2.5, True), (1.0, False)])
def test_the_usual_rules_know_a_pure_power(rule, order, accepted):
    h = 0.5 ** np.arange(5)
    assert RULES[rule](h, h**order, 2.0) is accepted


def test_shares_of_a_judge_sum_to_one(rows):
    found = rates(rows)
    parts = found[["false_pass", "false_fail", "inconclusive", "right"]].sum(axis=1)
    assert np.allclose(parts, 1.0, atol=1e-12)
    assert (found["tables"] == 3).all()


def test_limits_are_not_in_the_totals(rows):
    limits = sum(kind.limit for kind in kinds())
    assert limits >= 3
    assert (totals(rows)["tables"] == 3 * (len(kinds()) - limits)).all()


def test_an_event_never_seen_may_still_have_a_rate():
    """Of 300 tables without one, 1 % is the 95 % bound: 0.99^300 = 0.049."""
    assert upper_bound(0.0, 300) == pytest.approx(0.00994, abs=1e-5)
    assert upper_bound(1.0, 10) == 1.0


def test_the_report_is_written_whole(rows, tmp_path):
    write(rows, seed=11, seconds=1.0, out=tmp_path)
    text = (tmp_path / "report.md").read_text()
    assert all(kind.name in text for kind in kinds())
    assert "seed 11" in text and "reached" in text
    found = pd.read_csv(tmp_path / "rates.csv")
    assert set(found["by"]) == {"judge", *RULES}
    assert set(found["program"]) == {program_digest()}
    assert "<svg" in (tmp_path / "rates.svg").read_text()


def test_the_committed_report_is_by_this_judge():
    """If it is, it is of the kinds that there are."""
    found = pd.read_csv(REPORT / "rates.csv")
    assert (found["tables"] >= 200).all()
    made = found["program"].unique() if "program" in found else ["a version without digest"]
    assert len(made) == 1
    if by_this_program("results/judge", made[0], program_digest(), "make judge-report"):
        assert list(found["kind"].unique()) == [kind.name for kind in kinds()]


def test_the_committed_report_reaches_the_goals():
    found = pd.read_csv(REPORT / "rates.csv")
    judge = found[(found["by"] == "judge") & ~found["limit"]]
    assert (judge["false_pass"] <= 0.01).all()
    assert judge["false_fail"].mean() <= 0.01
    assert judge.set_index("kind")["right"]["clean"] >= 0.9


@pytest.mark.slow
def test_the_judge_is_seldom_wrong():
    """A seed of its own; 1 % of 940 tables is 9."""
    rows = simulate(20, seed=99)
    judge = totals(rows).set_index("by").loc["judge"]
    assert judge["false_pass"] <= 0.01 and judge["false_fail"] <= 0.01
    assert clean_passes(rows)["judge"] >= 0.9
