"""What a user sees of a sweep: bars on a terminal, elsewhere a line for each run that is done."""

from collections.abc import Callable, Iterable, Sequence
from time import monotonic
from typing import Self

from rich.console import Console, RenderableType
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

from esfem.runs.cell import Cell, progress


class Monitor:
    """Watches a sweep: on a terminal a bar for all of it and one for each cell that runs, here or
    in another sweep.

    A class because it counts, and owns the bars.

    Parameters
    ----------
    cells : all of the sweep.
    workers : how many cells run at a time.
    """

    def __init__(self, cells: Sequence[Cell], workers: int, console: Console) -> None:
        self._open = {cell: cell.weight for cell in cells}
        self._workers, self._console = workers, console
        self._all, self._weight = len(cells), sum(self._open.values())
        self._began, self._seconds, self._made = monotonic(), 0.0, 0.0
        self._first: dict[Cell, tuple[float, float]] = {}  # when and how far it was seen to run
        self._bars = Bars(self._look, console)
        self._total = self._bars.add_task("", total=self._weight)
        self._bar = {
            cell: self._bars.add_task(f"{cell.study} {cell.label}", total=1.0, visible=False)
            for cell in cells
        }

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._bars.stop()

    def say(self, line: str) -> None:
        """A message to the user."""
        self._console.print(line, soft_wrap=True, highlight=False, markup=False)

    def done(self, cell: Cell, status: str, seconds: float | None = None) -> None:
        """The cell has a record; ``seconds`` is None if it was there, or was computed elsewhere."""
        weight = self._open.pop(cell)
        if seconds is None:
            return
        if status == "ok":  # one that stopped early tells nothing of the speed
            self._made += weight
            self._seconds += seconds
        if self._bars.disable or status != "ok":
            head = self.headline(self._running())
            self.say(f"[{head}] {cell.study} {cell.label}: {status}, {seconds:.1f} s")

    def headline(self, running: dict[Cell, float]) -> str:
        """Counts, and the time left; ``running`` are the fractions that running cells have done."""
        done, left = self._all - len(self._open), self.left(running)
        eta = "" if left is None else f", about {clock(left)} left"
        return f"{done} of {self._all} runs done, {clock(monotonic() - self._began)} gone{eta}"

    def left(self, running: dict[Cell, float]) -> float | None:
        """Seconds until all is done, by the weights, at the speed seen so far; None if all is, or
        none was seen.

        It is the mean over the workers, or the cell that takes longest.
        """
        now, seconds, made = monotonic(), self._seconds, self._made
        for cell, fraction in running.items():
            since, before = self._first.setdefault(cell, (now, fraction))
            seconds += now - since
            made += cell.weight * (fraction - before)
        rest = [w * (1.0 - running.get(cell, 0.0)) for cell, w in self._open.copy().items()]
        if not rest or made <= 0.0:
            return None
        return seconds / made * max(max(rest), sum(rest) / self._workers)

    def _running(self) -> dict[Cell, float]:
        told = {cell: progress(cell) for cell in self._open.copy()}
        return {cell: fraction for cell, fraction in told.items() if fraction is not None}

    def _look(self) -> None:
        running = self._running()
        for cell, bar in self._bar.items():
            self._bars.update(bar, completed=running.get(cell, 0.0), visible=cell in running)
        rest = sum(w * (1.0 - running.get(cell, 0.0)) for cell, w in self._open.copy().items())
        self._bars.update(
            self._total, completed=self._weight - rest, description=self.headline(running)
        )


class Bars(Progress):
    """The bars, which look at the cells each time that they are drawn; elsewhere than on a terminal
    they are not.

    A class because that is how `rich` is told what to draw.
    """

    def __init__(self, look: Callable[[], None], console: Console) -> None:
        self._look_first = look
        shown = console.is_terminal and not console.quiet
        columns = (BarColumn(), TaskProgressColumn(), TextColumn("{task.description}"))
        super().__init__(
            *columns, console=console, refresh_per_second=4, transient=True, disable=not shown
        )

    def get_renderables(self) -> Iterable[RenderableType]:
        """What is drawn."""
        if self.tasks:  # rich asks once before there are any
            self._look_first()
        yield from super().get_renderables()


def clock(seconds: float) -> str:
    """Minutes and seconds, "2:05"."""
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"
