"""The comparison of the schemes, written as extras of the report: tables, texts and figures."""

import tomllib
from collections.abc import Callable, Collection, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import Progress
from tabulate import tabulate

from esfem.campaigns.contest import entrant_run, scores
from esfem.campaigns.contest.contest import GROUNDS, Contest, case_of
from esfem.campaigns.contest.entrant_run import EntrantRun, run_entrant
from esfem.campaigns.contest.scores import Row, shown
from esfem.common.drawing import LINES, PALETTE, legend_below, series_look, styled, subplots
from esfem.common.provenance import stepping_digest
from esfem.report.extra import Extra, write_extra
from esfem.runs.executors import LocalProcesses
from esfem.schemes import scheme_file

GROUND = "red blood cell"  # of the figures
TEXTS = tomllib.loads(Path(__file__).with_name("texts.toml").read_text(encoding="utf-8"))
LABELS = {"distance": "distance of the surfaces", "W": "$W = \\frac{1}{2} \\int H_h^2$, relative"}
SIZE = (7.5, 3.4)

Result = TypeVar("Result")


def compare_schemes(contest: Contest, parts: Collection[str]) -> None:
    """Compute these `PARTS` of the comparison; write ``extra/schemes-*.json`` with figures."""
    wanted = set(parts) - ({"cost"} if "comparison" in parts else set())  # which writes it too
    for part, write in PARTS.items():
        if part in wanted:
            write(contest)


def computed(
    function: Callable[..., Result],
    items: Sequence[tuple[Any, ...]],
    jobs: int,
    console: Console,
    what: str,
) -> list[Result]:
    """``function`` of the members of each item, in their order, by processes of one thread each, so
    that seconds of the processor count; the last ones, which take longest, start first."""

    def numbered(pair: tuple[int, tuple[Any, ...]]) -> tuple[int, Result]:
        i, item = pair
        return i, function(*item)

    with LocalProcesses(jobs) as processes, Progress(console=console) as bar:
        results = processes.run(numbered, list(enumerate(items))[::-1])
        found = dict(result for _, result in bar.track(results, len(items), description=what))
    return [found[i] for i in range(len(items))]


def write_cost(contest: Contest) -> None:
    """Seconds a step, each alone on the machine."""
    items = [(word, options, contest.sizes) for word, options in contest.everyone.items()]
    rows = computed(scores.cost_row, items, 1, contest.console, "seconds per step")
    _write(contest, "cost", rows)


def write_comparison(contest: Contest) -> None:
    """The large table, and error against seconds on finer and finer meshes; and the costs."""
    write_cost(contest)
    jobs, console, sizes, entrants = contest.jobs, contest.console, contest.sizes, contest.entrants
    items = [
        (ground, word, options, sizes)
        for ground in contest.grounds
        for word, options in contest.everyone.items()
    ]
    rows = computed(scores.comparison_row, items, jobs, console, "schemes on surfaces")
    cases = [
        (case_of(options, GROUNDS[GROUND], v, sizes.tau, sizes.time),)
        for v in sizes.ladder
        for options in entrants.values()
    ]
    runs, n = computed(run_entrant, cases, jobs, console, "error against seconds"), len(entrants)
    figure = cost_figure({word: runs[i::n] for i, word in enumerate(entrants)})
    _write(contest, "comparison", rows, figure, "schemes-cost")


def write_orders(contest: Contest) -> None:
    """Orders for P_1, P_2, P_3."""
    everyone, sizes = contest.everyone, contest.sizes
    items = [(word, everyone[word], k, sizes) for k in sizes.degrees for word in everyone]
    rows = computed(scores.order_row, items, contest.jobs, contest.console, "orders")
    rows.sort(key=lambda row: list(everyone).index(row["scheme"]))
    _write(contest, "orders", rows)


def write_courses(contest: Contest) -> None:
    """A long flow: quality of the mesh and energy along t."""
    sizes = contest.sizes
    items = [
        (case_of(options, GROUNDS[GROUND], sizes.long_V, sizes.long_tau, sizes.long_time), False)
        for options in contest.entrants.values()
    ]
    runs = computed(run_entrant, items, contest.jobs, contest.console, "long flows")
    found = dict(zip(contest.entrants, runs, strict=True))
    rows = [scores.course_row(entrant, run) for entrant, run in found.items()]
    _write(contest, "course", rows, course_figure(found))


PARTS: dict[str, Callable[[Contest], None]] = {
    "cost": write_cost,
    "comparison": write_comparison,
    "orders": write_orders,
    "course": write_courses,
}


def _write(
    contest: Contest,
    part: str,
    rows: list[Row],
    figure: Figure | None = None,
    figure_name: str = "",
) -> None:
    """One extra, on disk and on the console."""
    texts = {name: told(text, contest) for name, text in TEXTS[part].items()}
    extra = Extra(table=[shown(row) for row in rows], figure=figure, **texts)
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
        decay_rate=scores.DECAY_RATE,
        steps=entrant_run.STEPS,
        growth=entrant_run.GROWTH,
        largest=entrant_run.LARGEST,
    )


@styled()
def cost_figure(found: dict[str, list[EntrantRun]]) -> Figure:
    """Distance and error of W at the end against seconds of the processor, a line a scheme, a
    marker a mesh; a cross at the top is a run that broke down."""
    figure, axes = subplots(1, 2, SIZE)
    for axis, name in zip(axes, LABELS, strict=True):
        for i, (entrant, runs) in enumerate(found.items()):
            ran = [(run.cpu, run.at("end", name)) for run in runs if run.ended == "ok"]
            axis.loglog(*np.array(ran).reshape(-1, 2).T, label=entrant, **series_look(i))
            for run in (run for run in runs if run.ended != "ok"):
                _cross_at_top(axis, run.cpu, i)
        axis.set_xlabel("CPU seconds")
        axis.set_title(LABELS[name], fontsize=9)
        axis.margins(0.08)
    axes[0].set_ylabel("error at the end")
    legend_below(figure, axes[0], most=4)
    return figure


def _cross_at_top(axis: Axes, cpu: float, i: int) -> None:
    """At these seconds; a first step that failed has none, and its cross stands at the left."""
    x, transform = (cpu, axis.get_xaxis_transform()) if cpu > 0 else (0.03, axis.transAxes)
    color = PALETTE[i % len(PALETTE)]
    axis.plot(x, 0.97, "x", color=color, transform=transform, gid=f"broken-{i}")


@styled()
def course_figure(found: dict[str, EntrantRun]) -> Figure:
    """Quality of the mesh and energy against time, a line a scheme; a cross is where it broke
    down."""
    figure, axes = subplots(1, 2, SIZE)
    for i, (entrant, run) in enumerate(found.items()):
        color, style = PALETTE[i % len(PALETTE)], LINES[i % len(LINES)]
        t, quality = run.levels["t"], np.array(run.levels["quality"])
        energy = np.array(run.levels["own_energy"]) / (8.0 * np.pi)
        for axis, values in zip(axes, (quality, energy), strict=True):
            axis.plot(t, values, style, color=color, label=entrant)
            if run.ended != "ok":
                axis.plot(t[-1], values[-1], "x", color=color, gid=f"broken-{i}")
    axes[0].set_title("least quality of a triangle", fontsize=9)
    axes[1].set_title("the scheme's own energy$\\;/\\;8 \\pi$", fontsize=9)
    for axis in axes:
        axis.set_xlabel("$t$")
        axis.margins(x=0.02)
    legend_below(figure, axes[0], most=4)
    return figure
