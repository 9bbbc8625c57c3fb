"""The command line ``esfem``.

Exit status: 0 every claim holds, 1 a claim failed, 3 inconclusive, 2 bad input, 130 interrupted.
"""

import json
import sys
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer
from pydantic import ValidationError
from rich.console import Console
from rich.table import Table
from rich.text import Text

from harness.api import DEFAULT_OUT, StudyResult, run_studies
from harness.bad_input import BadInput
from harness.claims import claims
from harness.errors import VARIABLES
from harness.meshing import MESH_SURFACES, SurfaceMesh, committed_sizes, surface_mesh
from harness.study import STUDIES, Study, load_study
from harness.tables import describe, level_table, series, verdict_table
from harness.verdicts import direction, exclusions, judge, judged_runs, worst
from reference_solutions import SOLUTIONS
from solver import LAWS

EXIT = {"pass": 0, "no claim": 0, "not exercised": 0, "fail": 1, "inconclusive": 3}
MESH_FORMATS = (".npz", ".ply", ".obj", ".stl", ".off")
STYLES = {"PASS": "green", "FAIL": "bold red", "INCONCLUSIVE": "yellow"}

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    help="Convergence verification for evolving surface finite elements.  \n"
    "Example: `esfem run sphere clifford --jobs 2`",
)


@app.command()
def run(
    studies: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="STUDY.toml ...",
            help="Study files, or names of committed studies; all of those if none.",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Results go to OUT/<study>.")] = DEFAULT_OUT,
    jobs: Annotated[
        int | None, typer.Option(help="Number of processes; by default all cores.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Compute again what is stored.")] = False,
) -> None:
    """Run studies, print rate tables and verdicts; what is stored below OUT is not repeated.

    Example: `esfem run harness/studies/sphere.toml my-study.toml --out results/runs --jobs 2`
    """
    console = Console()
    paths = [_study_path(name) for name in studies] if studies else default_studies()
    try:
        results = run_studies(paths, out, jobs, force, console)
    except KeyboardInterrupt:
        Console(stderr=True).print(
            "\ninterrupted: what had finished is stored; the same command continues from there"
        )
        raise typer.Exit(130) from None
    for result in results:
        show(result, console)
    summary(results, console)
    raise typer.Exit(max((EXIT[worst(result.verdicts)] for result in results), key=(0, 3, 1).index))


@app.command(name="list")
def list_() -> None:
    """List the studies, solutions, laws, claims and meshes there are.

    Example: `esfem list`
    """
    console = Console()
    _print_columns(
        console, "studies", {p.stem: load_study(p).study.title for p in default_studies()}
    )
    _print_columns(console, "solutions", {name: s.title for name, s in SOLUTIONS.items()})
    _print_columns(
        console, "laws", {name: law.__doc__.partition("\n")[0] for name, law in LAWS.items()}
    )
    _print_columns(console, "claims", {name: c.statement for name, c in claims().items()})
    meshes = {name: "V = " + ", ".join(map(str, committed_sizes(name))) for name in MESH_SURFACES}
    _print_columns(console, "meshes", meshes)


@app.command()
def table(
    folder: Annotated[
        Path,
        typer.Argument(metavar="DIR", help="Folder of a study's results, or of several studies."),
    ],
) -> None:
    """Print rate tables and verdicts of stored results.

    Example: `esfem table results/runs/sphere`
    """
    console = Console()
    folders = [
        path.parent
        for path in sorted([*folder.glob("verdicts.json"), *folder.glob("*/verdicts.json")])
    ]
    if not folders:
        raise BadInput(f"{folder}: holds no results (no verdicts.json there or one level below)")
    for path in folders:
        show(load_result(path), console)


@app.command()
def mesh(
    surface: Annotated[
        str, typer.Argument(metavar="SURFACE", help="Name of a surface; `esfem list` tells them.")
    ],
    vertices: Annotated[int, typer.Option(help="Number of vertices.")],
    out: Annotated[
        Path | None, typer.Option(help="File to write: .npz, or .ply, .obj, .stl, .off.")
    ] = None,
) -> None:
    """Generate a triangulation of V vertices, or fetch the committed one, and tell its quality.

    Example: `esfem mesh clifford_torus --vertices 500 --out torus.ply`
    """
    console = Console()
    if out is not None and out.suffix not in MESH_FORMATS:
        raise BadInput(f"--out {out}: the ending must be one of {', '.join(MESH_FORMATS)}")
    try:
        result = surface_mesh(surface, vertices, progress=console.print)
    except ValueError as error:
        raise BadInput(str(error)) from error
    console.print(
        f"{surface}: V = {len(result.vertices)}, {len(result.triangles)} triangles, "
        f"seed {result.seed}, radius ratio {result.radius_ratio:.3f}, "
        f"curved-element quality {result.curved_quality:.3f}, "
        f"least angle {result.min_angle:.1f} degrees",
        highlight=False,
    )
    if out is not None:
        _write_mesh(result, out)
        console.print(f"written to {out}", highlight=False)


def _write_mesh(mesh: SurfaceMesh, out: Path) -> None:
    try:
        if out.suffix == ".npz":
            mesh.save(out)
        else:
            import trimesh  # slow to load, and needed for this alone

            trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False).export(out)
    except OSError as error:
        raise BadInput(f"--out {out}: cannot be written: {error.strerror}") from error


def default_studies() -> list[Path]:
    """The committed studies, which `make convergence` runs."""
    return sorted(STUDIES.glob("*.toml"))


def load_result(folder: Path) -> StudyResult:
    """The results stored in a study's folder, judged afresh.

    Raises
    ------
    BadInput
        If a file is missing or damaged.
    """
    try:
        stored = json.loads((folder / "verdicts.json").read_text(encoding="utf-8"))
        study = Study.model_validate_json(json.dumps(stored["parameters"]))
        records = pd.read_csv(folder / "records.csv")
        return StudyResult(study, folder, records, judge(study, records))
    except (OSError, ValueError, KeyError, TypeError, ValidationError) as error:
        raise BadInput(f"{folder}: results cannot be read: {error}") from error


def show(result: StudyResult, console: Console) -> None:
    """Print the rate table at the judged tau, the verdicts, and what was not judged."""
    parameter = direction(result.study)
    label, runs = _shown(result)
    console.print()
    console.rule(f"[bold]{result.study.study.title}", align="left")
    console.print(describe(result.study), highlight=False)
    console.print(f"errors in L-inf(H^1) and EOC in {parameter} at {label}", highlight=False)
    console.print(_as_rich(_transposed(runs, parameter)))
    console.print(_as_rich(verdict_table(result.verdicts)))
    for line in exclusions(result.study, result.records):
        console.print(line, style="dim", highlight=False, markup=False)
    console.print(f"files: {result.folder}", highlight=False, soft_wrap=True)


def summary(results: list[StudyResult], console: Console) -> None:
    """Print one line a study: the verdict that decides the exit status."""
    console.rule("[bold]verdicts", align="left")
    for result in results:
        outcome = worst(result.verdicts).upper()
        counts = pd.Series([v.verdict for v in result.verdicts]).value_counts()
        detail = ", ".join(f"{count} {name}" for name, count in counts.items())
        line = Text.assemble(
            (f"{outcome:13}", STYLES.get(outcome, "")), f" {result.study.name}: {detail}"
        )
        console.print(line)


def _shown(result: StudyResult) -> tuple[str, pd.DataFrame]:
    """The series that holds the judged runs, or the finest one if none was judged."""
    lines = series(result.records, direction(result.study))
    judged = judged_runs(result.study, result.records).index
    return next((line for line in lines if line[1].index.isin(judged).any()), lines[-1])


def _transposed(runs: pd.DataFrame, parameter: str) -> pd.DataFrame:
    """Variables down, levels across, "error EOC" in each entry: fits a terminal of 80 columns."""
    table = level_table(runs, {name: name for name in VARIABLES}, parameter)
    heading = {"h": "V={vertices}", "tau": "n={steps}"}[parameter]
    columns = {"": [parameter, *VARIABLES]}
    for level in table.to_dict("records"):
        entries = [f"{_short(level[name])} {level[f'EOC {name}']}".strip() for name in VARIABLES]
        columns[heading.format(**level)] = [level[parameter], *entries]
    return pd.DataFrame(columns)


def _short(number: str) -> str:
    return (
        number
        if number == "-"
        else f"{float(number):.1e}".replace("e-0", "e-").replace("e+0", "e+")
    )


def _as_rich(frame: pd.DataFrame) -> Table:
    grid = Table(box=None, padding=(0, 1), pad_edge=False)
    for column in frame.columns:
        text = column in ("reason", "verdict", "claim")
        grid.add_column(column, justify="left" if text else "right", no_wrap=column != "reason")
    for row in frame.to_numpy(str):
        grid.add_row(*(Text(entry, style=STYLES.get(entry, "")) for entry in row))
    return grid


def _print_columns(console: Console, title: str, entries: dict[str, str]) -> None:
    console.print(f"[bold]{title}")
    for name, text in entries.items():
        console.print(f"  {name:20} {text}", highlight=False, markup=False, soft_wrap=True)


def _study_path(name: str) -> Path:
    committed = STUDIES / f"{name}.toml"
    return committed if committed.exists() and not Path(name).exists() else Path(name)


def main() -> None:
    """Entry point: bad input is one line on standard error and exit status 2."""
    try:
        app()
    except BadInput as error:
        Console(stderr=True).print(f"esfem: {error}", highlight=False, markup=False, soft_wrap=True)
        sys.exit(2)
