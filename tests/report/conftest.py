"""A folder of results with all that a report may show, and its report."""

from pathlib import Path

import pytest
from pages import write_folder
from shortcuts import SAVE, saved_by

from esfem.report.write import write_report


@pytest.fixture(scope="session")
def folder(tmp_path_factory) -> Path:
    with saved_by(SAVE):
        return write_folder(tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="session")
def report(folder) -> Path:
    with saved_by(SAVE):
        return write_report(folder, folder / "report").parent
