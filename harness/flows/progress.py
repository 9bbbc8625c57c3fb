"""What a user sees of a running flow: a bar on a terminal, a line now and then elsewhere."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from esfem.flows.evolution import Watcher
from esfem.flows.flow_file import FlowFile
from esfem.flows.history import History
from esfem.solver import State

LINES = 20  # of a whole flow, where there is no terminal


@contextmanager
def watching(flow: FlowFile, console: Console) -> Iterator[Watcher]:
    """A watcher that shows time, energy and iterations."""
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
