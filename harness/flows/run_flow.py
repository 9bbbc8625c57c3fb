"""One evolution: its numbers, files for ParaView, pictures and checks."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from esfem.common.bad_input import BadInput
from esfem.common.console import STYLES
from esfem.common.files import writable_folder
from esfem.flows.checks import checked, reference_flow
from esfem.flows.evolution import Watcher, compute, identity_of
from esfem.flows.flow_file import FlowFile, describe_flow
from esfem.flows.flow_results import Check, Ended, stored_levels, stored_outcome, write_checks
from esfem.flows.history import History
from esfem.flows.paraview import write_series
from esfem.flows.start import Start, start_of
from esfem.runs.checkpoint import Keeper
from esfem.solver import State

INSTALL = "pip install 'esfem-willmore[pictures]'"
LINES = 20  # of a whole flow, where there is no terminal


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
    surfaces = pictures and surfaces_are_drawn(console)
    start = start_of(flow, base, out / "meshes", console)
    writable_folder(folder, "frames")
    console.print(f"{flow.flow.title}: {describe_flow(flow, start.mesh.node_count)}")
    ended, history = end_of(flow, start, folder, checkpoint, force, surfaces, console)
    checks = checked(flow, ended, history, folder)
    write_checks(folder, flow, start, ended, checks)
    show(checks, console)
    if pictures:
        from esfem.flows.pictures import save_energy, save_surfaces  # slow to load

        save_energy(folder, flow, history)
        if surfaces:
            write_series(folder, flow, start.mesh, ended.framed)
            save_surfaces(folder, flow, start.mesh, ended)
    console.print(f"files: {folder}", soft_wrap=True)
    return checks


def surfaces_are_drawn(console: Console) -> bool:
    """Whether pyvista is there; BadInput if it is installed, but broken: better known before the
    flow than after."""
    if find_spec("pyvista") is None:
        line = f"without pyvista: no surfaces.png, no files for ParaView; {INSTALL}"
        console.print(line, soft_wrap=True)
        return False
    try:
        import_module("pyvista")
    except (ImportError, OSError) as error:
        why = " ".join(str(error).split())
        raise BadInput(
            f"pyvista: is installed, but cannot be imported: {why}; --no-pictures needs none"
        ) from error
    return True


def end_of(
    flow: FlowFile,
    start: Start,
    folder: Path,
    seconds: float,
    force: bool,
    surfaces: bool,
    console: Console,
) -> tuple[Ended, History]:
    """The stored end of this very flow, or else that of computing it."""
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
    framed = frozenset(flow.framed if surfaces else ())
    with watching(flow, console) as tell:

        def watch(n: int, state: State, history: History) -> None:
            tell(n, state, history)
            if n in framed:
                with suppress(OSError):  # it is written again in the end, and told then
                    write_series(folder, flow, start.mesh, stored_levels(folder))

        return compute(flow, start, folder, identity, keeper, watch)


@contextmanager
def watching(flow: FlowFile, console: Console) -> Iterator[Watcher]:
    """A watcher that shows time, energy and iterations: a bar on a terminal, else lines."""
    steps = flow.levels.steps
    if not console.is_terminal:
        every = max(1, steps // LINES)

        def line(n: int, state: State, history: History) -> None:
            if n % every == 0 or n == steps:
                console.print(_numbers(state, history))

        yield line
        return
    columns = (BarColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, TimeRemainingColumn(), console=console, transient=True) as bar:
        task = bar.add_task("", total=steps)
        yield lambda n, state, history: bar.update(
            task, completed=n, description=_numbers(state, history)
        )


def _numbers(state: State, history: History) -> str:
    energy = f"{history.energy.symbol} = {history.last('energy'):.5f}"
    return (
        f"t = {state.t:.4f}  {energy}  max|V| = {history.last('speed'):.1e}  "
        f"iterations {state.work.iterations}"
    )


def show(checks: list[Check], console: Console) -> None:
    """Print a line a check."""
    for check in checks:
        style = STYLES.get(check.verdict.upper(), "")
        console.print(f"{check.verdict.upper():6}", style=style, end="")
        console.print(f"{check.name}: {check.text} (bound {check.bound:g})", soft_wrap=True)
