"""What results say of their origin."""

from esfem.common import provenance


def test_the_command_names_no_folder_of_this_machine(monkeypatch):
    monkeypatch.setattr("sys.argv", ["/somewhere/bin/esfem", "run", "sphere"])
    assert provenance.command() == "esfem run sphere"


def test_the_environment_names_versions_and_machine():
    environment = provenance.environment()
    assert environment["version"] == provenance.version()
    assert environment["numpy"].count(".") == 2
    assert environment["direct_solver"] in ("pardiso", "superlu")
    assert "Python" in environment["machine"]
