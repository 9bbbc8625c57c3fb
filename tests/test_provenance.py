"""What results say of their origin, and what makes a stored run obsolete."""

from pathlib import Path

import pytest

from harness import provenance

SOURCE = '''
"""Module."""
def f(x):
    """Function."""
    return x + 1  # a comment
'''


@pytest.fixture
def code(tmp_path):
    def of(text: str) -> str:
        path = tmp_path / "module.py"
        path.write_text(text)
        return provenance.code(path)

    return of


@pytest.mark.parametrize(
    ("old", "new"),
    [("Function.", "Another text."), ("  # a comment", ""), ("x + 1", "(x\n     + 1)")],
)
def test_docstrings_comments_and_layout_do_not_count(code, old, new):
    assert code(SOURCE.replace(old, new)) == code(SOURCE)


@pytest.mark.parametrize(("old", "new"), [("+", "-"), ("1", "2"), ("return x", "return -x")])
def test_every_change_of_a_formula_counts(code, old, new):
    assert code(SOURCE.replace(old, new)) != code(SOURCE)


def test_the_numerics_cover_solver_references_and_error_norms():
    root = Path(provenance.__file__).parent.parent
    covered = {path for pattern in provenance.NUMERICS for path in root.glob(pattern)}
    for name in ("solver/forms.py", "reference_solutions/torus.py", "harness/errors.py"):
        assert root / name in covered


def test_the_command_names_no_folder_of_this_machine(monkeypatch):
    monkeypatch.setattr("sys.argv", ["/somewhere/bin/esfem", "run", "sphere"])
    assert provenance.command() == "esfem run sphere"


def test_the_environment_names_versions_and_machine():
    environment = provenance.environment()
    assert environment["version"] == provenance.version()
    assert environment["numpy"].count(".") == 2
    assert environment["direct_solver"] in ("pardiso", "superlu")
    assert "Python" in environment["machine"]
