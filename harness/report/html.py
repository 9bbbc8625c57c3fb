"""The report as one HTML file that needs nothing else."""

from base64 import b64encode
from hashlib import sha256
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from esfem.common.bad_input import BadInput
from esfem.common.drawing import LOOKS, MARKERS, PALETTE
from esfem.flows.flow_results import FlowResult
from esfem.report import flow_content, study_content
from esfem.report.content import chip, own_provenance, plain_table, sentences_table, summary
from esfem.report.drawings import Drawings, anchor_of
from esfem.report.inputs import Extra, Inputs
from esfem.report.svg import inline, picture
from esfem.results.remarks import remarks
from esfem.results.study_result import StudyResult

TROUBLE = ("FAIL", "SUSPECT", "INCONCLUSIVE")  # stand first in the overview
SIGNS = dict(zip(MARKERS, "●■▲◆▼✚✱⬢", strict=True))  # what a marker looks like in a text
# The page loads nothing but pictures in itself, and runs no script but its own, whatever is in it.
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{}'"
GREEK = {"nu": "ν", "tau": "τ", "theta": "θ"}  # noqa: RUF001


def html(inputs: Inputs, drawings: Drawings, title: str) -> str:
    """The whole page.

    Parameters
    ----------
    drawings : the figures of studies and flows (`esfem.report.drawings.draw`).

    Raises
    ------
    BadInput
        If a figure or a picture cannot be read.
    """
    studies = [study_view(result, drawings) for result in inputs.studies]
    flows = [flow_view(result, drawings) for result in inputs.flows]
    extras = enumerate(inputs.extras.items())
    environment = _environment()
    script = environment.loader.get_source(environment, "script.js")[0]
    shown = {
        "title": title,
        "policy": policy(script),
        "script": Markup(script),
        "looks": {name.upper(): look for name, look in LOOKS.items()},
        "summary": summary(inputs),
        "overview": sorted(studies + flows, key=lambda view: view["outcome"] not in TROUBLE),
        "studies": studies,
        "flows": flows,
        "sentences": sentences_table(inputs.sentences) if inputs.sentences else None,
        "extras": [extra_view(i, inputs, stem, extra) for i, (stem, extra) in extras],
        "unfinished": inputs.unfinished,
        "provenance": own_provenance(inputs),
    }
    return environment.get_template("report.html").render(shown)


def policy(script: str) -> str:
    """The Content-Security-Policy of a page with this script."""
    return POLICY.format(b64encode(sha256(script.encode()).digest()).decode("ascii"))


def _environment() -> Environment:
    loader = PackageLoader("esfem.report")
    found = Environment(
        loader=loader,
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters |= {"greek": lambda name: GREEK.get(name, name), "slug": slug}
    found.globals["source"] = lambda name: Markup(loader.get_source(found, name)[0])
    return found


def slug(text: str) -> str:
    """The text as part of a class."""
    return text.lower().replace(" ", "-")


def study_view(result: StudyResult, drawings: Drawings) -> dict[str, Any]:
    """What the template shows of a study."""
    study, anchor = result.study, anchor_of(result)
    claim = study.claimed
    labels = [label for label, _ in result.series]
    tables = [
        study_content.verdicts(result),
        *study_content.errors(result),
        study_content.masked(result),
        study_content.meshes(result),
        study_content.timings(result),
    ]
    return {
        "anchor": anchor,
        "name": study.name,
        "title": study.title,
        "outcome": result.outcome.upper(),
        "claim": claim,
        "describe": result.words.case,
        "norms": result.words.errors,
        "chips": [chip(verdict) for verdict in result.verdicts],
        "figures": _figures(anchor, drawings),
        "series": [
            (f"s{i}", label, PALETTE[i % len(PALETTE)], SIGNS[MARKERS[i % len(MARKERS)]])
            for i, label in enumerate(labels)
        ],
        "remarks": remarks(result),
        "tables": [table for table in tables if len(table.frame)],
        "provenance": study_content.provenance(result),
    }


def flow_view(result: FlowResult, drawings: Drawings) -> dict[str, Any]:
    """What the template shows of a flow."""
    anchor = anchor_of(result)
    return {
        "anchor": anchor,
        "name": f"flow {result.flow.name}",
        "title": result.flow.flow.title,
        "outcome": result.outcome.upper(),
        "describe": flow_content.course(result),
        "claim": None,
        "chips": [
            {"variable": check.name, "outcome": check.verdict.upper(), "value": ""}
            for check in result.checks
        ],
        "figures": _figures(anchor, drawings),
        "pictures": flow_content.pictures(result),
        "tables": [flow_content.checks(result), flow_content.levels(result)],
        "provenance": flow_content.provenance(result),
    }


def extra_view(i: int, inputs: Inputs, stem: str, extra: Extra) -> dict[str, Any]:
    """What the template shows of a section of its own."""
    figure, table = None, None
    if extra.figure is not None:
        path = inputs.folder / "extra" / extra.figure
        if path.suffix != ".svg":
            raise BadInput(f"{stem}.json: figure = {extra.figure}: must be an SVG file")
        figure = picture(path)
    if extra.table:
        table = plain_table("table", "Numbers", extra.table)
    return {"anchor": f"extra-{i}", "extra": extra, "figure": figure, "table": table}


def _figures(anchor: str, drawings: Drawings) -> dict[str, Markup]:
    return {
        name: Markup(inline(drawing.svg, f"{anchor}-{name}", drawing.shows))
        for name, drawing in drawings[anchor].items()
    }
