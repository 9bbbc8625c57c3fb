"""What a user sees of a sweep: bars on a terminal, elsewhere a line for each run that is done."""

from collections.abc import Iterable, Sequence
from time import monotonic

from rich.console import Console, RenderableType
from rich.progress import BarColumn, Progress, TaskID, TaskProgressColumn, TextColumn

from esfem.runs.store import Cell, progress


class Monitor(Progress):
    """Watches a sweep: on a terminal a bar for all of it and one for each cell that runs, here or
    in another sweep.

    A class because it counts, and because that is how `rich` is told what to draw.

    Parameters
    ----------
    cells : all of the sweep.
    workers : how many cells run at a time.
    """

    def __init__(self, cells: Sequence[Cell], workers: int, console: Console) -> None:
        self._bar: dict[Cell, TaskID] = {}
        super().__init__(
            *(BarColumn(), TaskProgressColumn(), TextColumn("{task.description}")),
            console=console,
            refresh_per_second=4,
            transient=True,
            disable=not console.is_terminal or console.quiet,
        )
        self._open = {cell: cell.weight for cell in cells}
        self._workers = workers
        self._all, self._weight = len(cells), sum(self._open.values())
        self._began, self._seconds, self._made = monotonic(), 0.0, 0.0
        self._first: dict[Cell, tuple[float, float]] = {}  # when and how far it was seen to run
        self._total = self.add_task("", total=self._weight)
        self._bar = {
            cell: self.add_task(f"{cell.study} {cell.label}", total=1.0, visible=False)
            for cell in cells
        }

    def say(self, line: str) -> None:
        """A message to the user."""
        self.console.print(line, soft_wrap=True, highlight=False, markup=False)

    def done(self, cell: Cell, status: str, seconds: float | None = None) -> None:
        """The cell has a record; ``seconds`` is None if it was there, or was computed elsewhere."""
        weight = self._open.pop(cell)
        if seconds is None:
            return
        if status == "ok":  # one that stopped early tells nothing of the speed
            self._made += weight
            self._seconds += seconds
        if self.disable or status != "ok":
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

    def get_renderables(self) -> Iterable[RenderableType]:
        """What is drawn: the cells are looked at each time."""
        if self.tasks:  # rich asks once before there are any
            self._look()
        yield from super().get_renderables()

    def _look(self) -> None:
        running = self._running()
        for cell, bar in self._bar.items():
            self.update(bar, completed=running.get(cell, 0.0), visible=cell in running)
        rest = sum(w * (1.0 - running.get(cell, 0.0)) for cell, w in self._open.copy().items())
        self.update(self._total, completed=self._weight - rest, description=self.headline(running))


def clock(seconds: float) -> str:
    """Minutes and seconds, "2:05"."""
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"
