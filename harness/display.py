"""What a user sees of a sweep: a grid of (h, tau) cells on a terminal, plain lines elsewhere."""

from collections.abc import Callable, Sequence
from time import monotonic

from rich.columns import Columns
from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from harness.cell import Cell, progress
from harness.cost import remaining
from harness.sweep import Monitor

STYLES = {"ok": "green", "diverged": "bold magenta", "failed": "bold red"}
PRIOR_SECONDS = 5.0  # the cost model is trusted like so many seconds of finished runs
MARKS = {"ok": "done", "diverged": "diverged", "failed": "failed"}


class Tally:
    """Which cells are done, and when the rest will be.

    A class because it counts.

    Parameters
    ----------
    cells : all of the sweep.
    expected : seconds of a cell by the cost model.
    workers : how many cells run at a time.
    """

    def __init__(
        self, cells: Sequence[Cell], expected: Callable[[Cell], float], workers: int
    ) -> None:
        self.cells = list(cells)
        self.status: dict[int, str] = {}
        self._expected = {id(cell): expected(cell) for cell in cells}
        self._workers = workers
        self._started = monotonic()
        self._predicted = self._taken = PRIOR_SECONDS

    def found(self, cell: Cell, status: str) -> None:
        self.status[id(cell)] = status

    def finished(self, cell: Cell, status: str, seconds: float) -> None:
        self.status[id(cell)] = status
        if status == "ok":  # one that stopped early tells nothing of the speed
            self._predicted += self._expected[id(cell)]
            self._taken += seconds

    def remaining(self, running: dict[int, float]) -> float:
        """Seconds until all is done: what the cost model expects, at the speed seen so far.

        ``running`` are the fractions that running cells have done.
        """
        pace = self._taken / self._predicted
        rest = {i: pace * s for i, s in self._expected.items() if i not in self.status}
        now = [rest.pop(i) * (1.0 - done) for i, done in running.items() if i in rest]
        return remaining(now, sorted(rest.values(), reverse=True), self._workers)

    def headline(self, running: dict[int, float]) -> str:
        """Counts and the expected time of arrival."""
        rest = self.remaining(running)
        eta = f", about {clock(rest)} left" if len(self.status) < len(self.cells) else ""
        gone = clock(monotonic() - self._started)
        return f"{len(self.status)} of {len(self.cells)} runs done, {gone} gone{eta}"

    def running(self) -> dict[int, float]:
        """The cells that run, here or in another sweep, with the fraction they have done."""
        told = {id(c): progress(c) for c in self.cells if id(c) not in self.status}
        return {cell: fraction for cell, fraction in told.items() if fraction is not None}


class PlainLines:
    """One line for each finished cell.  A class because it implements `Monitor` with a tally."""

    def __init__(self, tally: Tally, console: Console) -> None:
        self._tally, self._console = tally, console

    def __enter__(self) -> Monitor:
        return self

    def __exit__(self, *exception: object) -> None:
        pass

    def say(self, line: str) -> None:
        self._console.print(line, soft_wrap=True, highlight=False, markup=False)

    def found(self, cell: Cell, status: str) -> None:
        self._tally.found(cell, status)

    def finished(self, cell: Cell, status: str, seconds: float) -> None:
        self._tally.finished(cell, status, seconds)
        head = self._tally.headline(self._tally.running())
        self.say(f"[{head}] {cell.study} {cell.label}: {status}, {seconds:.1f} s")


class LiveGrid:
    """A table a study, redrawn four times a second.  A class because it owns the live region."""

    def __init__(self, tally: Tally, console: Console) -> None:
        self._tally = tally
        self._live = Live(
            get_renderable=self._draw, console=console, refresh_per_second=4, transient=True
        )

    def __enter__(self) -> Monitor:
        self._live.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self._live.__exit__(*exception)

    def say(self, line: str) -> None:
        self._live.console.print(line, soft_wrap=True, highlight=False, markup=False)

    def found(self, cell: Cell, status: str) -> None:
        self._tally.found(cell, status)

    def finished(self, cell: Cell, status: str, seconds: float) -> None:
        self._tally.finished(cell, status, seconds)

    def _draw(self) -> Group:
        told = self._tally.running()
        open_ = [cell for cell in self._tally.cells if id(cell) not in self._tally.status]
        # Studies in which something runs come first, finished ones not at all: a terminal is small.
        active = [cell.study for cell in open_ if id(cell) in told]
        studies = dict.fromkeys(active + [cell.study for cell in open_])
        grids = [self._grid(study, told) for study in studies]
        return Group(Text(self._tally.headline(told)), Columns(grids, padding=(0, 2)))

    def _grid(self, study: str, running: dict[int, float]) -> Table:
        every = [cell for cell in self._tally.cells if cell.study == study]
        cells = [cell for cell in every if cell.floor is None]
        taus = sorted({cell.case.tau for cell in cells}, reverse=True)
        table = Table(
            title=study, title_style="bold", title_justify="left", box=None, padding=(0, 1)
        )
        table.add_column("V \\ tau", justify="right")
        for tau in taus:
            table.add_column(f"{tau:g}", justify="right", min_width=8)
        for vertices in sorted({cell.case.vertices for cell in cells}):
            of_row = {cell.case.tau: cell for cell in cells if cell.case.vertices == vertices}
            table.add_row(str(vertices), *(self._mark(of_row[tau], running) for tau in taus))
        floors = [cell for cell in every if cell.floor is not None]
        if floors:
            done = sum(id(cell) in self._tally.status for cell in floors)
            table.add_row("floors", f"{done}/{len(floors)}", style="dim")
        return table

    def _mark(self, cell: Cell, running: dict[int, float]) -> Text:
        status = self._tally.status.get(id(cell))
        if status is not None:
            return Text(MARKS[status], style=STYLES[status])
        fraction = running.get(id(cell))
        return (
            Text("waiting", style="dim")
            if fraction is None
            else Text(f"{100 * fraction:.0f} %", style="cyan")
        )


def monitor(
    cells: Sequence[Cell], expected: Callable[[Cell], float], workers: int, console: Console
) -> PlainLines | LiveGrid:
    """The live grid on a terminal, plain lines elsewhere."""
    tally = Tally(cells, expected, workers)
    return LiveGrid(tally, console) if console.is_terminal else PlainLines(tally, console)


def clock(seconds: float) -> str:
    """Minutes and seconds, "2:05"."""
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"
