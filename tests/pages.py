"""Folders of results for tests of reports, and a parser that is strict about HTML."""

import json
import shutil
from html.parser import HTMLParser
from pathlib import Path

from PIL import Image
from rich.console import Console
from studies import write_study
from test_flow_command import write_flow

from harness.api import run_studies
from harness.flows.command import run_flow
from harness.flows.flow_file import load_flow

ROOT = Path(__file__).resolve().parent.parent
BASELINE = ROOT / "results" / "baseline"
VOID = ("meta", "br", "img", "link", "hr", "input")
HOSTILE = "<script>alert(1)</script> & $x_{$ \\end{document} 'q'"
SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"><script>alert(1)</script>'
    '<defs><path id="dot" d="M 0 0 L 1.23456 1"/></defs>'
    '<use href="#dot" onclick="alert(1)"/><g id="series-0-x" style="fill: url(#dot)"/>'
    '<use href="http://example.org/x.svg#y"/></svg>'
)
SENTENCE = {
    "label": "MainTHM",
    "section": "4.1",
    "quote": HOSTILE,
    "study": "clifford",
    "measured": 2.125,
    "expected": "order ≥ 2",
    "verdict": "suspect",
    "note": "",
}
EXTRA = {
    "title": "Ablation",
    "text": "One.\n\nTwo.",
    "table": [{"theta": True, "order": 2.0}, {"theta": False, "order": None}],
    "figure": "map.svg",
    "alt": "A map of cells",
}


def write_folder(folder: Path) -> Path:
    """A folder with all that a report may show: a study with a hostile title, one with diverged
    runs, a flow with a picture, sentences, a section of its own, and a study without results."""
    study = write_study(folder, ('"A small study"', json.dumps(HOSTILE)))
    out = folder / "runs"
    run_studies([study], out=out, jobs=1)
    shutil.copytree(BASELINE / "clifford", out / "clifford")
    flow = load_flow(write_flow(folder))
    run_flow(flow, folder, out / "flows", 30.0, False, False, Console(quiet=True))
    Image.new("RGB", (1500, 100), "red").save(out / "flows" / "small" / "surfaces.png")
    (out / "sentences.json").write_text(json.dumps([SENTENCE]))
    write_extra(out, EXTRA)
    (out / "begun" / "records").mkdir(parents=True)
    return out


def write_extra(out: Path, extra: dict) -> None:
    (out / "extra").mkdir(exist_ok=True)
    (out / "extra" / "ablation.json").write_text(json.dumps(extra))
    (out / "extra" / "map.svg").write_text(SVG)


class Page(HTMLParser):
    """Every element as (tag, attributes, text of its own), and what is wrong with the nesting."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: list[tuple[str, dict, list[str]]] = []
        self.open: list[tuple[str, dict, list[str]]] = []
        self.wrong: list[str] = []
        self.feed(text)
        self.close()
        self.wrong += [f"<{tag}> is not closed" for tag, _, _ in self.open]

    def handle_starttag(self, tag, attrs):
        if len(dict(attrs)) != len(attrs):
            self.wrong.append(f"<{tag}>: an attribute occurs twice")
        element = (tag, dict(attrs), [])
        self.elements.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs), []))

    def handle_endtag(self, tag):
        if not self.open or self.open.pop()[0] != tag:
            self.wrong.append(f"</{tag}> closes another element")

    def handle_data(self, data):
        for element in self.open[-1:]:
            element[2].append(data)

    def all(self, tag):
        """Attributes and own text of each element of that name."""
        return [(a, "".join(t)) for name, a, t in self.elements if name == tag]

    @property
    def ids(self):
        return [a["id"] for _, a, _ in self.elements if "id" in a]
