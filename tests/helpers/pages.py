"""Folders of results for tests of reports, and a parser that is strict about HTML."""

import json
import shutil
from html.parser import HTMLParser
from pathlib import Path

from PIL import Image
from rich.console import Console
from studies import write_flow, write_study

from esfem.flows.flow_file import load_flow
from esfem.flows.run_flow import run_flow
from esfem.results.run_studies import run_studies

ROOT = Path(__file__).resolve().parents[2]
BASELINE = ROOT / "results" / "baseline"
VOID = ("meta", "br", "img", "link", "hr", "input")
HOSTILE = "<script>alert(1)</script> & $x_{$ \\end{document} 'q'"
FIGURE, PICTURE = "m_{a}p %#", "surf_{a}ces %#$"  # names of files, which LaTeX cannot read
# What a foreign figure may try: to run, to load, to style the page around it, to take an id.
SVG = """<?xml version="1.0"?>
<?xml-stylesheet href="http://evil.example/a.css"?>
<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"
 viewBox="0 0 10 10" onload="alert(1)" id="top">
<style>@IMPORT "http://evil.example/b.css"; body { background: url(http://evil.example/c.png) }
@import url(//evil.example/d.css);</style>
<script>alert(1)</script><script xlink:href="http://evil.example/e.js"/>
<g id="summary" class="badge" style="fill: red} body {display: none"><path d="M 0 0 L 9 9"/></g>
<rect fill="url(http://evil.example/f.svg#g)" STYLE="fill: URL('http://evil.example/h')"/>
<use xlink:href="http://evil.example/i.svg#j"/><use href="http://evil.example/k.svg#l"/>
<image xlink:href="http://evil.example/m.png" onclick="alert(1)"/>
<a xlink:href="javascript:alert(1)"><text>here</text></a>
<animate attributeName="href" to="javascript:alert(1)" onbegin="alert(1)"/>
<foreignObject><body xmlns="http://www.w3.org/1999/xhtml"><img src="http://evil.example/n"
 onerror="alert(1)"/><iframe src="http://evil.example/o"/></body></foreignObject></svg>
"""
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
    "text": f"One.\n\n{HOSTILE}",
    "table": [{"theta": True, "order": 2.0}, {"theta": HOSTILE, "order": None, HOSTILE: 1}],
    "figure": f"{FIGURE}.svg",
    "alt": f'A map" onerror="alert(1) {HOSTILE}',
}


def write_folder(folder: Path) -> Path:
    """A folder with all that a report may show: a study with a hostile title, one with diverged
    runs, a hostile flow with a picture of a bad name, sentences, a section of its own with a
    hostile figure, and a study without results."""
    study = write_study(folder, ('"A small study"', json.dumps(HOSTILE)))
    out = folder / "runs"
    run_studies([study], out=out, jobs=1)
    shutil.copytree(BASELINE / "clifford", out / "clifford")
    flow = load_flow(write_flow(folder, ('"A small flow"', json.dumps(HOSTILE))))
    run_flow(flow, folder, out / "flows", 30.0, False, False, Console(quiet=True))
    Image.new("RGB", (1500, 100), "red").save(out / "flows" / "small" / f"{PICTURE}.png")
    make_hostile(out / "flows" / "small" / "checks.json")
    (out / "sentences.json").write_text(json.dumps([SENTENCE]))
    write_extra(out, EXTRA)
    (out / "begun" / "records").mkdir(parents=True)
    return out


def make_hostile(path: Path) -> None:
    """Foreign words in what a flow tells of itself."""
    content = json.loads(path.read_text())
    content["reason"] = content["order_claim"] = content["environment"]["machine"] = HOSTILE
    content["checks"][0] |= {"name": HOSTILE, "text": HOSTILE}
    path.write_text(json.dumps(content))


def write_extra(out: Path, extra: dict) -> None:
    (out / "extra").mkdir(exist_ok=True)
    (out / "extra" / "ablation.json").write_text(json.dumps(extra))
    (out / "extra" / f"{FIGURE}.svg").write_text(SVG)
    Image.new("RGB", (10, 10), "red").save(out / "extra" / f"{FIGURE}.pdf")


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
