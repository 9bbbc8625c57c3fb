"""`esfem paper` on a tiny copy of the paper's studies: what it writes, and that it goes on."""

import json

import pytest
from rich.console import Console
from studies import SMALL_FLOW, write_study, write_varied

from esfem.campaigns.paper.evolutions import Prefixed
from esfem.campaigns.paper.plan import Plan
from esfem.campaigns.paper.run import status as exit_status
from esfem.campaigns.paper.sentences import Line, sentences
from esfem.campaigns.publish import MOST_BYTES, size
from esfem.results.result_files import load_result
from esfem.studies.catalogue import long_studies

QUIET = Console(quiet=True)
SMALLER = (
    ("vertices = [30, 60, 120, 240, 480]", "vertices = [30, 60]"),
    ('name = "small"', 'name = "paper-sphere"'),
)


@pytest.fixture
def tiny(tmp_path):
    """The words of `esfem paper` on one small study and one small flow."""
    folder = tmp_path / "studies"
    (folder / "flows").mkdir(parents=True)
    write_study(folder, *SMALLER, name="paper-sphere.toml")
    named = ('name = "small"', 'name = "ellipsoid"')
    write_varied(folder / "flows" / "ellipsoid.toml", SMALL_FLOW, named)
    where = {"--studies": folder, "--runs": tmp_path / "runs", "--out": tmp_path / "out"}
    return ["paper", *(str(word) for pair in where.items() for word in pair), "--jobs", "1"]


def lines(out):
    return json.loads((out / "sentences.json").read_text())


@pytest.mark.slow
class TestPaper:
    def test_an_interrupted_one_goes_on_and_computes_nothing_twice(
        self, command, tiny, tmp_path, monkeypatch
    ):
        def interrupt(*_, **__):
            raise KeyboardInterrupt

        with monkeypatch.context() as patched:
            patched.setattr("esfem.campaigns.paper.run.run_studies", interrupt)
            status, out = command(*tiny)
        assert status == 130 and "continues from there" in out
        outcome = tmp_path / "runs" / "flows" / "ellipsoid" / "outcome.json"
        before = outcome.stat().st_mtime_ns
        assert command(*tiny)[0] in (1, 3)  # a small flow does not reach its end
        assert outcome.stat().st_mtime_ns == before
        record = next((tmp_path / "runs" / "paper-sphere" / "records").iterdir())
        written = record.stat().st_mtime_ns
        command(*tiny)
        assert record.stat().st_mtime_ns == written

    def test_it_writes_sentences_figures_and_the_light_part(self, command, tiny, tmp_path):
        _, said = command(*tiny)
        out = tmp_path / "out"
        assert len(lines(out)) == sum(len(sentence.read_in) for sentence in sentences())
        for line in lines(out):
            assert line["verdict"].upper() in said
        by_check = {line["study"]: line["verdict"] for line in lines(out)}
        assert by_check["extra/figure-2-normalisation"] == "pass"
        assert by_check["flows/ellipsoid"] == "inconclusive"  # it was not asked whether it rests
        made = {path.stem for path in (out / "extra").glob("*.json")}
        assert made == {"figure-2-normalisation", "figure-3-sphere"}
        for name in made:
            extra = json.loads((out / "extra" / f"{name}.json").read_text())
            assert (out / "extra" / extra["figure"]).read_text().count("<svg") == 1
            assert extra["alt"] and extra["title"] and extra["table"]
        assert len(load_result(out / "paper-sphere").records) == 4
        assert (out / "flows" / "ellipsoid" / "history.csv").is_file()
        heavy = {path.suffix for path in out.rglob("*")} & {".npz", ".vtu", ".pvd"}
        assert not heavy and not list(out.rglob("records")) and size(out) < MOST_BYTES

    def test_only_runs_what_is_named(self, command, tiny, tmp_path):
        command(*tiny, "--only", "ellipsoid")
        assert (tmp_path / "out" / "flows" / "ellipsoid").is_dir()
        assert not (tmp_path / "runs" / "paper-sphere").exists()


@pytest.mark.parametrize(
    ("words", "ablated"), [(("--only", "ablation"), True), (("--only", "theta-at-rest"), False)]
)
def test_the_ablation_is_run_by_its_name(command, tmp_path, monkeypatch, words, ablated):
    ran = []
    monkeypatch.setattr(
        "esfem.campaigns.paper.run.run_studies", lambda *_, **__: ran.append("studies")
    )
    monkeypatch.setattr("esfem.campaigns.paper.run.run_ablation", lambda *_: ran.append("ablation"))
    monkeypatch.setattr("esfem.campaigns.paper.run.write", lambda *_: 0)
    assert command("paper", "--runs", tmp_path / "r", "--out", tmp_path, *words)[0] == 0
    assert ran == (["ablation"] if ablated else ["studies"])


def test_long_studies_are_run_with_the_option(command, tmp_path, monkeypatch):
    ran = []
    monkeypatch.setattr(
        "esfem.campaigns.paper.run.run_paper", lambda plan, *_: ran.append(plan) or 0
    )
    words = ("paper", "--runs", tmp_path / "r", "--out", tmp_path)
    assert command(*words)[0] == command(*words, "--long")[0] == 0
    assert set(ran[1].names) - set(ran[0].names) == {path.stem for path in long_studies()}


def test_a_long_study_is_run_if_it_is_named(command, tmp_path, monkeypatch):
    ran = []
    monkeypatch.setattr(
        "esfem.campaigns.paper.run.run_paper", lambda plan, *_: ran.append(plan) or 0
    )
    (name, *_) = (path.stem for path in long_studies())
    assert command("paper", "--runs", tmp_path, "--out", tmp_path, "--only", name)[0] == 0
    assert [plan.names for plan in ran] == [(name,)]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--only", "nothing"), "--only nothing: must be one of"),
        (("--jobs", "0"), "--jobs 0: must be at least 1"),
        (("--studies", "nowhere"), "holds neither"),
        (("--only", "nothing", "--long"), "ellipsoid-degree-4-fine"),
        (("--only", "nothing"), "ellipsoid-degree-4-fine"),
    ],
)
def test_bad_input_is_refused(command, tmp_path, words, message):
    status, out = command("paper", "--runs", tmp_path, "--out", tmp_path, *words)
    assert status == 2 and message in " ".join(out.split())


def line(verdict, study="paper-sphere"):
    return Line("l", "7", "q", study, "", "", verdict, "")


class TestExitStatus:
    def test_the_worst_sentence_decides(self, tmp_path):
        plan = Plan((tmp_path / "paper-sphere.toml",), (tmp_path / "ellipsoid.toml",))
        assert exit_status([line("pass"), line("super"), line("no claim")], plan) == 0
        assert exit_status([line("pass"), line("inconclusive", "flows/ellipsoid")], plan) == 3
        for bad in ("fail", "suspect"):
            table = line(bad, "extra/figure-2-normalisation")
            assert exit_status([table, line("inconclusive")], plan) == 1

    def test_a_sentence_about_a_table_counts_if_the_plan_runs_what_that_is_made_from(
        self, tmp_path
    ):
        both = [tmp_path / f"{name}.toml" for name in ("paper-torus", "paper-torus-bdf2")]
        grows = [line("inconclusive", "extra/figure-4-growth")]
        assert exit_status(grows, Plan(tuple(both), ())) == 3
        assert exit_status(grows, Plan(tuple(both[:1]), ())) == 0
        always = [line("fail", "extra/figure-2-normalisation")]
        assert exit_status(always, Plan((), ())) == 1

    def test_sentences_about_what_is_not_in_the_plan_do_not_count(self, tmp_path):
        plan = Plan((tmp_path / "paper-sphere.toml",), ())
        others = [line("fail", "paper-sphere, other"), line("inconclusive", "flows/ellipsoid")]
        assert exit_status(others, plan) == 0


def test_lines_of_a_flow_bear_its_name(capsys):
    stream = Prefixed("torus")
    stream.write("one\ntw")
    stream.write("o\n")
    assert capsys.readouterr().out == "torus: one\ntorus: two\n"
