"""``esfem judge``: what it prints, what it writes, how it ends."""

import json

import numpy as np
import pandas as pd
import pytest
from judged import LADDER, grid, line


@pytest.fixture
def judge(esfem, tmp_path):
    """Runs the command on a table or a text: exit status, what was printed, what was complained."""

    def run(content, *words):
        path = tmp_path / "errors.csv"
        if isinstance(content, pd.DataFrame):
            content.to_csv(path, index=False)
        elif content is not None:
            path.write_bytes(content)
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
    assert code == 0 and "joint fit: 1 h^2.00 + 0.5 tau^2.00" in out


def test_the_order_in_tau_is_judged_on_request(judge):
    table = line(LADDER**2).rename(columns={"h": "tau"}).assign(h=0.1)
    assert judge(table, "--order", 2, "--direction", "tau")[0] == 0


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
        (b"", (), "cannot be read"),
        (b"\xff\xfe\x00\x01", (), "cannot be read"),
        (b'h,error\n"1,2\n3,4,5\n', (), "cannot be read"),
        (b"h,error\n", (), "no rows"),
        (b"h,mistake\n1,1\n", (), "column error: missing"),
        (b"h,error\n1,one\n", (), "column error"),
        (b"h,error\n1,-1\n", (), "negative"),
        (b"h,error\n1,1\n1,2\n", (), "given twice"),
        (b"h,error,variable\n1,1,x\n0.5,1,\n", (), "without a name"),
        (b"h,error\n1,1\n", ("--variable", "x"), "no column variable"),
        (b"h,error,variable\n1,1,x\n", ("--variable", "y"), "has x"),
        (b"h,error,variable\n1,1,x\n1,1,x\n", (), "variable x: column h"),
        (b"h,error\n1,1\n", ("--direction", "time"), "must be one of h, tau"),
        (b"h,error\n1,1\n", ("--tolerance", "0"), "must be positive"),
        (b"h,error\n1,1\n", ("--json", "/dev/null/out.json"), "--json /dev/null/out.json"),
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
