"""Studies by name: committed ones, files, and what is neither."""

from pathlib import Path

import pytest

from esfem.common.bad_input import BadInput
from esfem.studies.catalogue import full_studies, study_path


def test_a_name_that_is_no_study_lists_those_there_are():
    with pytest.raises(BadInput, match=r"spher: .* clifford, .*helfrich-bdf3"):
        study_path("spher")


def test_a_folder_does_not_shadow_a_committed_study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("sphere").mkdir()
    assert study_path("sphere").name == "sphere.toml"
    Path("clifford").touch()
    assert study_path("clifford") == Path("clifford")


def test_a_name_too_long_is_refused():
    with pytest.raises(BadInput, match="cannot be read"):
        study_path("s" * 300)


def test_a_full_study_is_accepted_by_name():
    assert study_path("helfrich-bdf3") in full_studies()
