"""The tables of one study: verdicts, errors, meshes, times, origin."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from esfem.common.files import read_json
from esfem.meshes import SurfaceMesh, committed_mesh_path
from esfem.report.content import Table
from esfem.results.result_files import read_verdicts
from esfem.results.study_result import StudyResult
from esfem.results.tables import headed, verdict_table
from esfem.results.verdicts import Verdict
from esfem.runs.store import record_path
from esfem.studies.quantities import NODAL

PARTS = ("assembly", "factorisation", "krylov", "rest", "errors")


def verdicts(result: StudyResult) -> Table:
    """The verdicts with the window, the fit and the finest error."""
    table = verdict_table(result.verdicts)
    table = table.drop(columns="claim")  # the section tells it
    table.insert(0, "verdict", table.pop("verdict"))
    table["judged over"] = [_window(v) for v in result.verdicts]
    table["fit E ="] = [_fit(v) for v in result.verdicts]
    table["scatter"] = [_percent(v.scatter) for v in result.verdicts]
    table["model"] = [v.model or "-" for v in result.verdicts]
    table["finest error"] = [_number(v.error, ".2e") for v in result.verdicts]
    tells = (
        "order: slope over the judged runs; 95 % interval: of the order as h or tau tends to 0, "
        "over all models that the data do not rule out"
    )
    return Table("verdicts", "Verdicts", table, tells=tells)


def _window(verdict: Verdict) -> str:
    if not verdict.vertices:
        return "-"
    if verdict.direction == "h":
        ends = "..".join(str(v) for v in dict.fromkeys((verdict.vertices[0], verdict.vertices[-1])))
        return f"V = {ends}, tau = {verdict.tau[0]:g}"
    ends = "..".join(f"{t:g}" for t in dict.fromkeys((verdict.tau[0], verdict.tau[-1])))
    return f"tau = {ends}, V = {verdict.vertices[0]}"


def _fit(verdict: Verdict) -> str:
    if not np.isfinite([verdict.constant, verdict.observed]).all():
        return "-"
    return f"{verdict.constant:.3g} {verdict.direction}^{verdict.observed:.2f}"


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
        for run in verdict.masked:
            rows.setdefault((run.h, run.tau, run.reason), []).append(verdict.variable)
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


def provenance(result: StudyResult) -> dict[str, str]:
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
