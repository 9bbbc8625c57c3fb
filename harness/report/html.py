"""The report as one HTML file that needs nothing else."""

from base64 import b64encode
from hashlib import sha256
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from esfem.common.bad_input import BadInput
from esfem.common.drawing import LOOKS, MARKERS, PALETTE
from esfem.report.content import own_provenance, plain_table, sentences_table, summary
from esfem.report.extra import StoredExtra
from esfem.report.results_folder import ResultsFolder
from esfem.report.sections import Section, pictures
from esfem.report.svg import inline, picture

TROUBLE = ("FAIL", "SUSPECT", "INCONCLUSIVE")  # stand first in the overview
SIGNS = dict(zip(MARKERS, "●■▲◆▼✚✱⬢", strict=True))  # what a marker looks like in a text
# The page loads nothing but pictures in itself, and runs no script but its own, whatever is in it.
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{}'"
GREEK = {"nu": "ν", "tau": "τ", "theta": "θ"}  # noqa: RUF001
LOADER = PackageLoader("esfem.report")


def html(results: ResultsFolder, studies: list[Section], flows: list[Section], title: str) -> str:
    """The whole page.

    Parameters
    ----------
    studies, flows : the sections of the ``results`` (`esfem.report.sections`).

    Raises
    ------
    BadInput
        If a figure or a picture cannot be read.
    """
    environment = _environment()
    script = LOADER.get_source(environment, "script.js")[0]
    extras = enumerate(results.extras.items())
    shown = {
        "title": title,
        "policy": policy(script),
        "script": Markup(script),
        "looks": {name.upper(): look for name, look in LOOKS.items()},
        "summary": summary(results),
        "overview": sorted(studies + flows, key=lambda section: section.outcome not in TROUBLE),
        "studies": studies,
        "flows": [
            (section, pictures(flow)) for section, flow in zip(flows, results.flows, strict=True)
        ],
        "sentences": sentences_table(results.sentences) if results.sentences else None,
        "extras": [extra_view(i, results, stem, extra) for i, (stem, extra) in extras],
        "unfinished": results.unfinished,
        "provenance": own_provenance(results),
    }
    return environment.get_template("report.html").render(shown)


def policy(script: str) -> str:
    """The Content-Security-Policy of a page with this script."""
    return POLICY.format(b64encode(sha256(script.encode()).digest()).decode("ascii"))


def _environment() -> Environment:
    found = Environment(
        loader=LOADER,
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters |= {"greek": lambda name: GREEK.get(name, name), "slug": slug}
    found.globals["source"] = lambda name: Markup(LOADER.get_source(found, name)[0])
    found.globals |= {"drawn": _drawn, "buttons": _buttons}
    return found


def slug(text: str) -> str:
    """The text as part of a class."""
    return text.lower().replace(" ", "-")


def _buttons(section: Section) -> list[tuple[str, str, str, str]]:
    """Class, label, colour and sign of each series in its figures."""
    return [
        (f"s{i}", label, PALETTE[i % len(PALETTE)], SIGNS[MARKERS[i % len(MARKERS)]])
        for i, label in enumerate(section.series)
    ]


def _drawn(section: Section, name: str) -> Markup:
    """A figure of the section as part of the page."""
    drawing = section.figures[name]
    return Markup(inline(drawing.svg, f"{section.anchor}-{name}", drawing.shows))


def extra_view(i: int, results: ResultsFolder, stem: str, extra: StoredExtra) -> dict[str, Any]:
    """What the template shows of a section of its own."""
    figure, table = None, None
    if extra.figure is not None:
        path = results.folder / "extra" / extra.figure
        if path.suffix != ".svg":
            raise BadInput(f"{stem}.json: figure = {extra.figure}: must be an SVG file")
        figure = picture(path)
    if extra.table:
        table = plain_table("table", "Numbers", extra.table)
    return {"anchor": f"extra-{i}", "extra": extra, "figure": figure, "table": table}
