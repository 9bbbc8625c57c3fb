"""[study.superconvergent]: more than the order is declared in sentences."""

import pytest
from studies import SMALL, write_varied

from esfem.common.bad_input import BadInput
from esfem.studies.catalogue import study_sets
from esfem.studies.study import load_study

LINE = 'superconvergent = { x = "A", nu = "B", H = "C" }'


def declared(folder, line):
    return load_study(write_varied(folder / "study.toml", SMALL, (LINE, line))).study


def test_a_list_is_refused_and_the_message_shows_a_table(tmp_path):
    with pytest.raises(BadInput, match=r"must be a table \[study\.superconvergent\] of sentences"):
        declared(tmp_path, 'superconvergent = ["x"]')


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('superconvergent = { y = "why" }', r"superconvergent\.y = 'y': must be one of x, nu"),
        ('superconvergent = { x = "" }', r"superconvergent\.x = '': must be a sentence"),
        ("superconvergent = { x = 2.0 }", r"superconvergent\.x = 2\.0: must be a sentence"),
        ('superconvergent.error = "why"', r"superconvergent\.error = 'why': must be a table"),
        (
            'superconvergent.interpolation.y = "why"',
            r"superconvergent\.interpolation\.y = 'y': must be one of x, nu",
        ),
    ],
)
def test_what_is_no_such_table_is_refused(tmp_path, line, message):
    with pytest.raises(BadInput, match=message):
        declared(tmp_path, line)


def test_it_is_of_both_errors_or_of_one(tmp_path):
    about = declared(
        tmp_path, 'superconvergent = { x = "both", interpolation = { x = "own", nu = "one" } }'
    )
    for variable, error, why in [
        ("x", "error", "both"),
        ("x", "interpolation", "own"),
        ("nu", "error", ""),
        ("nu", "interpolation", "one"),
        ("H", "error", ""),
    ]:
        assert about.why_more(variable, error) == why


def test_every_committed_one_says_why():
    studies = [load_study(path) for paths in study_sets().values() for path in paths]
    assert sum(bool(study.study.superconvergent) for study in studies) > 10
