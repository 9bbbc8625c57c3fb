"""Many marches at once: processes with one thread each, so that seconds of the processor count."""

from collections.abc import Callable, Sequence
from typing import TypeVar

from rich.console import Console
from rich.progress import Progress

from harness.executors import LocalProcesses

Item, Result = TypeVar("Item"), TypeVar("Result")


def computed(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    jobs: int,
    console: Console,
    what: str,
) -> list[Result]:
    """The results of the items, in their order; the last ones, which take longest, start first."""

    def numbered(pair: tuple[int, Item]) -> Result:
        return function(pair[1])

    found: dict[int, Result] = {}
    with LocalProcesses(jobs) as processes, Progress(console=console) as bar:
        task = bar.add_task(what, total=len(items))
        for (i, _), result in processes.run(numbered, list(enumerate(items))[::-1]):
            found[i] = result
            bar.advance(task)
    return [found[i] for i in range(len(items))]
