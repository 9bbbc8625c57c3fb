"""``esfem judge``: what it prints, what it writes, how it ends."""

import io
import json
import re

import numpy as np
import pandas as pd
import pytest
from judged import LADDER, grid, line

from esfem.common.tables import table_in


@pytest.fixture
def judge(esfem, tmp_path):
    """Runs the command on a table or a text: exit status, what was printed, what was complained."""

    def run(content, *words):
        path = tmp_path / "errors.csv"
        if isinstance(content, pd.DataFrame):
            content.to_csv(path, index=False)
        elif isinstance(content, bytes):
            path.write_bytes(content)
        path = "-" if isinstance(content, str) else path
        return esfem("judge", path, *words)

    return run


@pytest.mark.parametrize(
    ("errors", "status", "word"),
    [
        (LADDER**2, 0, "PASS"),
        (LADDER**3, 0, "SUPER"),
        (LADDER, 1, "FAIL"),
        (LADDER**5, 1, "SUSPECT"),
        (LADDER**2 + 0.03, 3, "INCONCLUSIVE"),
    ],
)
def test_the_exit_status_is_that_of_the_verdict(judge, errors, status, word):
    code, out, err = judge(line(errors), "--order", 2)
    assert (code, err) == (status, "") and word in out


def test_the_worst_variable_decides_unless_one_is_chosen(judge):
    table = pd.concat([line(LADDER**2).assign(variable="x"), line(LADDER).assign(variable="[b]nu")])
    code, out, _ = judge(table, "--order", 2)
    assert code == 1 and "PASS" in out and "FAIL" in out and "[b]nu" in out
    code, out, _ = judge(table, "--order", 2, "--variable", "x")
    assert code == 0 and "nu" not in out


def test_several_time_steps_are_fitted_together(judge):
    code, out, _ = judge(grid(lambda h, tau: h**2 + 0.5 * tau**2), "--order", 2)
    assert code == 0 and re.search(r"joint fit: (1|0.99\d) h\^2.00 \+ 0.\d+ tau\^2.00", out)


def test_the_order_in_tau_is_judged_on_request(judge):
    table = line(LADDER**2).rename(columns={"h": "tau"}).assign(h=0.1)
    assert judge(table, "--order", 2, "--direction", "tau")[0] == 0


def test_each_column_is_judged_by_its_order_and_the_worst_decides(judge):
    table = line(LADDER**2).rename(columns={"error": "L2"}).assign(H1=LADDER, cpu=1.0)
    code, out, _ = judge(table, "--order", "l2=2", "--order", "h1=1")
    assert code == 0 and out.count("PASS") == 2 and "2 - 0.2 in h" in out and "1 - 0.2 in h" in out
    assert judge(table, "--order", "l2=2", "--order", "h1=2")[0] == 1
    code, out, _ = judge(table, "--order", 2, "--error", "L2")
    assert code == 0 and "H1" not in out


def test_standard_input_is_a_file(judge, monkeypatch):
    text = line(LADDER**2).to_markdown(index=False)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    code, out, _ = judge("-", "--order", 2)
    assert code == 0 and out.startswith("-: Markdown table, 6 rows; h: h; errors: error")


def test_nothing_exercised_is_status_3(judge):
    code, out, _ = judge(line(LADDER**2), "--order", 2, "--floor", "solver=10")
    assert code == 3 and "NOT EXERCISED" in out


def test_one_pass_beside_what_was_not_exercised_is_enough(judge):
    table = line(LADDER**2).rename(columns={"error": "x"}).assign(y=0.0)
    words = ("--error", "x", "--error", "y", "--floor", "rounding=1e-15")
    code, out, _ = judge(table, "--order", 2, *words)
    assert code == 0 and "NOT EXERCISED" in out and "PASS" in out


def test_a_higher_order_is_expected_on_request(judge):
    assert judge(line(LADDER**5), "--order", 2)[0] == 1
    code, out, _ = judge(line(LADDER**5), "--order", 2, "--at-least")
    assert code == 0 and "at least 2" in out


def test_levels_are_chosen(judge):
    errors = LADDER**2 * [40, 1, 1, 1, 1, 1]
    code, out, _ = judge(line(errors), "--order", 2, "--levels", "2:")
    assert code == 0 and "5 of 6 levels are judged as asked" in out


class TestFiles:
    """What is written, and read again."""

    def test_markdown_and_latex_hold_the_table(self, judge, tmp_path):
        places = {kind: tmp_path / f"out.{kind}" for kind in ("markdown", "latex")}
        words = [word for kind, place in places.items() for word in (f"--{kind}", place)]
        code, out, _ = judge(line(LADDER**2), "--order", 2, *words)
        assert code == 0 and "PASS" in out
        for place in places.values():
            table = table_in(place.read_text())
            row = table.rows[0].cells
            assert row[table.names.index("verdict")] == "PASS"
            assert float(row[table.names.index("order")]) == 2.0

    @pytest.mark.parametrize("kind", ["json", "markdown", "latex"])
    def test_a_dash_prints_it_alone(self, judge, kind):
        code, out, _ = judge(line(LADDER**2), "--order", 2, f"--{kind}", "-")
        assert code == 0
        if kind == "json":
            assert json.loads(out)["judgements"][""]["outcome"] == "pass"
        else:
            assert table_in(out).rows[0].cells[1] == "PASS"

    @pytest.mark.usefixtures("figures")
    @pytest.mark.parametrize("ending", ["pdf", "svg", "png"])
    def test_a_figure_is_drawn(self, judge, tmp_path, ending):
        table = line(LADDER**2).rename(columns={"error": "L2"}).assign(Linf=LADDER**2 / 3)
        table.loc[0, "Linf"] = np.nan
        place = tmp_path / f"f.{ending}"
        assert judge(table, "--order", 2, "--plot", place)[0] == 0
        content = place.read_bytes()
        assert content.startswith({"pdf": b"%PDF", "svg": b"<?xml", "png": b"\x89PNG"}[ending])
        if ending == "svg":
            assert b"L2: PASS, order 2.00" in content and b"Linf: slope 2" in content

    @pytest.mark.usefixtures("figures")
    def test_a_figure_of_what_cannot_be_judged_is_drawn(self, judge, tmp_path):
        place = tmp_path / "f.svg"
        assert judge(line(LADDER**2, LADDER).head(2), "--order", 2, "--plot", place)[0] == 3
        assert b"error: INCONCLUSIVE" in place.read_bytes()


def test_masked_runs_and_the_next_run_are_printed(judge):
    table = line(LADDER**2)
    table.loc[5, "error"] = np.nan
    code, out, _ = judge(table, "--order", 2)
    assert code == 3
    assert "masked: h = 0.124: no error" in out and "next run: h = 0.124" in out


def test_the_json_file_holds_the_judgement_and_its_origin(judge, tmp_path):
    target = tmp_path / "out.json"
    code, _, _ = judge(line(LADDER**2, LADDER), "--order", 2, "--json", target)
    content = json.loads(target.read_text())
    assert code == 0 and content["outcome"] == "pass"
    assert content["judgements"][""]["order"] == pytest.approx(2.0)
    assert content["version"] and content["command"] and content["machine"]


@pytest.mark.parametrize(
    ("content", "words", "complaint"),
    [
        (None, (), "cannot be read"),
        (b"", (), "is empty"),
        (b"\xff\xfe\x00\xd8", (), "cannot be read"),
        (b'h,error\n"1,2\n3,4,5\n', (), "line 2 cannot be read"),
        (b"h,error\n", (), "no rows"),
        (b"h,mistake\n1,1\n", (), "no column of errors is known among h, mistake: give it with"),
        (b"h,error\n1,one\n", (), "row 1 (line 2), column error: 'one' is no number"),
        (b"h,error\n1,-1\n", (), "negative"),
        (b"h,error\n1,1\n1,2\n", (), "given twice"),
        (b"h,error,variable\n1,1,x\n0.5,1,\n", (), "without a name"),
        (b"h,error\n1,1\n", ("--variable", "x"), "no column variable"),
        (b"h,error,variable\n1,1,x\n", ("--variable", "y"), "has x"),
        (b"h,error,variable\n1,1,x\n1,1,x\n", (), "x: row 1 (line 2) and row 2 (line 3): h"),
        (b"h,error\n1,1\n", ("--direction", "time"), "must be one of h, tau"),
        (b"h,error\n1,1\n", ("--tolerance", "0"), "must be positive"),
        (b"h,error\n1,1\n", ("--json", "/dev/null/out.json"), "--json /dev/null/out.json"),
        (b"h,error\n1,1\n", ("--latex", "/dev/null/out.tex"), "--latex /dev/null/out.tex"),
        (b"h,error\n1,1\n", ("--plot", "out.gif"), "must end with .pdf, .svg, .png"),
        (b"h,error\n1,1\n", ("--plot", "/dev/null/out.pdf"), "--plot /dev/null/out.pdf"),
        (b"h,error\n1,1\n", ("--order", "3"), "an order is given"),
        (b"h,error\n1,1\n", ("--dim", "4"), "must be 1, 2 or 3"),
        (b"h,error\n1,1\n", ("--ratio", "2"), "must be below 1"),
        (b"h,error\n1,1\n", ("--levels-min", "2"), "3 levels at least"),
        (b"h,error\n1,1\n", ("--floor", "rounding"), "--floor rounding: must be"),
        (b"h,error\n1,1\n", ("--decimal", "dot"), "must be one of point, comma"),
        (b"h,error\n1,1\n", ("--table", "2"), "must be 1 to 1"),
    ],
)
def test_bad_input_is_one_line_and_status_2(judge, content, words, complaint):
    code, _, err = judge(content, "--order", 2, *words)
    assert code == 2
    assert complaint in err and len(err.strip().splitlines()) == 1


@pytest.mark.parametrize("order", ["0", "-1", "nan", "inf"])
def test_a_claimed_order_is_positive(judge, order):
    code, _, err = judge(line(LADDER), "--order", order)
    assert code == 2 and "--order" in err


def test_a_file_that_is_too_large_for_a_table_is_refused_at_once(judge, monkeypatch):
    """Not read for minutes; as much as that is read."""
    table = b"h,L2\n0.5,0.25\n0.25,0.0625\n0.125,0.0156\n0.0625,0.0039\n"
    monkeypatch.setattr("esfem.cli.judge.LARGEST", len(table))
    assert judge(table, "--order", 2)[0] == 0
    code, _, err = judge(table + b"\n", "--order", 2)
    assert code == 2 and "that is no table of errors" in err
