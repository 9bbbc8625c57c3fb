"""The seeded bugs: each changes the program, none stays, and the report tells what was seen."""

import csv
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from committed import by_this_program

import esfem
from esfem.campaigns.mutants.campaign import (
    FIRST,
    SET,
    Seen,
    attempt,
    caught,
    coarse_studies,
    prepared,
)
from esfem.campaigns.mutants.markdown import (
    HEADS,
    RESULTS,
    campaign_digest,
    frame,
    kept,
    markdown,
    summary,
    write,
    write_lines,
)
from esfem.campaigns.mutants.mutant import (
    MUTANTS,
    Edit,
    Mutant,
    applied,
    compiled,
    function_at,
    source,
)
from esfem.solver import Levels, Scheme, State, evolve
from esfem.solver.laws import willmore
from esfem.studies.catalogue import default_studies
from esfem.studies.study import STUDIES, load_study

ROOT = Path(esfem.__file__).parent.parent
COMMITTED = ROOT / "results" / "mutants"
# Those of functions that are compiled, and the two equivalent ones are among them.
FORMULAS = [mutant for mutant in MUTANTS if mutant.group in ("forms", "curvature", "assembly")]
BY_NAME = {mutant.name: mutant for mutant in MUTANTS}
H_BUG = Edit("esfem.solver.laws:willmore_Q", "+ S2 * H", "+ 7.0 * S2 * H")


def stored(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


def committed_lines() -> pd.DataFrame:
    return pd.DataFrame(stored(COMMITTED / "mutants.csv"))


@pytest.fixture(scope="module")
def at_rest():
    """The cheapest study of the set, and what it says of the program."""
    (study,) = coarse_studies(("theta-at-rest",))
    tried, expected = prepared(study)
    return (tried,), expected


@pytest.fixture(scope="module")
def error_size():
    """The study of the set that claims the size of an error, and what it says of the program."""
    (study,) = coarse_studies(("error-size",))
    return prepared(study)


class TestRegistry:
    def test_has_at_least_forty_mutants(self):
        assert len(MUTANTS) >= 40

    def test_names_are_unique(self):
        assert len(BY_NAME) == len(MUTANTS)

    @pytest.mark.parametrize("mutant", MUTANTS, ids=BY_NAME)
    def test_each_changes_the_program_and_is_undone(self, mutant):
        functions = {edit.where: function_at(edit.where) for edit in mutant.edits}
        before = {where: f.__code__ for where, f in functions.items()}
        again = {where: compiled(f, source(f)) for where, f in functions.items()}
        with applied(mutant):
            for where, function in functions.items():
                assert function.__code__ != again[where], where
                assert function_at(where) is function
        assert all(functions[where].__code__ is code for where, code in before.items())

    @pytest.mark.parametrize("mutant", FORMULAS, ids=lambda mutant: mutant.name)
    def test_each_of_a_formula_changes_a_step(self, mutant, make_rough, torus):
        def numbers() -> np.ndarray:
            rough = make_rough(2)
            f = torus.fields(rough.x)
            initial = State(0.0, rough.x, f.nu, f.H, f.V, f.z)
            found = []
            for reaction in ("extrapolated", "linearised"):
                scheme = Scheme(theta=True, reaction=reaction)
                *_, last = evolve(rough.mesh, initial, scheme, Levels.equal(1e-4, 2))
                found += [last.u, last.w]
            return np.hstack(found)

        before = numbers()
        with applied(mutant), np.errstate(all="ignore"):
            try:
                after = numbers()
            except ArithmeticError:
                return
        assert not np.abs(after - before).max() <= 1e-9 * np.abs(before).max()

    def test_no_group_is_a_slip_of_the_pen(self):
        sizes = Counter(mutant.group for mutant in MUTANTS)
        assert min(sizes.values()) > 1


class TestSet:
    def test_is_of_default_studies(self):
        assert {c.name for c in SET} <= {path.stem for path in default_studies()}

    @pytest.mark.parametrize("coarse", SET, ids=lambda coarse: coarse.name)
    def test_no_more_is_computed_than_by_the_default_study(self, coarse):
        whole, part = load_study(STUDIES / f"{coarse.name}.toml"), coarse.study()
        assert max(part.sweep.vertices) <= max(whole.sweep.vertices)
        assert part.sweep.final_time <= whole.sweep.final_time
        assert (part.scheme, part.law, part.solution) == (whole.scheme, whole.law, whole.solution)
        assert part.study.claim == whole.study.claim

    def test_a_first_study_is_one_of_the_set(self):
        assert set(FIRST) <= {mutant.group for mutant in MUTANTS}
        assert set(FIRST.values()) <= {coarse.name for coarse in SET}


class TestPatching:
    def test_acts_wherever_the_function_was_imported_to(self):
        with applied(Mutant("m", "law", "", (H_BUG,))):
            assert willmore(2.0, 1.0, None, 0.0) == -4.0 + 14.0
        assert willmore(2.0, 1.0, None, 0.0) == -4.0 + 2.0

    def test_is_undone_when_the_block_fails(self):
        with pytest.raises(ZeroDivisionError), applied(Mutant("m", "law", "", (H_BUG,))):
            _ = 1 / 0
        assert willmore(2.0, 1.0, None, 0.0) == -2.0

    def test_nothing_is_written(self):
        path = Path(esfem.__file__).parent.parent / "solver" / "laws.py"
        before = path.stat().st_mtime_ns
        with applied(Mutant("m", "law", "", (H_BUG,))):
            pass
        assert path.stat().st_mtime_ns == before

    @pytest.mark.parametrize("old", ["not there", "H"])
    def test_text_that_does_not_occur_once_is_refused(self, old):
        mutant = Mutant("m", "law", "", (Edit("esfem.solver.laws:willmore_Q", old, "0"),))
        with pytest.raises(ValueError, match="must occur once"), applied(mutant):
            pass


class TestDigest:
    @pytest.fixture
    def digest(self):
        campaign_digest.cache_clear()
        yield lambda: campaign_digest.__wrapped__()
        campaign_digest.cache_clear()

    @pytest.mark.parametrize(
        "part",
        ["numerics_digest", "digest", "stepping_digest", "claims", "coarse_studies", "MUTANTS"],
    )
    def test_depends_on_program_judge_claims_studies_and_mutants(self, part, digest, monkeypatch):
        before = digest()
        other = {
            "numerics_digest": lambda: "another",
            "digest": lambda modules: "another",
            "stepping_digest": lambda scheme: "another",
            "claims": dict,
            "coarse_studies": tuple,
            "MUTANTS": (),
        }
        monkeypatch.setattr(f"esfem.campaigns.mutants.markdown.{part}", other[part])
        assert digest() != before


class TestTrial:
    @pytest.mark.parametrize("name", ["theta-dropped", "theta-doubled", "b-not-scaled"])
    def test_a_bug_is_caught_by_name_of_study_and_variable(self, name, at_rest):
        tried, expected = at_rest
        trial = attempt(BY_NAME[name], tried, expected)
        assert trial.result == "FAIL"
        assert (trial.best.study, trial.best.outcome) == ("theta-at-rest", "fail")

    def test_what_the_study_does_not_use_survives(self, at_rest):
        assert attempt(BY_NAME["helfrich-sign"], *at_rest).result == "survived"

    def test_a_survivor_with_a_reason_is_equivalent(self, at_rest):
        mutant = Mutant("m", "law", "", BY_NAME["helfrich-sign"].edits, "because")
        assert attempt(mutant, *at_rest).result == "equivalent"

    def test_a_program_that_breaks_down_is_not_green(self, at_rest):
        edit = Edit("esfem.solver.laws:willmore_Q", "return", "raise ValueError(str(t))  #")
        trial = attempt(Mutant("m", "law", "", (edit,)), *at_rest)
        assert trial.result == "not green"
        assert trial.best.outcome == "crash"

    @pytest.mark.slow
    @pytest.mark.parametrize(
        "name", ["error-quadrature-degree-1", "error-at-the-end-only", "start-one-order-less"]
    )
    def test_the_size_of_an_error_sees_what_no_order_sees(self, name, error_size):
        tried, expected = error_size
        assert attempt(BY_NAME[name], (tried,), expected).result == "FAIL"

    @pytest.mark.slow
    def test_the_torus_sees_a_wrong_form(self):
        (study,) = coarse_studies(("clifford-unprojected",))
        tried, expected = prepared(study)
        trial = attempt(BY_NAME["f2-hs-plus-s2"], (tried,), expected)
        assert trial.result == "FAIL"
        assert trial.change > 1.0


@pytest.mark.parametrize(
    ("before", "after", "found"),
    [
        ("pass", "super", None),
        ("not exercised", "pass", None),
        ("not exercised", "not exercised", None),
        ("inconclusive", "fail", None),
        ("pass", "fail", "fail"),
        ("not exercised", "fail", "fail"),
        ("super", "inconclusive", "inconclusive"),
        ("pass", "not exercised", "not exercised"),  # a scheme that does nothing
        ("pass", None, "crash"),
    ],
)
def test_a_mutant_is_caught_where_less_is_green_or_exercised(before, after, found):
    def seen(outcome):
        return outcome and Seen(outcome, 2.0, 2.0, "", 0.1)

    catch = caught(("s", "x"), seen(before), seen(after))
    assert (catch and catch.outcome) == found


class TestReport:
    @pytest.fixture(scope="class")
    @staticmethod
    def trials(at_rest):
        return [attempt(BY_NAME[name], *at_rest) for name in ("theta-dropped", "helfrich-sign")]

    def test_the_report_names_survivors_and_catches(self, trials, at_rest, tmp_path):
        write(frame(trials), at_rest[1], tmp_path)
        text = (tmp_path / "report.md").read_text(encoding="utf-8")
        survivors = text.partition("## Survivors")[2].partition("## ")[0]
        assert "helfrich-sign" in survivors and "theta-dropped" not in survivors
        assert "theta-dropped" in text.partition("## Caught")[2]
        lines = stored(tmp_path / "mutants.csv")
        assert [line["mutant"] for line in lines] == ["helfrich-sign", "theta-dropped"]

    def test_what_is_not_tried_again_is_kept(self, trials, at_rest, tmp_path):
        write(frame(trials), at_rest[1], tmp_path)
        again = kept(frame(trials[:1]), tmp_path)
        assert list(again["mutant"]) == ["helfrich-sign", "theta-dropped"]
        assert summary(again) == summary(frame(trials))

    def test_what_another_judge_made_is_not_kept(self, trials, at_rest, tmp_path, monkeypatch):
        write(frame(trials), at_rest[1], tmp_path)
        monkeypatch.setattr("esfem.campaigns.mutants.markdown.campaign_digest", lambda: "another")
        assert list(kept(frame(trials[:1]), tmp_path)["mutant"]) == ["theta-dropped"]

    def test_the_summary_counts_each_mutant_once(self, trials):
        last = summary(frame(trials)).splitlines()[-1]
        assert [int(cell) for cell in last.split("|")[2:-1]] == [1, 0, 1, 0]
        assert len(HEADS) == len(RESULTS)

    def test_the_committed_report_is_by_this_program_judge_and_studies(self):
        """If it is, it is about the mutants that there are."""
        lines = committed_lines()
        (made,) = set(lines["campaign"])
        if by_this_program("results/mutants", made, campaign_digest(), "make mutants"):
            assert list(zip(lines["mutant"], lines["group"], strict=True)) == [
                (mutant.name, mutant.group) for mutant in MUTANTS
            ]
            for line in lines.itertuples():
                equivalent = bool(BY_NAME[line.mutant].equivalent)
                assert line.result in RESULTS[:2] or (line.result == "equivalent") == equivalent

    def test_the_committed_lines_are_consistent(self):
        lines = committed_lines()
        assert len(lines) > 50 and lines["mutant"].is_unique
        assert set(lines["result"]) <= set(RESULTS)
        assert (lines["result"].isin(RESULTS[:2]) == (lines["study"] != "")).all()
        assert np.isfinite(lines["seconds"].astype(float)).all()

    def test_the_committed_report_counts_the_committed_lines(self):
        report = (COMMITTED / "report.md").read_text(encoding="utf-8")
        assert summary(committed_lines()) in report

    def test_the_table_of_readme_is_that_of_the_report(self):
        report = (COMMITTED / "report.md").read_text(encoding="utf-8")
        readme = (ROOT / "README.md").read_text(encoding="utf-8")
        section = readme.partition("## Seeded bugs")[2].partition("\n## ")[0]
        rows = [line for line in section.splitlines() if line.startswith("|")]
        assert len(rows) > 10
        assert all(row in report.splitlines() for row in rows)

    def test_markdown_keeps_bars_inside_cells(self, trials, at_rest):
        rows = markdown(frame(trials), at_rest[1]).splitlines()
        assert all(not row.startswith("|") or row.endswith("|") for row in rows)


class TestCommand:
    @pytest.fixture
    def mutants(self, monkeypatch, command, tmp_path):
        monkeypatch.setattr(
            "esfem.campaigns.mutants.run.coarse_studies", lambda: coarse_studies(("theta-at-rest",))
        )
        return partial(command, "mutants", "--out", tmp_path)

    def test_the_status_is_zero_if_all_are_caught(self, mutants, tmp_path):
        status, out = mutants("--only", "theta-dropped", "--jobs", "1")
        assert status == 0
        assert "theta-dropped by theta-at-rest" in out
        assert [line["mutant"] for line in stored(tmp_path / "mutants.csv")] == ["theta-dropped"]
        assert not (tmp_path / "report.md").exists()

    def test_an_interrupted_campaign_is_resumed(self, mutants, tmp_path, monkeypatch):
        def interrupted(table: pd.DataFrame, out: Path) -> None:
            write_lines(table, out)
            raise KeyboardInterrupt

        both = ("--only", "theta-dropped", "--only", "theta-doubled", "--jobs", "1")
        with monkeypatch.context() as patched:
            patched.setattr("esfem.campaigns.mutants.run.write_lines", interrupted)
            status, out = mutants(*both)
        assert status == 130
        assert "what had finished is stored; the same command with --resume" in " ".join(
            out.split()
        )
        (line,) = stored(tmp_path / "mutants.csv")
        status, out = mutants(*both, "--resume")
        assert status == 0
        other = {"theta-dropped", "theta-doubled"} - {line["mutant"]}
        assert f"{other.pop()} by" in out and f"{line['mutant']} by" not in out

    def test_with_nothing_left_to_resume_the_status_is_zero(self, mutants):
        words = ("--only", "theta-dropped", "--jobs", "1")
        mutants(*words)
        status, out = mutants(*words, "--resume")
        assert status == 0 and "theta-dropped by" not in out

    def test_the_status_is_one_if_a_mutant_survives(self, mutants):
        status, out = mutants("--only", "helfrich-sign", "--jobs", "1")
        assert status == 1
        assert "survived" in out

    @pytest.mark.parametrize("words", [("--only", "thetta"), ("--jobs", "0")])
    def test_bad_input_is_one_line(self, mutants, words):
        status, out = mutants(*words)
        assert status == 2
        assert words[0] in out and len(out.splitlines()) == 1
