"""What the program wrote before there were rooms is read, or refused by name.

tests/before has a small study and a small flow, without their figures.
"""

import shutil
from pathlib import Path

import pytest
from studies import write_study

import esfem as package
from esfem.common.provenance import numerics_digest

ROOT = Path(package.__file__).resolve().parent.parent
THEIRS = "b7aabcb10dd226fd"


@pytest.fixture
def before(tmp_path) -> Path:
    return shutil.copytree(ROOT / "tests/before", tmp_path / "before")


@pytest.mark.parametrize("words", [(), ("--judge",)])
def test_its_tables_are_printed(command, before, words):
    status, out = command("table", before / "small", *words)
    assert status == 0
    assert "A small study" in out
    assert ("an order needs 4" if words else "too few levels") in out


def test_its_orders_are_compared(command, before):
    status, out = command("compare", before, before)
    assert status == 0
    assert "2 runs equal in (V, tau)" in out


@pytest.mark.slow
def test_its_report_is_written(command, before):
    status, _ = command("report", before)
    assert status == 0
    page = (before / "report/index.html").read_text(encoding="utf-8")
    assert "A small study" in page and "A small flow" in page and THEIRS in page


def test_it_is_no_evidence_of_what_this_program_computes(command, before):
    status, out = command("check", "small", "--read", "--out", before, "--baseline", before)
    assert status == 3
    assert f"numerics {numerics_digest()} -> computed by numerics {THEIRS}" in out


@pytest.mark.slow
def test_its_records_are_left_alone_and_computed_anew(command, before, tmp_path):
    record = before / "small/records/662a81fa23952eb6.json"
    text = record.read_text(encoding="utf-8")
    study = write_study(
        tmp_path, ("[30, 60, 120, 240, 480]", "[30, 60]"), ("[0.25, 0.125]", "[0.25]")
    )
    command("run", study, "--out", before, "--jobs", 1)
    assert record.read_text(encoding="utf-8") == text
    stored = [path.read_text(encoding="utf-8") for path in record.parent.iterdir()]
    assert sum(numerics_digest() in content for content in stored) == len(stored) - 1 == 4
