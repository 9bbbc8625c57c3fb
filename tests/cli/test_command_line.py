"""The command line as a whole: every help, shared options, what is loaded, how it ends."""

import json
import subprocess
import sys
from importlib.metadata import version

import pytest
from typer.main import get_command

from esfem.campaigns.judge.simulation import simulate
from esfem.cli import app

COMMANDS = {command.name: command.callback for command in app.registered_commands}
PARAMETERS = {
    name: {parameter.name for parameter in command.params}
    for name, command in get_command(app).commands.items()
}
SLOW = {"numpy", "pandas", "scipy", "sympy", "numba", "matplotlib", "basix", "joblib", "solver"}
LOADED = """
import json, sys
from esfem.cli import main
sys.argv = ["esfem", *sys.argv[1:]]
try:
    main()
except SystemExit as stop:
    assert not stop.code, stop.code
print(json.dumps(sorted({name.partition(".")[0] for name in sys.modules})))
"""


def loaded(*words: object) -> set[str]:
    """The packages that the command line with these words loads, in a process of its own."""
    command = [sys.executable, "-c", LOADED, *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_every_help_has_an_example(command, esfem):
    status, out, _ = esfem(*command.split(), "--help")
    assert status == 0
    assert f"Example: esfem {command}" in " ".join(out.split())


@pytest.mark.parametrize("words", [("--help",), ("run", "--help"), ("judge", "--help")])
def test_help_loads_nothing_slow(words):
    assert not loaded(*words) & SLOW


def test_the_judge_loads_no_more_than_it_needs(tmp_path):
    table = tmp_path / "errors.csv"
    table.write_text("h,error\n" + "".join(f"{h},{h**2}\n" for h in (1, 0.5, 0.25, 0.125)))
    found = loaded("judge", table, "--order", 2, "--json", tmp_path / "judged.json")
    assert found & SLOW == {"numpy", "scipy"}


@pytest.mark.parametrize("command", [name for name, has in PARAMETERS.items() if "jobs" in has])
def test_there_is_at_least_one_process(command, esfem, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert esfem(command, "--jobs", 0)[::2] == (2, "esfem: --jobs 0: must be at least 1\n")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "told"), [(("run", "sphere"), "-1"), (("flow", "ellipsoid"), "nan")]
)
def test_no_checkpoint_is_in_the_past(words, told, esfem):
    status, _, err = esfem(*words, "--checkpoint", told)
    assert (status, err) == (2, f"esfem: --checkpoint {told}: must be at least 0 seconds\n")


def test_the_version_is_that_of_the_package_and_of_the_numerics(esfem):
    from esfem.common.provenance import numerics_digest

    said = f"esfem-willmore {version('esfem-willmore')} (numerics {numerics_digest()})\n"
    assert esfem("--version") == (0, said, "")


@pytest.mark.parametrize(
    ("command", "computes"),
    [
        ("judge-report", "esfem.campaigns.judge.run.simulate"),
        ("rough-starts", "esfem.campaigns.rough_starts.run.computed"),
    ],
)
def test_what_cannot_go_on_does_not_promise_it(command, computes, esfem, tmp_path, monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(computes, interrupt)
    status, _, err = esfem(command, "--out", tmp_path, "--jobs", 1)
    assert status == 130
    assert "interrupted: nothing is stored" in err and "continues" not in err
    assert list(tmp_path.iterdir()) == []


def test_what_goes_on_with_a_word_more_names_it(esfem, tmp_path, monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("esfem.campaigns.mutants.run.prepared", interrupt)
    status, _, err = esfem("mutants", "--out", tmp_path, "--jobs", 1)
    assert status == 130
    assert "the same command with --resume continues from there" in " ".join(err.split())


@pytest.mark.slow
def test_judge_report_writes_its_report(esfem, tmp_path, monkeypatch):
    from esfem.campaigns.judge import run as report

    monkeypatch.setattr(report, "simulate", lambda _, seed, advance, jobs: simulate(2, seed))
    status, _, err = esfem("judge-report", "--out", tmp_path / "judge", "--jobs", 1)
    assert status == 0 and "tables judged; written to" in err
    assert {path.name for path in (tmp_path / "judge").iterdir()} == {
        *("report.md", "rates.csv", "rates.svg"),
        *("calibration.csv", "calibration.svg"),
    }
