"""Two folders of results side by side: what is the same, what differs by a known factor."""

import io
import json
import shutil
from dataclasses import replace

import pandas as pd
import pytest
from pages import BASELINE, HOSTILE
from rich.console import Console
from stored import LADDER, of_study, stored

from esfem.campaigns.baseline.baseline import read_stored
from esfem.campaigns.baseline.compare import other_options
from esfem.campaigns.baseline.folders import (
    FORMATS,
    compare_folders,
    studies_table,
    variables_table,
)
from esfem.common.bad_input import BadInput
from esfem.results.result_files import own_digest

QUIET = Console(quiet=True)


def told(first, second, out=None):
    console = Console(width=80, file=io.StringIO())
    compare_folders(first, second, out, console)
    return console.file.getvalue()


@pytest.fixture
def copy(tmp_path):
    for name in ("theta-at-rest", "decay-sphere-2"):
        shutil.copytree(BASELINE / name, tmp_path / "other" / name)
    return tmp_path / "other"


def test_the_same_results_have_factor_one_and_the_same_orders(copy):
    pairs = [(read_stored(copy / "decay-sphere-2"),) * 2]
    (row,) = variables_table(pairs).to_dict("records")
    assert row["errors"] == "1"
    assert row["order 1"] == row["order 2"] != "-"
    assert row["effect"] == "same"
    (times,) = studies_table(pairs)
    assert times["equal"] == str(len(pairs[0][0].records))
    assert times["ratio"] == "1.00"


def test_a_planted_factor_is_told_and_leaves_the_order_alone():
    pairs = [(stored(lambda h: 0.7 * h**2), stored(lambda h: 2.1 * h**2))]
    (row,) = variables_table(pairs).to_dict("records")
    assert row["errors"] == "3"
    assert row["largest"] == "3" and row["largest at"].startswith("V = ")
    assert row["effect"] == "worse"
    assert row["order 1"].split()[0] == row["order 2"].split()[0] == "2.00"
    one, two = (float(row[f"fitted error {side}"]) for side in "12")
    assert two == pytest.approx(3.0 * one, rel=1e-2)


def test_a_planted_order_is_told():
    pairs = [(stored(lambda h: 0.7 * h**2), stored(lambda h: 0.7 * h**3))]
    (row,) = variables_table(pairs).to_dict("records")
    assert row["order 1"].startswith("2.00 [")
    assert row["order 2"].startswith("3.00 [")


def test_seconds_are_those_of_equal_cells():
    before, now = stored(lambda h: h**2), stored(lambda h: h**2)
    before.records["seconds"] = 1.0
    now.records["seconds"] = 3.0
    now = replace(now, records=now.records.iloc[:-1])
    (times,) = studies_table([(before, now)])
    assert times["equal"] == str(len(LADDER) - 1)
    assert times["ratio"] == "3.00"


def test_studies_that_one_folder_lacks_are_named(copy):
    found = told(BASELINE, copy)
    assert f"in {BASELINE} only: " in " ".join(found.split())
    assert "clifford-degree-2" in found.rpartition(" only: ")[2]
    assert "theta-at-rest: " in found


def test_another_problem_is_compared_all_the_same():
    before = stored(lambda h: h**2)
    now = of_study(before, scheme={"bdf": 1})
    assert other_options(before, now) == {"scheme.bdf": (2, 1)}
    (row,) = variables_table([(before, now)]).to_dict("records")
    assert row["errors"] == "1"


def test_the_option_that_makes_another_problem_is_named_with_both_values(copy):
    path = copy / "theta-at-rest" / "verdicts.json"
    content = json.loads(path.read_text())
    bdf = content["parameters"]["scheme"]["bdf"]
    content["parameters"]["scheme"]["bdf"] = bdf + 1
    content["digest"] = own_digest(content)
    path.write_text(json.dumps(content))
    (copy / "theta-at-rest" / "history.json").unlink()
    assert f"theta-at-rest: not the same problem, scheme.bdf = {bdf} -> {bdf + 1}\n" in told(
        BASELINE, copy
    )


@pytest.mark.parametrize("ending", ["md", "csv", "html"])
def test_the_table_is_written(copy, tmp_path, ending):
    out = tmp_path / f"table.{ending}"
    compare_folders(copy, copy, out, QUIET)
    assert "decay-sphere-2" in out.read_text()
    if ending == "csv":
        assert set(pd.read_csv(out)["effect"]) == {"same"}


def test_bad_arguments_are_one_line_and_status_2(copy, tmp_path, esfem):
    for words, reason in (
        ((copy, copy, "--out", tmp_path / "t.pdf"), "the ending must be one of"),
        ((copy, tmp_path / "none"), "holds no results"),
    ):
        status, _, err = esfem("compare", *words)
        assert status == 2 and reason in err


def test_what_cannot_be_written_is_bad_input(copy, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="cannot be written"):
        compare_folders(copy, copy, tmp_path / "file" / "t.md", QUIET)


def test_foreign_words_are_words_in_html():
    found = FORMATS[".html"](pd.DataFrame({HOSTILE: [HOSTILE]}))
    assert "<script>" not in found
    assert found.count("&lt;script&gt;alert(1)&lt;/script&gt;") == 2
