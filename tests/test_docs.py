"""The pages of docs/: they build, what they name is there, and they load nothing."""

import re
import subprocess
import sys
import tomllib
from html.parser import HTMLParser
from pathlib import Path

import pytest

import esfem
from esfem import reference_solutions, solver

ROOT = Path(esfem.__file__).resolve().parent.parent
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.glob("*.md"))
README = (ROOT / "README.md").read_text(encoding="utf-8")


def rooms() -> dict[str, tuple[str, list[str]]]:
    """The table in the docstring of the package: job and public names of each room."""
    _, head, body, *_ = re.split(r"^=+  =+  =+$", esfem.__doc__, flags=re.MULTILINE)
    job = head.index("one job") - 1
    names = head.index("public names") - 1
    found: dict[str, list[str]] = {}
    for line in body.strip("\n").splitlines():
        if room := line[:job].strip():
            found[room] = ["", ""]
        cells = found[list(found)[-1]]
        cells[0] += f" {line[job:names].strip()}"
        cells[1] += line[names:]
    return {room: (job.strip(), re.findall(r"`(\w+)`", own)) for room, (job, own) in found.items()}


class TestRooms:
    def test_the_table_has_the_layers_of_import_linter_from_the_ground_up(self):
        project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
        layers = project["tool"]["importlinter"]["contracts"][0]["layers"]
        assert list(rooms()) == layers[-2:0:-1]

    @pytest.mark.parametrize("room", rooms())
    def test_its_public_names_are_defined_in_it(self, room):
        files = (ROOT / "harness" / room).rglob("*.py")
        text = "\n".join(path.read_text(encoding="utf-8") for path in files)
        for name in rooms()[room][1]:
            assert re.search(rf"^(def|class) {name}\b", text, re.MULTILINE), name

    @pytest.mark.parametrize("room", rooms())
    def test_it_says_its_job(self, room):
        text = (ROOT / "harness" / room / "__init__.py").read_text(encoding="utf-8")
        assert len(text.partition("\n")[0].split()) >= 6

    def test_readme_has_the_table(self):
        section = README.partition("\n## The house\n")[2].partition("\n## ")[0]
        rows = dict(re.findall(r"^\| `(\w+)` \| (.*?) \|", section, re.MULTILINE))
        assert {room: job for room, (job, _) in rooms().items()}.items() <= rows.items()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_link_leads_to_a_file(page):
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
        assert (DOCS / target).exists(), target


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES], ids=lambda page: page.stem)
def test_every_file_of_the_program_that_is_named_is_there(page):
    named = re.findall(
        r"`((?:harness|solver|reference_solutions|tests)/[\w./-]*)`",
        page.read_text(encoding="utf-8"),
    )
    for target in named:
        assert (ROOT / target).exists() or target.endswith("__pycache__"), target


class Loads(HTMLParser):
    """What a page loads when it is opened; links to be clicked are not among it."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag != "a":
            self.found += [given[name] for name in ("src", "href", "data") if given.get(name)]


@pytest.mark.slow
class TestBuilt:
    @pytest.fixture(scope="class")
    @staticmethod
    def html(tmp_path_factory) -> Path:
        """The pages, built as by `make docs`: a warning is an error."""
        out = tmp_path_factory.mktemp("html")
        command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
        done = subprocess.run([*command, DOCS, out], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return out

    def test_pages_and_styles_load_nothing_from_elsewhere(self, html):
        pages = list(html.glob("*.html"))
        assert len(pages) > len(PAGES)
        for page in pages:
            loads = Loads()
            loads.feed(page.read_text(encoding="utf-8"))
            assert len(loads.found) > 5
            for address in loads.found:
                assert not re.match(r"(\w+:)?//", address), f"{page.name}: {address}"
        for style in html.rglob("*.css"):
            text = style.read_text(encoding="utf-8")
            assert not re.search(r"(url\(|@import) *[\"']?(https?:)?//", text), style

    def test_the_architecture_has_the_rooms(self, html):
        text = " ".join((html / "architecture.html").read_text(encoding="utf-8").split())
        assert all(job in text for job, _ in rooms().values())

    def test_the_api_has_what_the_packages_offer(self, html):
        text = (html / "python-api.html").read_text(encoding="utf-8")
        for package in (esfem, solver, reference_solutions):
            for name in package.__all__:
                assert f'id="{package.__name__}.{name}"' in text, name
