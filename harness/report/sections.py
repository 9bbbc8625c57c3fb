"""The sections of a report: the tables, pictures and origin of one study, and of one flow."""

import base64
import io
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from PIL import Image

from esfem.common.bad_input import BadInput
from esfem.common.files import read_json
from esfem.flows.flow_file import describe_flow
from esfem.flows.flow_results import FlowResult
from esfem.meshes import SurfaceMesh, committed_mesh_path
from esfem.report.content import Table, chip
from esfem.report.drawings import Drawing, Drawings, anchor_of
from esfem.results.error_verdicts import ErrorVerdict
from esfem.results.remarks import remarks
from esfem.results.result_files import read_verdicts
from esfem.results.study_result import StudyResult
from esfem.results.tables import headed, verdict_table
from esfem.runs.store import record_path
from esfem.studies.claims import Claim, Direction
from esfem.studies.quantities import NODAL

PARTS = ("assembly", "factorisation", "krylov", "rest", "errors")
LEVELS = (
    *("t", "energy", "willmore", "area", "volume", "least_normal", "greatest_normal"),
    *("least_area_element", "speed", "iterations"),
)
WIDEST = 1100  # pixels of an embedded picture
COLOURS = 256
ERRORS = ("errors-", "nodal-")  # how the names of tables of errors begin


@dataclass(frozen=True)
class Section:
    """What is told of a study or a flow, the same in HTML and LaTeX.

    ``describe`` says in a line what was run, ``norms`` what its errors are, if it has any, and
    ``chips`` what was found (`esfem.report.content.chip`); the first of the ``tables`` are the
    verdicts; ``series`` are the labels of the lines in its figures.
    """

    anchor: str
    name: str
    title: str
    outcome: str
    describe: str
    _: KW_ONLY
    chips: list[dict[str, str]]
    tables: list[Table]
    figures: dict[str, Drawing]
    provenance: dict[str, str]
    claim: Claim | None = None
    norms: str = ""
    remarks: Sequence[str] = ()
    series: Sequence[str] = ()


def study_section(result: StudyResult, drawings: Drawings) -> Section:
    """All that is told of a study."""
    study, anchor = result.study, anchor_of(result)
    others = [*errors(result), masked(result), meshes(result), timings(result)]
    return Section(
        anchor,
        study.name,
        study.title,
        result.outcome.upper(),
        result.words.case,
        chips=[chip(verdict) for verdict in result.verdicts],
        tables=[verdicts(result), *(table for table in others if len(table.frame))],
        figures=drawings[anchor],
        provenance=study_provenance(result),
        claim=study.claimed,
        norms=result.words.errors,
        remarks=remarks(result),
        series=[label for label, _ in result.series],
    )


def flow_section(result: FlowResult, drawings: Drawings) -> Section:
    """All that is told of a flow, but for its pictures."""
    anchor = anchor_of(result)
    return Section(
        anchor,
        f"flow {result.flow.name}",
        result.flow.flow.title,
        result.outcome.upper(),
        course(result),
        chips=[
            {"variable": check.name, "outcome": check.verdict.upper(), "value": ""}
            for check in result.checks
        ],
        tables=[checks(result), levels(result)],
        figures=drawings[anchor],
        provenance=flow_provenance(result),
    )


def verdicts(result: StudyResult) -> Table:
    """The verdicts with the window, the fit and the finest error."""
    table = verdict_table(result.verdicts)
    table = table.drop(columns="claim")  # the section tells it
    table.insert(0, "verdict", table.pop("verdict"))
    parts, along = [part for v in result.verdicts for part in v.parts], result.study.direction
    table["judged over"] = [_window(part, along) for part in parts]
    table["fit E ="] = [_fit(part, along) for part in parts]
    table["scatter"] = [_percent(part.scatter) for part in parts]
    table["model"] = [part.model or "-" for part in parts]
    table["finest error"] = [_number(part.error, ".2e") for part in parts]
    tells = (
        "order: its median as h or tau tends to 0, over all models by their probabilities; it lies "
        "in the interval with 95 %"
    )
    return Table("verdicts", "Verdicts", table, tells=tells)


def _window(part: ErrorVerdict, direction: Direction) -> str:
    if not part.vertices:
        return "-"
    if direction == "h":
        ends = "..".join(str(v) for v in dict.fromkeys((part.vertices[0], part.vertices[-1])))
        return f"V = {ends}, tau = {part.tau[0]:g}"
    ends = "..".join(f"{t:g}" for t in dict.fromkeys((part.tau[0], part.tau[-1])))
    return f"tau = {ends}, V = {part.vertices[0]}"


def _fit(part: ErrorVerdict, direction: Direction) -> str:
    if not np.isfinite([part.constant, part.observed]).all():
        return "-"
    return f"{part.constant:.3g} {direction}^{part.observed:.2f}"


def _number(value: float, form: str) -> str:
    return f"{value:{form}}" if np.isfinite(value) else "-"


def _percent(value: float) -> str:
    return f"{100.0 * value:.1f} %" if np.isfinite(value) else "-"


def errors(result: StudyResult) -> list[Table]:
    """Errors and EOC, a table a series; that on which most was judged first, the rest folded."""
    names, first = headed(result.headings), result.shown
    found = []
    for i, label in enumerate([first, *(label for label in result.tables if label != first)]):
        shown, nodal = result.tables[label]
        title = f"Errors and EOC in {result.study.direction} at {label}"
        table, leading = shown.rename(columns=names), label == first
        found.append(Table(f"errors-{i}", title, table, leading=leading))
        if nodal is not None:
            title = f"Against the interpolation at {label}: {NODAL}"
            table = nodal.rename(columns=names)
            found.append(Table(f"nodal-{i}", title, table, leading=leading))
    return found


def masked(result: StudyResult) -> Table:
    """Every run that was not judged, with the variables for which, and why."""
    rows: dict[tuple[float, float, str], list[str]] = {}
    for verdict in result.verdicts:
        for part in verdict.parts:
            name = f"{verdict.variable}{' (interpolation)' * (part.name == 'interpolation')}"
            for run in part.masked:
                rows.setdefault((run.h, run.tau, run.reason), []).append(name)
    cells = [
        {"h": f"{h:.3g}", "tau": f"{tau:g}", "variables": ", ".join(names), "reason": reason}
        for (h, tau, reason), names in rows.items()
    ]
    columns = ["h", "tau", "variables", "reason"]
    return Table("masked", "Masked runs", pd.DataFrame(cells, columns=columns), leading=False)


def meshes(result: StudyResult) -> Table:
    """Size and quality of the meshes, and what became of the normals on them."""
    surface = result.study.initial.mesh_surface
    rows = []
    for vertices, runs in result.records.groupby("vertices"):
        run, digests = runs.iloc[0], set(runs.get("mesh_digest", ()))
        rows.append(
            {
                "V": str(vertices),
                "N": str(run["nodes"]),
                "h": f"{run['h']:.4f}",
                "largest diameter": f"{run['h_max']:.4f}",
                **_quality(surface, int(vertices), digests),
                "least |nu|": f"{runs['least_normal'].min():.6f}",
                "greatest |nu|": f"{runs['greatest_normal'].max():.6f}",
            }
        )
    tells = (
        "qualities at t = 0 of the triangles (2 r_in / r_circ, least angle in degrees) and of the "
        "curved elements; |nu|: the extremes of all runs on the mesh, over all times"
    )
    return Table("meshes", "Meshes", pd.DataFrame(rows), tells=tells, leading=False)


def _quality(surface: str, vertices: int, digests: set[str]) -> dict[str, str]:
    """Qualities of the committed mesh, if the runs were made on that very mesh."""
    names = ("radius ratio", "curved quality", "least angle")
    path = committed_mesh_path(surface, vertices)
    mesh = SurfaceMesh.load(path) if path.exists() else None
    if mesh is None or digests != {mesh.digest}:
        return dict.fromkeys(names, "not stored")
    values = (mesh.radius_ratio, mesh.curved_quality, mesh.min_angle)
    return {name: f"{value:.3g}" for name, value in zip(names, values, strict=True)}


def timings(result: StudyResult) -> Table:
    """Seconds of each run, of its parts, and iterations a step."""
    rows = []
    for run in result.records.to_dict("records"):
        parts = {part: run.get(f"seconds_{part}", np.nan) / run["seconds"] for part in PARTS}
        rows.append(
            {
                "V": str(run["vertices"]),
                "N": str(run["nodes"]),
                "tau": f"{run['tau']:g}",
                "steps": str(run["steps"]),
                "status": run["status"],
                "seconds": f"{run['seconds']:.3g}",
                **{part: _percent(share) for part, share in parts.items()},
                "GMRES a step": _number(run.get("gmres_mean", np.nan), ".1f"),
            }
        )
    total = result.records["seconds"].sum()
    tells = f"{total:.0f} s of computing in all; parts in per cent of the seconds of the run"
    return Table("timings", "Times", pd.DataFrame(rows), tells=tells, leading=False)


def study_provenance(result: StudyResult) -> dict[str, str]:
    """Where the numbers come from."""
    stored = read_verdicts(result.folder)
    runs = result.records
    origins = runs[["version", "numerics", "machine"]].drop_duplicates().itertuples(index=False)
    return {
        "runs": "; ".join(f"{v} (numerics {n}), {m}" for v, n, m in origins),
        "command": stored.command,
        "libraries of the runs": _environment(result, runs["key"]),
        "packages at writing": _listed(stored.dependencies) or "not stored",
        "seconds": f"{runs['seconds'].sum():.1f}",
    }


def _environment(result: StudyResult, keys: Sequence[str]) -> str:
    """The libraries that the stored records name; they are not part of a published baseline."""
    for key in keys:
        path = record_path(result.folder, key)
        if path.exists():
            found = read_json(path, dict[str, Any])["record"]["environment"]
            told = ("version", "numerics", "machine")
            return _listed({name: value for name, value in found.items() if name not in told})
    return "not stored (no records of single runs here)"


def _listed(packages: dict[str, str]) -> str:
    return ", ".join(f"{name} {number}" for name, number in packages.items())


def course(result: FlowResult) -> str:
    """The flow in one line, how it ended, for example "diverged: element 3 is inverted", what it
    took, and what is claimed."""
    ending = f"{result.status}: {result.reason}" if result.reason else result.status
    described, claim = describe_flow(result.flow, result.nodes), result.order_claim
    return f"{described}; {ending}; {cost(result)}; order claim: {claim}"


def cost(result: FlowResult) -> str:
    """For example "5126 steps in 93 s, 0.1 GMRES iterations a step".

    A published history has not all levels: steps are counted by their times, and iterations are
    the mean of those that are there.
    """
    history = result.history
    steps = result.flow.levels.at(history.last("t"))
    iterations = history.column("iterations")[1:].mean() if steps else 0.0
    return f"{steps} steps in {result.seconds:.0f} s, {iterations:.1f} GMRES iterations a step"


def checks(result: FlowResult) -> Table:
    """What was expected of the flow, and whether it did it."""
    rows = [
        {
            "verdict": check.verdict.upper(),
            "check": check.name,
            "measured": f"{check.measured:.3g}",
            "bound": f"{check.bound:.3g}",
            "in words": check.text,
        }
        for check in result.checks
    ]
    columns = ["verdict", "check", "measured", "bound", "in words"]
    return Table("checks", "Checks", pd.DataFrame(rows, columns=columns))


def levels(result: FlowResult) -> Table:
    """The first, the middle and the last level, and the extremes of each column."""
    history = result.history
    rows = []
    for which, n in {"start": 0, "middle": len(history.rows) // 2, "end": -1}.items():
        values = {name.replace("_", " "): f"{history.column(name)[n]:.6g}" for name in LEVELS}
        rows.append({"level": which, **values})
    for which, extreme in {"least": "min", "greatest": "max"}.items():
        found = {name: getattr(history.column(name), extreme)() for name in LEVELS}
        rows.append({"level": which, **{k.replace("_", " "): f"{v:.6g}" for k, v in found.items()}})
    tells = f"energy: {history.energy}; willmore: W = 1/2 int H^2"
    return Table("levels", "Levels", pd.DataFrame(rows), tells=tells, leading=False)


def flow_provenance(result: FlowResult) -> dict[str, str]:
    """Where the numbers come from."""
    stored = dict(result.environment)
    told = [stored.pop(name, "not stored") for name in ("version", "numerics", "machine")]
    return {
        "program": f"esfem-willmore {told[0]} (numerics {told[1]})",
        "machine": told[2],
        "libraries of the run": ", ".join(f"{name} {number}" for name, number in stored.items()),
    }


def pictures(result: FlowResult) -> dict[str, str]:
    """The PNG pictures in its folder by name, made smaller, as data URIs."""
    found = sorted(result.folder.glob("*.png"))
    return {path.stem: f"data:image/png;base64,{_smaller(path)}" for path in found}


def _smaller(path: Path) -> str:
    """A picture of so many colours and pixels at most, in base64."""
    try:
        with Image.open(path, formats=["PNG"]) as picture:  # others may start programs
            small = picture.convert("RGB")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise BadInput(f"{path}: no picture that can be read: {error}") from error
    small.thumbnail((WIDEST, 4 * WIDEST))
    stream = io.BytesIO()
    palette = small.quantize(COLOURS, Image.Quantize.MAXCOVERAGE)  # keeps white white
    small.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(stream, "png")
    return base64.b64encode(stream.getvalue()).decode("ascii")
