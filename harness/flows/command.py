"""`esfem flow`: one evolution, its numbers, files for ParaView, pictures and checks."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from harness.bad_input import BadInput
from harness.checkpoint import EVERY_SECONDS, Keeper
from harness.drawing import STYLES
from harness.files import writable_folder
from harness.flows.checks import Check, checked, reference_flow
from harness.flows.evolution import Outcome, compute, identity_of, stored_outcome
from harness.flows.flow_file import FlowFile, load_flow
from harness.flows.history import History
from harness.flows.progress import watching
from harness.flows.report import Finished, write_report
from harness.flows.start import Start, start_of
from harness.printing import plain_console
from harness.stops import stops
from harness.words import describe_flow

COMMITTED = Path(__file__).parent.parent / "studies" / "paper" / "flows"
DEFAULT_OUT = Path("results/runs/flows")


def flow(
    file: Annotated[
        str,
        typer.Argument(metavar="FILE.toml", help="A flow file, or the name of a committed one."),
    ],
    out: Annotated[Path, typer.Option(help="Results go to OUT/NAME.")] = DEFAULT_OUT,
    checkpoint: Annotated[float, typer.Option(help="Seconds between checkpoints.")] = EVERY_SECONDS,
    force: Annotated[bool, typer.Option("--force", help="Compute again what is stored.")] = False,
    pictures: Annotated[bool, typer.Option(help="Make pictures and files for ParaView.")] = True,
) -> None:
    """Evolve one surface: history.csv, files for ParaView, pictures, and the checks it asks for.

    Exit status 0 if all checks hold, 1 if one fails.

    Example: `esfem flow ellipsoid --out results/runs/flows`
    """
    console = plain_console()
    path = flow_path(file)
    if not checkpoint >= 0:
        raise BadInput(f"--checkpoint {checkpoint}: must be at least 0 seconds")
    asked = load_flow(path)
    with stops(out):
        checks = run_flow(asked, path.parent, out, checkpoint, force, pictures, console)
    raise typer.Exit(0 if all(check.verdict == "pass" for check in checks) else 1)


def committed_flows() -> dict[str, Path]:
    """The committed flow files by name."""
    return {path.stem: path for path in sorted(COMMITTED.glob("*.toml"))}


def flow_path(name: str) -> Path:
    """The file of that name, or the committed flow.

    Raises
    ------
    BadInput
        If there is neither.
    """
    path, committed = Path(name), committed_flows()
    if path.is_file() or path.suffix == ".toml":
        return path
    if name not in committed:
        raise BadInput(
            f"{name}: neither a file nor a committed flow; those are {', '.join(committed)}"
        )
    return committed[name]


def run_flow(
    flow: FlowFile,
    base: Path,
    out: Path,
    checkpoint: float,
    force: bool,
    pictures: bool,
    console: Console,
) -> list[Check]:
    """Compute the flow unless it is stored, write all that is made from it, return the checks.

    Parameters
    ----------
    flow, base : the flow file, and the folder it lies in.
    out : results go to its folder of that name.
    checkpoint : seconds between two.
    force : compute again.
    pictures : make pictures and files for ParaView.
    console : is told.
    """
    folder = writable_folder(out) / flow.name
    if flow.checks.reference is not None:
        reference_flow(flow)  # what cannot be compared or drawn in the end is told at the start
    if pictures:
        from harness.flows.files import check_libraries, write_files  # vtk is slow to load

        check_libraries()
    start = start_of(flow, base, out / "meshes", console)
    writable_folder(folder, "frames")
    console.print(f"{flow.flow.title}: {describe_flow(flow, start.mesh.node_count)}")
    outcome, history = outcome_of(flow, start, folder, checkpoint, force, console)
    checks = checked(flow, outcome, history, folder)
    done = Finished(flow, start, outcome, history, checks)
    write_report(done, folder)
    show(checks, console)
    if pictures:
        write_files(flow, start, outcome, history, folder, console)
        write_report(done, folder)  # with the pictures
    console.print(f"files: {folder}", soft_wrap=True)
    return checks


def outcome_of(
    flow: FlowFile, start: Start, folder: Path, seconds: float, force: bool, console: Console
) -> tuple[Outcome, History]:
    """The stored outcome of this very flow, or else that of computing it."""
    identity = identity_of(flow, start)

    def say(line: str) -> None:
        console.print(line, soft_wrap=True)

    keeper = Keeper(
        folder / "checkpoint.npz",
        identity,
        flow.levels,
        flow.scheme.bdf,
        seconds,
        say=say,
        refused=lambda line: say(f"{line}; the flow starts anew"),
    )
    if force:
        keeper.discard()
    stored = None if force else stored_outcome(folder, identity, flow.law.energy)
    if stored is not None:
        say("the flow is stored and not computed again (--force does)")
        return stored
    with watching(flow, console) as watch:
        return compute(flow, start, folder, identity, keeper, watch)


def show(checks: list[Check], console: Console) -> None:
    """Print a line a check."""
    for check in checks:
        style = STYLES.get(check.verdict.upper(), "")
        console.print(f"{check.verdict.upper():6}", style=style, end="")
        console.print(f"{check.name}: {check.text} (bound {check.bound:g})", soft_wrap=True)
