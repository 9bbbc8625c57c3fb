"""The comparison of the schemes, written as extras of the report."""

import tomllib
from collections.abc import Callable, Collection, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

from rich.console import Console
from rich.progress import Progress
from tabulate import tabulate

from esfem.campaigns.contest import scores as tables
from esfem.campaigns.contest import stability
from esfem.campaigns.contest.contest import GROUNDS, Contest, case_of
from esfem.campaigns.contest.figure import cost_figure, course_figure
from esfem.campaigns.contest.march import March, march
from esfem.campaigns.contest.scores import Row, shown
from esfem.common.provenance import stepping_digest
from esfem.report.extra import Extra, write_extra
from esfem.runs.executors import LocalProcesses
from esfem.schemes import scheme_file

GROUND = "red blood cell"  # of the figures
TEXTS = tomllib.loads(Path(__file__).with_name("texts.toml").read_text(encoding="utf-8"))

Item, Result = TypeVar("Item"), TypeVar("Result")


def compare_schemes(contest: Contest, parts: Collection[str]) -> None:
    """Compute these `PARTS` of the comparison; write ``extra/schemes-*.json`` with figures."""
    wanted = set(parts) - ({"cost"} if "comparison" in parts else set())  # which writes it too
    for part, write in PARTS.items():
        if part in wanted:
            write(contest)


def computed(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    jobs: int,
    console: Console,
    what: str,
) -> list[Result]:
    """The results of the items, in their order, by processes of one thread each, so that seconds
    of the processor count; the last ones, which take longest, start first."""

    def numbered(pair: tuple[int, Item]) -> Result:
        return function(pair[1])

    found: dict[int, Result] = {}
    with LocalProcesses(jobs) as processes, Progress(console=console) as bar:
        task = bar.add_task(what, total=len(items))
        for (i, _), result in processes.run(numbered, list(enumerate(items))[::-1]):
            found[i] = result
            bar.advance(task)
    return [found[i] for i in range(len(items))]


def write_cost(contest: Contest) -> None:
    """Seconds a step, each alone on the machine."""
    items = [(word, options, contest.sizes) for word, options in contest.everyone.items()]
    rows = _compute(contest, tables.cost_row, items, "seconds per step", jobs=1)
    _write(contest, "cost", rows)


def write_comparison(contest: Contest) -> None:
    """The large table and the figure; and the costs."""
    write_cost(contest)
    items = [
        (ground, word, options, contest.sizes)
        for ground in contest.grounds
        for word, options in contest.everyone.items()
    ]
    rows = _compute(contest, tables.comparison_row, items, "schemes on surfaces")
    figure = cost_figure(_ladder(contest))
    _write(contest, "comparison", rows, figure=figure, figure_name="schemes-cost")


def _ladder(contest: Contest) -> dict[str, list[March]]:
    """The marches of each entrant on finer and finer meshes of one surface."""
    sizes = contest.sizes
    cases = [
        (case_of(options, GROUNDS[GROUND], v, sizes.tau, sizes.time),)
        for v in sizes.ladder
        for options in contest.entrants.values()
    ]
    marches = _compute(contest, march, cases, "error against seconds")
    n = len(contest.entrants)
    return {word: marches[i::n] for i, word in enumerate(contest.entrants)}


def write_orders(contest: Contest) -> None:
    """Orders for P_1, P_2, P_3."""
    everyone, sizes = contest.everyone, contest.sizes
    items = [(word, everyone[word], k, sizes) for k in sizes.degrees for word in everyone]
    rows = _compute(contest, tables.order_row, items, "orders")
    rows.sort(key=lambda row: list(everyone).index(row["scheme"]))
    _write(contest, "orders", rows)


def write_courses(contest: Contest) -> None:
    """A long flow: quality of the mesh and energy along t."""
    sizes = contest.sizes
    items = [
        (case_of(options, GROUNDS[GROUND], sizes.long_V, sizes.long_tau, sizes.long_time), False)
        for options in contest.entrants.values()
    ]
    marches = _compute(contest, march, items, "long flows")
    found = dict(zip(contest.entrants, marches, strict=True))
    rows = [tables.course_row(entrant, m) for entrant, m in found.items()]
    _write(contest, "course", rows, figure=course_figure(found))


PARTS: dict[str, Callable[[Contest], None]] = {
    "cost": write_cost,
    "comparison": write_comparison,
    "orders": write_orders,
    "course": write_courses,
}


def _compute(
    contest: Contest,
    function: Callable[..., Result],
    items: list[tuple],
    what: str,
    jobs: int | None = None,
) -> list[Result]:
    """``function`` of the members of each item, in processes."""
    return computed(
        lambda item: function(*item), items, jobs or contest.jobs, contest.console, what
    )


def _write(
    contest: Contest, part: str, rows: list[Row], figure_name: str = "", **more: Any
) -> None:
    """One extra, on disk and on the console."""
    texts = {name: told(text, contest) for name, text in TEXTS[part].items()}
    extra = Extra(**texts, table=[shown(row) for row in rows], **more)
    schemes = sorted({options["name"] for options in contest.entrants.values()})
    steps = {name: stepping_digest(scheme_file(name)) for name in schemes}
    write_extra(contest.folder, f"schemes-{part}", extra, figure_name, schemes=steps)
    contest.console.print(f"\n{extra.title}\n{extra.text}")
    table = tabulate(extra.table, headers="keys", disable_numparse=True)
    contest.console.print(table, soft_wrap=True)


def told(text: str, contest: Contest) -> str:
    """A text of `texts.toml` with its numbers; a ladder by its ends, "30 to 480"."""
    sizes = {
        name: f"{value[0]} to {value[-1]}" if isinstance(value, tuple) else value
        for name, value in asdict(contest.sizes).items()
    }
    return text.strip().format(
        **sizes,
        ground=GROUND,
        energies=TEXTS["both"]["energies"].strip(),
        decay_rate=tables.DECAY_RATE,
        steps=stability.STEPS,
        growth=stability.GROWTH,
        largest=stability.LARGEST,
    )
