"""Tables that people have, published ones and odd files: read right, judged as by an expert."""

import re
import tomllib
from pathlib import Path

import pytest

FIELD = Path(__file__).parent / "field"
ROOT = Path(__file__).resolve().parents[2]
CASES = tomllib.loads((FIELD / "cases.toml").read_text(encoding="utf-8"))
VERDICTS = ("NOT EXERCISED", "INCONCLUSIVE", "SUSPECT", "SUPER", "PASS", "FAIL")
STATUS = {"PASS": 0, "SUPER": 0, "FAIL": 1, "SUSPECT": 1, "INCONCLUSIVE": 3, "NOT EXERCISED": 3}


def verdict_of(out: str) -> str:
    """The verdict in the row below the heads of the table."""
    row = out.splitlines()[2]
    return next(word for word in VERDICTS if word in row)


def judged_table(name, order):
    waits = pytest.mark.xfail(reason="the judge does not decide what an expert does", strict=True)
    marks = [waits] if f"{name} {order}" in CASES["waiting"] else []
    return pytest.param(name, order, marks=marks, id=f"{name} {order}")


@pytest.mark.parametrize(("name", "order", "verdicts"), CASES["tables"])
def test_a_published_table_is_read(esfem, name, order, verdicts):
    path = FIELD / "tables" / f"{name}.csv"
    _, out, err = esfem("judge", path, "--order", *order.split())
    rows = len(path.read_text().splitlines()) - 1
    assert err == "" and out.startswith(
        f"{path}: comma-separated, {rows} rows; h: h; errors: error\n"
    )


WANTED = {f"{name} {order}": verdicts for name, order, verdicts in CASES["tables"]}


@pytest.mark.parametrize(
    ("name", "order"), [judged_table(name, order) for name, order, _ in CASES["tables"]]
)
def test_a_published_table_is_judged_as_by_an_expert(esfem, name, order):
    status, out, _ = esfem("judge", FIELD / "tables" / f"{name}.csv", "--order", *order.split())
    verdict = verdict_of(out)
    assert verdict.replace(" ", "_") in WANTED[f"{name} {order}"].split()
    assert status == STATUS[verdict]


@pytest.mark.parametrize(("name", "order", "verdicts"), CASES["tables"])
def test_no_word_of_time_where_there_is_none(esfem, name, order, verdicts):
    _, out, _ = esfem("judge", FIELD / "tables" / f"{name}.csv", "--order", *order.split())
    assert not re.search(r"\btau\b|in time|time step", out)


@pytest.mark.parametrize(("name", "words", "read", "verdicts"), CASES["formats"])
def test_a_file_is_read_or_refused_by_its_place(esfem, name, words, read, verdicts):
    status, out, err = esfem("judge", FIELD / "formats" / name, *words.split())
    if verdicts == "REFUSED":
        assert status == 2 and out == "" and read in err and len(err.splitlines()) == 1
        return
    assert err == "" and read in out.splitlines()[0]
    verdict = verdict_of(out)
    assert verdict in verdicts.split() and status == STATUS[verdict]


def test_every_file_of_the_field_is_tried():
    tried = {f"{name}.csv" for name, *_ in CASES["tables"]} | {n for n, *_ in CASES["formats"]}
    assert tried == {path.name for path in FIELD.glob("*/*")}


def test_the_path_and_its_claim_are_said(esfem):
    table = FIELD / "formats" / "g01-diagonal-tau-h2.csv"
    _, out, _ = esfem("judge", table, "--order", 3, "--order", "tau=1")
    assert "refined together, tau ~ h^2: judged along that path, where order 2" in out


def test_the_worked_example_of_the_docs_is_what_comes_out(esfem, tmp_path):
    """The command, the table as it is pasted, and the line that says how it was read."""
    page = (ROOT / "docs" / "judge-any-table.md").read_text(encoding="utf-8")
    lines = page.partition("    $ esfem judge - ")[2].splitlines()
    end = next(i for i, line in enumerate(lines) if line.startswith("    -: "))
    path = tmp_path / "pasted.txt"
    path.write_text("\n".join(line[4:] for line in lines[1:end]))
    status, out, _ = esfem("judge", path, *lines[0].split())
    assert status in (0, 3)
    assert out.splitlines()[0] == f"{path}: {lines[end].partition('-: ')[2]}"
